:- module(domain_candidates,
          [ candidate/2,                % +Device, -Settings
            unfavourable/3,             % +Device, +States, +Settings
            most_promising/4,           % +Device, +Experience, -Settings, -Why
            safest/2,                   % +Device, -Settings
            ranking/3,                  % +Device, +Experience, -Ranked
            best_exposure/4,            % +Device, +Readings, +Levels, -Settings
            bracket/2,                  % +Device, -Settings
            relit/4                     % +Device, +Settings, +Gamma, -Relit
          ]).
/** <module> Heuristic search over qualitative states

The space of settings is too large to try (7680 for three lights of eight
levels) and needs not be: settings in one qualitative state give images that
say much the same.  The search therefore looks at one representative of each
state and ranks them by

    promise = log2(worth) + likelihood_weight likelihood

where `worth` is the precision with which the image is predicted to place an
edge (prediction.pl: darkness, glare and blur all lower it) and `likelihood`
is how likely the image shares information with the set and adds to it: states
half alike are best, a repetition adds nothing, a stranger shares nothing.
States similar to an unfavourable one are left out while there are others.

Experience is experience(Readings, KeptStates, UnfavourableStates).
*/

:- use_module(device).
:- use_module(last_answer).
:- use_module(prediction).
:- use_module(qualitative).
:- use_module(library(aggregate), [aggregate_all/3]).
:- use_module(library(apply), [exclude/3, maplist/3, maplist/4]).
:- use_module(library(lists), [member/2, nth1/3, sum_list/2]).
:- set_prolog_flag(optimise, true).     % arithmetic is compiled, here alone

% Constants, chosen by hand on simulated sessions.
likelihood_weight(1.5).                 % likelihood 1 is worth as much as a precision 2.8 times as high
repetition(0.95).                       % states more alike than this are the same again
resemblance(0.7).                       % states more alike than this share what is wrong with them
unmet_light(Factor) :- member(Factor, [1/16, 1/4, 1, 2]).     % times what is expected of a scene no one has seen
metered_highlight(0.8).                 % of full scale: what an exposure program aims at
least_highlight(1.0e-6).                % against the logarithm of zero
rich(0.1).                              % a tone curve so near to none leaves an image as it is
gradient_gain(1.0).                     % of light, for what the curve is from none; half of it for less light
lights_first(0.2).                      % of its logarithm, that a turned shutter counts as missed light
relighting(Share) :- member(Share, [0.25, 0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0]).    % of all levels
common_fraction(Fraction) :- member(Fraction, [0, 1/3, 2/3, 1]).    % of all lights together
lone_fraction(Fraction) :- member(Fraction, [1/2, 1]).              % of one light alone

%!  candidate(+Device, -Settings) is nondet.
%
%   The representatives: lights off, all lights at a third, two thirds and full;
%   each light alone, half and full; all but one light at full; under each
%   shutter and aperture.

candidate(Device, settings(Levels, Shutter, Aperture)) :-
    lighting(Device, Levels),
    device_shutters(Device, Shutters),
    member(Shutter, Shutters),
    device_apertures(Device, Apertures),
    member(Aperture, Apertures).

lighting(Device, Levels) :-
    device_lights(Device, Lights),
    distinct_lightings(Lights, All),
    member(Levels, All).

distinct_lightings(Lights, Distinct) :-
    findall(Levels, lighting_of(Lights, Levels), All),
    sort(All, Distinct).

lighting_of(Lights, Levels) :-
    common_fraction(Fraction),
    maplist(at_fraction(Fraction), Lights, Levels).
lighting_of(Lights, Levels) :-
    nth1(Alone, Lights, _),
    lone_fraction(Fraction),
    findall(Level, ( nth1(Index, Lights, Light), alone(Index, Alone, Fraction, Light, Level) ), Levels).
lighting_of(Lights, Levels) :-
    nth1(Dark, Lights, _),
    findall(Level, ( nth1(Index, Lights, Light), all_but(Index, Dark, Light, Level) ), Levels).

alone(Index, Index, Fraction, Light, Level) :-
    !,
    at_fraction(Fraction, Light, Level).
alone(_, _, _, _, 0).

all_but(Index, Index, _, 0) :-
    !.
all_but(_, _, Light, Level) :-
    at_fraction(1, Light, Level).

at_fraction(_, light(_, dead(_)), Level) =>
    Level = 0.
at_fraction(Fraction, light(_, N), Level) =>
    Level is round(Fraction * (N - 1)).

%!  most_promising(+Device, +Experience, -Settings, -Why) is semidet.
%
%   The settings to try next and the reason, why(State, Promise, Prediction).
%   Equal promises are decided by the order of candidate/2, so a session is repeatable.

most_promising(Device, Experience, Settings, Why) :-
    ranking(Device, Experience, [ranked(_, Settings, Why)|_]).

%!  ranking(+Device, +Experience, -Ranked) is det.
%
%   Every candidate as ranked(MinusPromise, Settings, Why), the best first.  The last ranking is remembered: who tells
%   why settings were chosen asks for the one that they were chosen by.

ranking(Device, Experience, Ranked) :-
    last_answer(domain_candidates_ranking, Device-Experience, ranked(Device, Experience), Ranked).

ranked(Device, experience(Readings, Kept, Unfavourable), Ranked) :-
    fit(Device, Readings, Response),
    findall(ranked(Key, Settings, why(State, Promise, Prediction)),
            ( candidate(Device, Settings),
              qualitative_state(Device, Settings, State),
              predict_with(Device, Response, Settings, Prediction),
              promise(Prediction, State, Kept, Promise),
              Key is -Promise ),
            All),
    exclude(tried(Kept, Unfavourable), All, Fresh),
    (   Fresh == [] -> Eligible = All ; Eligible = Fresh ),
    sort(1, @=<, Eligible, Ranked).

