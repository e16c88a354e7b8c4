:- module(session_restoration,
          [ known_again/2,              % +Situation, -Known
            told_again/2,               % +Newest, -Told
            unmet_surprise/2            % +Newest, -Event
          ]).
/** <module> What a vision server is told that has to know again what another one knew

Images are in the run folder; what it answered and was told is in the situation.
*/

:- use_module('../json_terms', [fix_dict/2]).
:- use_module('../../domain/reasoning/surprises', [event_seen/2]).
:- use_module('../../indigolog/indigolog', [fluent_value/3, situation_history/2]).
:- use_module(library(lists), [append/3, member/2, memberchk/2, reverse/2, subtract/3]).

%!  known_again(+Situation, -Known) is det.
%
%   What the request `restore` says beside what `start` said.

known_again(Situation, _{images:Images, discarded:Discarded, told:Told, doubted:Doubted}) :-
    fluent_value(image_set, Situation, Kept),
    fluent_value(candidate, Situation, Candidate),
    findall(Image, ( member(kept(Image, _), Kept) ; Candidate \== none, Image = Candidate ), Newer),
    reverse(Newer, Images),
    situation_history(Situation, Newest),
    findall(Image, member(capture(Image, _), Newest), Taken),
    subtract(Taken, Images, Discarded),
    told_again(Newest, Told),
    doubted(Newest, Doubted).

%!  told_again(+Newest, -Told) is det.
%
%   Of a history, newest action first: what best estimate, seed pose, parameters and predictions depend on, in order of
%   time.

told_again(Newest, Told) :-
    findall(Step, ( append(_, [Event|Older], Newest), told_step(Event, Older, Step) ), Steps),
    reverse(Steps, Told).

told_step(e(estimate(_), Fix), _, _{estimate:Estimate}) :-
    Fix = fix(_, _, _, _),
    fix_dict(Fix, Dict),
    del_dict(lines, Dict, _, Estimate).
told_step(set_parameter(Name, Value), _, _{parameters:Parameters}) :-
    dict_pairs(Parameters, parameters, [Name-Value]).
told_step(advance(RangeM), _, _{parameters:_{seed_pose:_{best_at_range_m:RangeM}}}).
told_step(e(predict(_, _, [_|_]), _), _, _{predicted:true}).
told_step(discard(Image, _), _, _{discarded:Image}).
told_step(e(capture(_, _), Seen), _, Step) :-
    event_seen(Seen, surprise(Since, Cause)),
    Cause =.. [Name|Lights],
    happened(Name, Lights, Since, Step).
told_step(Event, Older, Step) :-        % published with the image before it
    memberchk(Event, [target_moved, sun_changed]),
    memberchk(e(capture(Image, _), _), Older),
    happened(Event, [], Image, Step).

happened(Name, Lights, Since, _{happened:_{cause:Name, lights:Lights, since:Since}}).

%   The image before which something may have happened, where the last image has that doubted, or null.
doubted(Newest, Since) :-
    memberchk(e(capture(_, _), Seen), Newest),
    event_seen(Seen, doubt(Since, _)),
    !.
doubted(_, null).

%!  unmet_surprise(+Newest, -Event) is semidet.
%
%   What came with the last image of a history that was cut before it became an action of its own.

unmet_surprise(Newest, Event) :-
    append(Newer, [e(capture(_, _), Seen)|_], Newest),
    !,
    event_seen(Seen, Event),
    \+ memberchk(Event, Newer).
