:- module(domain_qualitative,
          [ qualitative_state/3,        % +Device, +Settings, -State
            state_words/2,              % +State, -Text
            settings_words/3,           % +Device, +Settings, -Text
            brief_settings_words/3,     % +Device, +Settings, -Text
            shutter_words/2,            % +ShutterS, -Text
            similarity/3,               % +State1, +State2, -Similarity
            greatest_similarity/3,      % +State, +States, -Similarity
            image_quality/2             % +Statistics, -Quality
          ]).
/** <module> Qualitative states of lights and camera

The paper reasons about settings in a few words instead of numbers: how bright
the lights are together and where the light mostly comes from.  A state here
is

    state(Brightness, Direction, Exposure)

with `Brightness` one of `off`, `dim`, `medium`, `bright` (the lights' mean
output), `Direction` one of `none`, `even` or `from(Light)`, and `Exposure` the
whole number of stops above the reference exposure.
*/

:- use_module(device).
:- use_module(library(aggregate), [aggregate_all/3]).
:- use_module(library(apply), [maplist/4]).
:- use_module(library(lists), [max_list/2, member/2, nth1/3, sum_list/2]).
:- set_prolog_flag(optimise, true).     % arithmetic is compiled, here alone

% Constants. The paper gives no numbers for its words; these are chosen by hand.
brightness_below(dim, 0.34).            % mean output of the lights: thirds
brightness_below(medium, 0.67).
directed_share(0.6).                    % of the light: one that gives so much gives the direction
brightness_factor(0.7).                 % similarity for each step of brightness apart
exposure_factor(0.75).                  % and for each stop of exposure apart
even_and_directed(0.6).                 % similarity of even light and light from one side
other_directions(0.3).                  % and of any other two directions
glare_from(0.2).                        % share of saturated pixels
dark_highlight(0.08).                   % an image whose highlights are below this is dark,
dark_from(0.8).                         % as is one with this share of dark pixels
longest_in_fractions_s(0.5).            % shutters are written as 1/n s below this, where they are
as_fraction(0.02).                      % one nearly: a camera's 1/30 s may be 0.033

%!  qualitative_state(+Device, +Settings, -State) is det.

qualitative_state(Device, Settings, state(Brightness, Direction, Exposure)) :-
    Settings = settings(Levels, _, _),
    level_fractions(Device, Levels, Fractions),
    brightness(Fractions, Brightness),
    direction(Device, Fractions, Direction),
    exposure_stops(Device, Settings, Stops),
    Exposure is round(Stops).

brightness(Fractions, Brightness) :-
    sum_list(Fractions, Sum),
    length(Fractions, N),
    Mean is Sum / max(N, 1),
    (   Mean =:= 0 -> Brightness = off
    ;   brightness_below(Word, Limit), Mean < Limit -> Brightness = Word
    ;   Brightness = bright
    ).

% One light gives the direction when it gives well over half of the light.
direction(Device, Fractions, Direction) :-
    sum_list(Fractions, Sum),
    length(Fractions, N),
    (   Sum =:= 0
    ->  Direction = none
    ;   max_list(Fractions, Largest),
        N > 1,
        directed_share(Share),
        Largest / Sum >= Share
    ->  nth1(Index, Fractions, Largest),
        device_lights(Device, Lights),
        nth1(Index, Lights, light(Name, _)),
        Direction = from(Name)
    ;   Direction = even
    ),
    !.

%!  state_words(+State, -Text) is det.
%
%   A state as a person would say it: `bright from left, +1 stop`.

state_words(state(Brightness, Direction, Exposure), Text) :-
    direction_words(Direction, Where),
    exposure_words(Exposure, Words),
    format(string(Text), "~w~w, ~w", [Brightness, Where, Words]).

direction_words(none, "").
direction_words(even, " even").
direction_words(from(Light), Text) :-
    format(string(Text), " from ~w", [Light]).