%!  safest(+Device, -Settings) is det.
%
%   The settings whose image is worth most on average while nothing is known of the light: it may be any of
%   unmet_light/1.  What is too bright is lost, and says "at least"; what is too dark says how dark it is.

safest(Device, Settings) :-
    fit(Device, [], Response),
    findall(Lit, ( unmet_light(Factor), lit_by(Factor, Response, Lit) ), Responses),
    aggregate_all(max(Worth, S),
                  ( candidate(Device, S), total_worth(Device, Responses, S, Worth) ),
                  max(_, Settings)).

lit_by(Factor, response(Middle0, Highlight0, Blur), response(Middle, Highlight, Blur)) :-
    maplist(times(Factor), Middle0, Middle),
    maplist(times(Factor), Highlight0, Highlight).

total_worth(Device, Responses, Settings, Worth) :-
    aggregate_all(sum(Bits),
                  ( member(Response, Responses),
                    predict_with(Device, Response, Settings, Prediction),
                    information(Prediction, Bits) ),
                  Worth).

times(Factor, X, Y) :-
    Y is Factor * X.

promise(Prediction, State, Kept, Promise) :-
    likelihood(State, Kept, Likelihood),
    likelihood_weight(Weight),
    information(Prediction, Bits),
    Promise is Bits + Weight * Likelihood.

%   The likelihood that an image in State shares information with the kept ones
%   and adds to it.
likelihood(_, [], 0.0) :-
    !.
likelihood(State, Kept, Likelihood) :-
    greatest_similarity(State, Kept, S),
    Likelihood is 4 * S * (1 - S).

tried(Kept, Unfavourable, ranked(_, _, why(State, _, _))) :-
    (   greatest_similarity(State, Kept, S), repetition(Most), S > Most
    ;   resembles(Unfavourable, State)
    ),
    !.

resembles(Unfavourable, State) :-
    greatest_similarity(State, Unfavourable, S),
    resemblance(Most),
    S > Most.

%!  unfavourable(+Device, +States, +Settings) is semidet.
%
%   Settings are of a state like one of these.

unfavourable(Device, States, Settings) :-
    qualitative_state(Device, Settings, State),
    resembles(States, State).

%!  best_exposure(+Device, +Readings, +Levels, -Settings) is det.
%
%   Shutter and aperture that bring the highlights of the target nearest to
%   metered_highlight/1, as a camera's exposure program does.

best_exposure(Device, Readings, Levels, Settings) :-
    fit(Device, Readings, Response),
    metered_highlight(Wanted),
    least_highlight(Least),
    aggregate_all(min(Miss, S),
                  ( candidate_exposure(Device, Levels, S),
                    predict_with(Device, Response, S, prediction(_, Highlight, _, _)),
                    Miss is abs(log(max(Highlight, Least) / Wanted)) ),
                  min(_, Settings)).

candidate_exposure(Device, Levels, settings(Levels, Shutter, Aperture)) :-
    device_shutters(Device, Shutters),
    member(Shutter, Shutters),
    device_apertures(Device, Apertures),
    member(Aperture, Apertures).

%!  bracket(+Device, -Settings) is det.
%
%   All lights full under every shutter, shortest first, at the aperture nearest to the reference exposure's.

bracket(Device, Bracket) :-
    full_levels(Device, Levels),
    reference_settings(Device, settings(_, _, Aperture)),
    device_shutters(Device, Shutters),
    sort(0, @<, Shutters, Ascending),
    findall(settings(Levels, Shutter, Aperture), member(Shutter, Ascending), Bracket).

%!  relit(+Device, +Settings, +Gamma, -Relit) is det.
%
%   Settings with more light where the tone curve Gamma brightens, less where it darkens, as near as may be to
%   1 + gradient_gain (1 - Gamma) times what it was (half the gain for less light): all lights alike, and the shutter
%   where they do not reach.

relit(_, Settings, Gamma, Relit), rich(Near), abs(Gamma - 1) =< Near =>
    Relit = Settings.
relit(Device, settings(Levels0, Shutter0, Aperture), Gamma, Relit) =>
    gradient_gain(Gain),
    ( Gamma < 1 -> Factor is 1 + Gain * (1 - Gamma) ; Factor is 1 + 0.5 * Gain * (1 - Gamma) ),
    device_shutters(Device, Shutters),
    light_of(Device, Levels0, Light0),
    lights_first(Preference),
    aggregate_all(min(Miss, settings(Levels, Shutter, Aperture)),
                  ( relighting(Share),
                    scaled(Device, Share, Levels0, Levels),
                    light_of(Device, Levels, Light),
                    member(Shutter, Shutters),
                    Wrong is abs(log(Light * Shutter / (Light0 * Shutter0 * Factor))),
                    Turned is abs(log(Shutter / Shutter0)),
                    Miss is Wrong + Preference * Turned ),
                  min(_, Relit)).

%   One level keeps a light on, so that more can come of it.
scaled(Device, Share, Levels0, Levels) :-
    device_lights(Device, Lights),
    maplist(scaled_level(Share), Lights, Levels0, Levels).

scaled_level(_, light(_, dead(_)), _, Level) =>
    Level = 0.
scaled_level(Share, light(_, N), Level0, Level) =>
    Level is min(N - 1, max(min(1, Level0), round(Share * Level0))).

light_of(Device, Levels, Light) :-
    level_fractions(Device, Levels, Fractions),
    sum_list(Fractions, Sum),
    Light is max(Sum, 0.01).
