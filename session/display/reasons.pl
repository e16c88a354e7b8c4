:- module(session_reasons,
          [ decision_reason/3,          % +Action, +Situation, -Reason
            reason_dict/3               % +Device, +Reason, -Dict
          ]).
/** <module> Why a setting was chosen, and what came of it

All of it follows from the situation after an action, so that it can be told of a session that runs and, from its
journal, of one that has ended.
*/

:- use_module('../json_terms', [settings_dict/2]).
:- use_module('../../domain/reasoning/candidates').
:- use_module('../../domain/reasoning/image_set').
:- use_module('../../domain/reasoning/merit').
:- use_module('../../domain/reasoning/prediction').
:- use_module('../../domain/reasoning/qualitative').
:- use_module('../../indigolog/indigolog', [fluent_value/3, situation_history/2]).
:- use_module(library(aggregate), [aggregate_all/3]).
:- use_module(library(apply), [maplist/3]).
:- use_module(library(lists), [append/3, member/2, memberchk/2]).

most_shown(5).                          % as many as are remembered (domain/reasoning/outlook.pl)

%!  decision_reason(+Action, +Situation, -Reason) is semidet.
%
%   Reason is one of
%
%     * chosen(Settings, Why, Best, Count, left_out(Alike, Unfavourable)): Why is of the settings, or `none` where they
%       are no candidate (drawn at random, or fixed); Best are the most promising candidates of Count, as ranking/3
%       gives them; so many were not considered because their states are too like a kept image's, or like an
%       unfavourable one.  Where settings were chosen for what they were predicted to add, Why is
%       adds(Bits, Line, Prediction), Best are those that add most, and Alike is 0
%     * seen(Statistics, Quality, Prediction): an image, and what was expected of it before
%     * measured(Fix, Merit, MeritBefore)

decision_reason(choose(Settings), Situation, chosen(Settings, Why, Best, Count, left_out(0, LeftOut))) :-
    foreseen_now(Situation, Outlook),
    memberchk(adds(_, Settings, _), Outlook),
    !,
    fluent_value(device, Situation, Device),
    fluent_value(readings, Situation, Readings),
    fluent_value(unfavourable, Situation, Unfavourable),
    maplist(foreseen(Device, Readings), Outlook, Best),
    memberchk(ranked(_, Settings, Why), Best),
    aggregate_all(count, candidate(Device, _), Count),
    like_unfavourable(Device, Unfavourable, LeftOut).
decision_reason(choose(Settings), Situation, chosen(Settings, Why, Best, Count, left_out(Alike, Resembling))) :-
    fluent_value(device, Situation, Device),
    fluent_value(readings, Situation, Readings),
    fluent_value(image_set, Situation, ImageSet),
    fluent_value(unfavourable, Situation, Unfavourable),
    kept_states(ImageSet, Kept),
    ranking(Device, experience(Readings, Kept, Unfavourable), Ranked),
    ( memberchk(ranked(_, Settings, Found), Ranked) -> Why = Found ; Why = none ),
    most_shown(Most),
    length(Shown, Most),
    ( append(Shown, _, Ranked) -> Best = Shown ; Best = Ranked ),
    aggregate_all(count, candidate(Device, _), Count),
    length(Ranked, Considered),
    (   Considered =:= Count            % none, or all of them: then they are all considered
    ->  Alike = 0,
        Resembling = 0
    ;   like_unfavourable(Device, Unfavourable, Resembling),
        Alike is Count - Considered - Resembling
    ).
decision_reason(capture(_, _), Situation, seen(Statistics, Quality, Prediction)) :-
    fluent_value(device, Situation, Device),
    fluent_value(applied, Situation, Settings),
    fluent_value(statistics, Situation, Statistics),
    fluent_value(readings, Situation, [_|Before]),
    image_quality(Statistics, Quality),
    predict(Device, Before, Settings, Prediction).
decision_reason(estimate(_), Situation, measured(Fix, New, Old)) :-
    fluent_value(fix, Situation, Fix),
    fluent_value(merit, Situation, Old),
    merit(Fix, New).

like_unfavourable(Device, Unfavourable, Count) :-
    aggregate_all(count, ( candidate(Device, Settings), unfavourable(Device, Unfavourable, Settings) ), Count).

%   What was predicted since the last image.
foreseen_now(Situation, Outlook) :-
    situation_history(Situation, History),
    once(( member(Action, History), memberchk(Action, [predict(_, _, _), capture(_, _)]) )),
    Action = predict(_, _, _),
    fluent_value(outlook, Situation, Outlook).

foreseen(Device, Readings, adds(Bits, Settings, Line), ranked(Bits, Settings, adds(Bits, Line, Prediction))) :-
    predict(Device, Readings, Settings, Prediction).

%!  reason_dict(+Device, +Reason, -Dict) is det.
%
%   For JSON; brightness in fractions of full scale, blur in px, information in bit.

reason_dict(Device, chosen(Settings, Why, Best, Count, left_out(Alike, Unfavourable)), Dict) =>
    candidate_dict(Device, ranked(_, Settings, Why), Chosen),
    maplist(candidate_dict(Device), Best, BestDicts),
    Dict = _{kind:chosen, chosen:Chosen, best:BestDicts, candidates:Count, left_out_alike:Alike,
             left_out_unfavourable:Unfavourable}.
reason_dict(_, seen(statistics(P50, P95, Dark, Saturated, Blur), Quality, Prediction), Dict) =>
    prediction_dict(Prediction, Expected),
    ( number(Blur) -> BlurPx = Blur ; BlurPx = null ),
    Dict = _{kind:seen, quality:Quality, expected:Expected,
             seen:_{brightness:P50, highlight:P95, blur_px:BlurPx, dark:Dark, saturated:Saturated}}.
reason_dict(_, measured(Fix, New, _), Dict) =>
    ( Fix == none -> Rms = null ; fix_rms(Fix, Rms) ),
    Dict = _{kind:measured, rms_px:Rms, merit:New}.

candidate_dict(Device, ranked(_, Settings, Why), Dict) :-
    settings_words(Device, Settings, Words),
    settings_dict(Settings, SettingsDict),
    Named = _{words:Words, settings:SettingsDict},
    (   Why = why(State, Promise, Prediction)
    ->  state_words(State, StateWords),
        prediction_dict(Prediction, Predicted),
        Likelihood is Promise - Predicted.information,
        Dict = Named.put(_{state:StateWords, promise:Promise, likelihood:Likelihood}).put(Predicted)
    ;   Why = adds(Bits, Line, Prediction)
    ->  qualitative_state(Device, Settings, State),
        state_words(State, StateWords),
        prediction_dict(Prediction, Predicted),
        Dict = Named.put(_{state:StateWords, bits:Bits, line:Line}).put(Predicted)
    ;   Dict = Named
    ).

prediction_dict(prediction(Brightness, Highlight, Blur, Variance),
                _{brightness:Brightness, highlight:Highlight, blur_px:Blur, information:Information}) :-
    information(prediction(Brightness, Highlight, Blur, Variance), Information).
