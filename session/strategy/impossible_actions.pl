:- module(session_impossible_actions,
          [ blocked/4                   % +File, +Action, +Situation, -Message
          ]).
/** <module> Why an action of a strategy that runs is not possible, in plain words with its place
*/

:- use_module(not_offered, [settings_problem/3]).
:- use_module(strategy_file, [places_of/3]).
:- use_module('../../indigolog/indigolog', [fluent_value/3]).
:- use_module(library(lists), [member/2, memberchk/2]).

%!  blocked(+File, +Action, +Situation, -Message) is semidet.
%
%   Why an action of the theory is not possible in Situation, and where in the strategy it may be.

blocked(File, Action, Situation, Message) :-
    fluent_value(device, Situation, Device),
    fluent_value(candidate, Situation, Candidate),
    fluent_value(measured, Situation, Measured),
    fluent_value(settings, Situation, Settings),
    why(Action, state(Device, Candidate, Measured, Settings), Format, Arguments),
    format(string(Why), Format, Arguments),
    functor(Action, Name, _),
    findall(Doer, done_by(Name, Doer), Doers),
    places_of(File, Doers, Place),
    format(string(Message), "~w: ~s", [Place, Why]).

why(choose(S), state(Device, _, _, _), "~s", [Problem]) :-
    settings_problem(Device, S, Problem).
why(capture(_, _), state(_, Image, _, _), "the image ~w is neither kept nor discarded yet: keep_image or drop_image it first",
    [Image]) :-
    Image \== none.
why(capture(_, _), state(_, _, _, unknown), "an image is taken without settings: choose some first, for example choose_random", []).
why(capture(_, S), state(_, _, _, Settings), "an image is taken under the settings that were chosen: choose them first", []) :-
    S \= Settings.
why(Action, state(_, none, _, _), "there is no image to ~w: take_image first", [Name]) :-
    member(Action-Name, [keep(_)-keep, discard(_, _)-discard]).
why(Action, state(_, Candidate, _, _), "~w is not the image that was taken last: that is ~w", [Image, Candidate]) :-
    member(Action, [keep(Image), discard(Image, _)]),
    Image \== Candidate.
why(keep(Image), state(_, Image, Measured, _), "the image ~w is kept before it is measured: measure comes first", [Image]) :-
    \+ memberchk(Image, Measured).
why(Action, state(_, Image, _, _), "the image ~w is neither kept nor discarded yet: keep_image or drop_image it first", [Image]) :-
    memberchk(Action, [advance(_), start_over]),
    Image \== none.
why(estimate([]), _, "there is no image to measure: take_image first", []).

%   done_by(?Name, -Doer): what a strategy writes that does the action of that name.
done_by(capture, capture(_, _)).
done_by(capture, take_image).
done_by(keep, keep(_)).
done_by(keep, keep_image).
done_by(discard, discard(_, _)).
done_by(discard, drop_image(_)).
done_by(choose, choose(_)).
done_by(estimate, estimate(_)).
done_by(estimate, measure).
done_by(advance, advance(_)).
done_by(start_over, start_over).