exposure_words(Stops, Text) :-
    ( abs(Stops) =:= 1 -> Unit = stop ; Unit = stops ),
    ( Stops > 0 -> Sign = '+' ; Sign = '' ),
    format(string(Text), "~w~d ~w", [Sign, Stops, Unit]).

%!  settings_words(+Device, +Settings, -Text) is det.
%
%   Settings as a photographer writes them: `left 3 right 0 top 7, 1/60 s, f/4`; without lights `1/60 s, f/4`.

settings_words(Device, settings(Levels, Shutter, Aperture), Text) :-
    device_lights(Device, Lights),
    maplist(light_words, Lights, Levels, Words),
    atomic_list_concat(Words, ' ', LightWords),
    ( Lights == [] -> Comma = '' ; Comma = ', ' ),
    shutter_words(Shutter, ShutterWords),
    format(string(Text), "~w~w~w, f/~4g", [LightWords, Comma, ShutterWords, Aperture]).

%!  brief_settings_words(+Device, +Settings, -Text) is det.
%
%   The same where it fits a line; else with how many of the lights are lit.

brief_settings_words(Device, Settings, Text) :-
    settings_words(Device, Settings, Whole),
    (   string_length(Whole, Length),
        widest(Width),
        Length =< Width
    ->  Text = Whole
    ;   Settings = settings(Levels, Shutter, Aperture),
        level_fractions(Device, Levels, Fractions),
        aggregate_all(count, ( member(Fraction, Fractions), Fraction > 0 ), Lit),
        light_count(Device, Count),
        shutter_words(Shutter, ShutterWords),
        format(string(Text), "~d of ~d lights, ~w, f/~4g", [Lit, Count, ShutterWords, Aperture])
    ).

widest(80).                             % settings in a line; chosen by hand

light_words(light(Name, _), Level, Words) :-
    format(atom(Words), "~w ~w", [Name, Level]).

%!  shutter_words(+ShutterS, -Text) is det.

shutter_words(Shutter, Words) :-
    longest_in_fractions_s(Longest),
    Shutter < Longest,
    Denominator is round(1 / Shutter),
    as_fraction(Tolerance),
    abs(Denominator * Shutter - 1) =< Tolerance,
    !,
    format(string(Words), "1/~d s", [Denominator]).
shutter_words(Shutter, Words) :-
    format(string(Words), "~4g s", [Shutter]).

%!  similarity(+State1, +State2, -Similarity) is det.
%
%   How alike two states are, from 0 (nothing in common) to 1 (the same): the
%   product of how alike they are in brightness, in direction and in exposure.

similarity(state(B1, D1, E1), state(B2, D2, E2), Similarity) :-
    brightness_rank(B1, R1),
    brightness_rank(B2, R2),
    direction_similarity(D1, D2, Direction),
    brightness_factor(Brightness),
    exposure_factor(Exposure),
    Similarity is Direction * Brightness ** abs(R1 - R2) * Exposure ** abs(E1 - E2).

brightness_rank(off, 0).
brightness_rank(dim, 1).
brightness_rank(medium, 2).
brightness_rank(bright, 3).

direction_similarity(D, D, 1.0) :- !.
direction_similarity(even, from(_), S) :- !, even_and_directed(S).
direction_similarity(from(_), even, S) :- !, even_and_directed(S).
direction_similarity(_, _, S) :- other_directions(S).

%!  greatest_similarity(+State, +States, -Similarity) is det.
%
%   How alike State is to the one of States it is most like; 0 for none.

greatest_similarity(State, States, Similarity) :-
    findall(S, ( member(Other, States), similarity(State, Other, S) ), Similarities),
    max_list([0.0|Similarities], Similarity).

%!  image_quality(+Statistics, -Quality) is det.
%
%   What is wrong with an image, in one word: `dark`, `glare` or `good`.

image_quality(statistics(_, P95, Dark, Saturated, _), Quality) :-
    (   glare_from(Glare), Saturated > Glare -> Quality = glare
    ;   dark_highlight(Highlight), P95 < Highlight -> Quality = dark
    ;   dark_from(Share), Dark > Share -> Quality = dark
    ;   Quality = good
    ).
