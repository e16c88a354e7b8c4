:- module(session_acquisition_device,
          [ open_acquisition/1,         % +Options
            close_acquisition/0,
            can_execute/1,              % +Action
            execute/2,                  % +Action, -Sensing
            exogenous/1,                % -Actions
            resumed/1,                  % +Situation
            score_pose/2                % +Pose, -Error
          ]).
:- use_module(connections).
:- use_module(forms).
:- use_module('../indigolog/indigolog', [fluent_value/3, situation_history/2]).
:- use_module('../domain/reasoning/merit', [default_threshold/1]).
:- use_module(library(lists), [member/2, memberchk/2, nth1/3, reverse/2, subtract/3]).
:- use_module(library(option), [option/2, option/3]).

/** <module> The device that carries the controller's actions to the servers

Primitive actions that touch the world become requests to the vision server
(and, for moving the target, to the image server); replies come back as sensing
results, events as exogenous actions.  Pixels stay on the other side.

| Action             | Request              | Sensing result                       |
|--------------------|----------------------|--------------------------------------|
| connect            | start                | session(Device, Threshold, Limit)    |
| capture(Image, S)  | capture              | statistics(P50, P95, Dark, Saturated, BlurPx) |
| estimate(Images)   | estimate             | no_pose, or fix(...) as in merit.pl  |
| discard(Image, _)  | discard              |                                      |
| set_parameter(N,V) | parameters           |                                      |
| advance(RangeM)    | move, parameters     |                                      |
*/

:- dynamic
    opened_with/1,                      % Options
    own_move/0.                         % one for each move of ours that is not reported yet

%!  open_acquisition(+Options) is det.
%
%   Connect to the servers.  Options: those of open_connections/1, start(Args) for
%   the request `start`, threshold(Px), max_iterations(N).

open_acquisition(Options) :-
    close_acquisition,
    assertz(opened_with(Options)),
    open_connections(Options).

%!  close_acquisition is det.

close_acquisition :-
    close_connections,
    retractall(opened_with(_)),
    retractall(own_move).

                /*******************************
                *            ACTIONS           *
                *******************************/

%!  can_execute(+Action) is semidet.
%
%   The actions that touch the world.

can_execute(connect).
can_execute(capture(_, _)).
can_execute(estimate(_)).
can_execute(discard(_, _)).
can_execute(set_parameter(_, _)).
can_execute(advance(_)).

%!  execute(+Action, -Sensing) is det.
%
%   @error error of bridge/prolog/client.pl when a server does not do it

execute(connect, session(Device, Threshold, Limit)) :-
    opened_with(Options),
    option(start(Args), Options),
    ask(vision_server, start, Args, Result),
    device_term(Result.describe, Device),
    listen(Result.describe),
    default_threshold(Default),
    option(threshold(Threshold), Options, Default),
    option(max_iterations(Limit), Options).
execute(capture(Image, Settings), Statistics) :-
    settings_dict(Settings, Dict),
    ask(vision_server, capture, _{image:Image, settings:Dict}, Result),
    statistics_term(Result.statistics, Statistics).
execute(estimate(Images), Fix) :-
    ask(vision_server, estimate, _{images:Images}, Result),
    fix_term(Result, Fix).
execute(discard(Image, _), true) :-
    ask(vision_server, discard, _{image:Image}, _).
execute(set_parameter(Name, Value), true) :-
    dict_pairs(Args, parameters, [Name-Value]),
    ask(vision_server, parameters, Args, _).
execute(advance(RangeM), true) :-
    ask(image_server, move, _{range_m:RangeM}, _),
    assertz(own_move),
    ask(vision_server, parameters, _{seed_pose:_{best_at_range_m:RangeM}}, _).

%!  resumed(+Situation) is det.
%
%   Take over a session that was interrupted in Situation: the vision server gets
%   its images back, and with them what its best estimate, seed pose and parameters came
%   from; an image server that has not moved its target as often as we asked does so.

resumed(Situation) :-
    situation_history(Situation, Newest),
    memberchk(connect, Newest),
    !,
    opened_with(Options),
    option(start(Args), Options),
    fluent_value(image_set, Situation, Kept),
    fluent_value(candidate, Situation, Candidate),
    findall(Image, ( member(kept(Image, _), Kept) ; Candidate \== none, Image = Candidate ), Newer),
    reverse(Newer, Images),
    findall(Image, member(capture(Image, _), Newest), Taken),
    subtract(Taken, Images, Discarded),
    reverse(Newest, Oldest),
    findall(Step, ( member(Event, Oldest), told_step(Event, Step) ), Told),
    ask(vision_server, restore, Args.put(_{images:Images, discarded:Discarded, told:Told}), Result),
    findall(RangeM, member(advance(RangeM), Oldest), Ranges),
    move_again(Ranges),
    listen(Result.describe).            % only now: the events of these moves have been met
resumed(_).

told_step(e(estimate(_), Fix), _{estimate:Estimate}) :-
    Fix = fix(_, _, _, _),
    fix_dict(Fix, Dict),
    del_dict(lines, Dict, _, Estimate).
told_step(set_parameter(Name, Value), _{parameters:Parameters}) :-
    dict_pairs(Parameters, parameters, [Name-Value]).
told_step(advance(RangeM), _{parameters:_{seed_pose:_{best_at_range_m:RangeM}}}).

move_again([]) :-
    !.
move_again(Ranges) :-
    ask(image_server, health, _{}, Health),
    ( integer(Health.get(moves)) -> Done = Health.moves ; Done = 0 ),
    forall(( nth1(N, Ranges, RangeM), N > Done ), ask(image_server, move, _{range_m:RangeM}, _)).

%!  score_pose(+Pose, -Error) is semidet.
%
%   How far off a pose is, for the report; fails where the truth is not known.

score_pose(Pose, Error) :-
    pose_dict(Pose, Dict),
    catch(ask(image_server, score, _{pose:Dict}, Result),
          error(server_error(unsupported, _, _), _), fail),
    Error = Result.error,
    is_dict(Error).

                /*******************************
                *            EVENTS            *
                *******************************/

%!  exogenous(-Actions) is det.
%
%   What has happened since the last call, in order of arrival.

exogenous(Actions) :-
    arrived(Events),
    findall(Action, ( member(Event, Events), event_action(Event, Action), \+ ours(Action) ), Actions).

% The target moved because it was told to: advance/1 has said so.
ours(target_moved) :-
    retract(own_move).

event_action(Event, Action) :-
    atom_string(Name, Event.event),
    event_action(Name, Event.args, Action).

event_action(light_fault, Args, light_fault(Light)) :-
    atom_string(Light, Args.light).
event_action(camera_fault, _, camera_fault).
event_action(sun_changed, _, sun_changed).
event_action(target_moved, _, target_moved).
