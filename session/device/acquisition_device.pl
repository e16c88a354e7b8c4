:- module(session_acquisition_device,
          [ open_acquisition/1,         % +Options
            close_acquisition/0,
            can_execute/1,              % +Action
            execute/2,                  % +Action, -Sensing
            exogenous/1,                % -Actions
            resumed/1,                  % +Situation
            score_pose/3                % +Pose, +Where, -Error
          ]).
/** <module> The device that carries the controller's actions to the servers

Primitive actions that touch the world become requests to the vision server
(and, for moving the target, to the image server); replies come back as sensing
results, events as exogenous actions.  Pixels stay on the other side.

| Action             | Request              | Sensing result                       |
|--------------------|----------------------|--------------------------------------|
| connect            | start                | session(Device, Threshold, Limit)    |
| capture(Image, S)  | capture              | statistics(P50, P95, Dark, Saturated, BlurPx), with what came with it told(Statistics, Event), as under(Settings, Seen) where others were applied, and as same_as(Image, Seen) where it is that picture again |
| estimate(Images)   | estimate             | no_pose, or fix(...) as in merit.pl  |
| predict(Device, States, Images) | predict            | the best adds(Bits, Settings, Line), best first |
| appraise(Image)    | appraise             | the richest tone curve               |
| discard(Image, _)  | discard              |                                      |
| set_parameter(N,V) | parameters           |                                      |
| advance(RangeM)    | move, parameters     |                                      |
*/

:- use_module('../servers/connections').
:- use_module('../display/display', [show/2]).
:- use_module('../json_terms').
:- use_module('../strategy/named_actions', [check_parameters/2, doing/1]).
:- use_module('../strategy/not_offered', [check_instead/2]).
:- use_module('../servers/recovery').
:- use_module('../servers/servers', [captures_taken/1, own_server/1]).
:- use_module('../strategy/strategy_checks', [check_against_device/2]).
:- use_module(surprises).
:- use_module(told_beside, [forget_beside/0, note_beside/3]).
:- use_module('../../indigolog/indigolog', [fluent_value/3, situation_history/2]).
:- use_module('../../domain/reasoning/merit', [default_threshold/1]).
:- use_module('../../domain/reasoning/outlook').
:- use_module(library(apply), [maplist/3]).
:- autoload(library(filesex), [directory_file_path/3]).
:- use_module(library(lists), [append/3, member/2, memberchk/2]).
:- use_module(library(option), [option/2, option/3]).
:- use_module(library(pairs), [pairs_keys/2]).

:- dynamic
    opened_with/1,                      % Options
    own_move/0,                         % one for each move of ours that is not reported yet
    tolerance/1,                        % by what fraction settings may differ that the device takes for the same
    told_others/0.                      % it was said that other settings are applied than are asked for

%!  open_acquisition(+Options) is det.
%
%   Connect to the servers.  Options: image_server, vision_server, own and keys of open_connections/1, start(Args)
%   for the request `start`, threshold(Px), max_iterations(N).

open_acquisition(Options) :-
    close_acquisition,
    assertz(opened_with(Options)),
    option(start(Args), Options),
    open_recovery(Options, Args),
    open_connections([ waiting(session_recovery:look_after), gone(session_recovery:missed),
                       lost(session_recovery:brought_back) | Options ]).

%!  close_acquisition is det.

close_acquisition :-
    end_session,
    close_connections,
    retractall(opened_with(_)),
    retractall(own_move),
    retractall(tolerance(_)),
    forget_surprises,
    forget_beside,
    retractall(told_others).

                /*******************************
                *            ACTIONS           *
                *******************************/

%!  can_execute(+Action) is semidet.
%
%   The actions that touch the world.

can_execute(connect).
can_execute(capture(_, _)).
can_execute(estimate(_)).
can_execute(predict(_, _, _)).
can_execute(appraise(_)).
can_execute(discard(_, _)).
can_execute(set_parameter(_, _)).
can_execute(advance(_)).

%!  execute(+Action, -Sensing) is det.
%
%   @error error of bridge/prolog/client.pl when a server does not do it

execute(Action, Sensing) :-
    begin_action,
    doing(Action),
    carry_out(Action, Sensing),
    doing(none),
    end_action(Action).

carry_out(connect, session(Device, Threshold, Limit)) :-
    opened_with(Options),
    option(start(Args), Options),
    begin(Args, Result),
    server_started,
    show(Options, model(Result.model)),
    told_of_unknown_places(Options, Result.describe.lights),
    device_term(Result.describe, Device),
    option(controller_file(File), Options),
    check_against_device(File, Device),
    check_parameters(File, parameter_names),
    forall(option(instead(Words), Options), check_instead(Words, Device)),
    heard_of(Device, Result.describe),
    default_threshold(Default),
    option(threshold(Threshold), Options, Default),
    option(max_iterations(Limit), Options).
carry_out(capture(Image, Settings), Seen) :-
    settings_dict(Settings, Dict),
    (   own_server(image_server)        % whose captures are this session's: a frame is the same however often it is asked for
    ->  captures_taken(Taken),
        Number is Taken + 1,
        Args = _{image:Image, settings:Dict, number:Number}
    ;   Args = _{image:Image, settings:Dict}
    ),
    ask(vision_server, capture, Args, Result),
    came_with(Result),
    statistics_term(Result.statistics, Statistics),
    (   surprised(Image, Result, Event)
    ->  Seen0 = told(Statistics, Event)
    ;   Seen0 = Statistics
    ),
    (   others_applied(Settings, Result.applied, Applied)
    ->  told_of_others(Image, Result.applied),
        Seen1 = under(Applied, Seen0)
    ;   Seen1 = Seen0
    ),
    (   string(Result.get(repeats))
    ->  atom_string(Before, Result.repeats),
        Seen = same_as(Before, Seen1)
    ;   Seen = Seen1
    ).
carry_out(estimate(Images), Fix) :-
    ask(vision_server, estimate, _{images:Images}, Result),
    fix_term(Result, Fix),
    note_beside(Images, Fix, Result),
    judge_model(Images, Result).
carry_out(predict(_, _, []), []) :-
    !.
carry_out(predict(Device, Unfavourable, Images), Outlook) :-
    worth_predicting(Device, Unfavourable, Settings),
    Settings = [_|_],
    !,
    maplist(settings_dict, Settings, Dicts),
    settings_searched_for(Search),
    ask(vision_server, predict, _{settings:Dicts, images:Images, search:Search}, Result),
    maplist(outlook_term, Result.get(found, []), Foreseen),
    best_outlook(Device, Unfavourable, Foreseen, Outlook).
carry_out(predict(_, _, _), []).
carry_out(appraise(Image), Gamma) :-
    ask(vision_server, appraise, _{image:Image}, Result),
    Gamma = Result.gamma.
carry_out(discard(Image, _), true) :-
    ask(vision_server, discard, _{image:Image}, _).
carry_out(set_parameter(Name, Value), true) :-
    dict_pairs(Args, parameters, [Name-Value]),
    ask(vision_server, parameters, Args, _).
carry_out(advance(RangeM), true) :-
    ask(image_server, move, _{range_m:RangeM}, Result),
    came_with(Result),
    assertz(own_move),
    ask(vision_server, parameters, _{seed_pose:_{best_at_range_m:RangeM}}, _).

parameter_names(Names) :-
    ask(vision_server, parameters, _{}, Parameters),
    dict_pairs(Parameters, _, Pairs),
    pairs_keys(Pairs, Names).

settings_searched_for(32).             % the best may be of states to avoid; chosen by hand

outlook_term(Found, adds(Found.bits, Settings, Found.line)) :-
    settings_dict(Settings, Found.settings).

%!  resumed(+Situation) is det.
%
%   Take over a session that was interrupted in Situation.

resumed(Situation) :-
    situation_history(Situation, Newest),
    memberchk(connect, Newest),
    !,
    take_over(Situation),
    recall_surprises(Newest),
    fluent_value(device, Situation, Device),
    ask(image_server, describe, _{}, Description),
    heard_of(Device, Description).      % only now: the events of moves that were done again have been met
resumed(_).

heard_of(Device, Description) :-
    Device = device(_, _, _, _, _, Tolerance),
    assertz(tolerance(Tolerance)),
    listen(Description).

%   A session that is resumed and of which the journal has nothing may have frames: they are taken again, under the
%   same names.
begin(Args, Result) :-
    opened_with(Options),
    option(resume(_), Options),
    directory_file_path(Args.out, 'images/stack.toml', Frames),
    exists_file(Frames),
    !,
    ask(vision_server, restore, Args.put(_{images:[], discarded:[], told:[]}), Result).
begin(Args, Result) :-
    ask(vision_server, start, Args, Result).

%!  score_pose(+Pose, +Where, -Error) is semidet.
%
%   How far off a pose is, for the report; fails where the truth is not known.  Where is here, or after(N, All): where
%   the target stood after N of All moves that this session asked for.

score_pose(Pose, Where, Error) :-
    \+ given_up(image_server),
    pose_dict(Pose, Dict),
    stood(Where, Moves),
    catch(ask(image_server, score, Moves.put(pose, Dict), Result),
          error(server_error(unsupported, _, _), _), fail),
    Error = Result.error,
    is_dict(Error).

%   A server of the user's may have moved its target before this session.
stood(here, _{}).
stood(after(N, All), _{moves:Moves}) :-
    (   own_server(image_server)
    ->  Moves = N
    ;   ask(image_server, health, _{}, Health),
        integer(Health.get(moves)),
        Moves is N + max(0, Health.moves - All)
    ).

%   Once, what a prediction does without.
told_of_unknown_places(Options, Lights) :-
    findall(Name,
            ( member(Light, Lights), \+ ( get_dict(position, Light, Place), is_list(Place) ), get_dict(name, Light, Name) ),
            Names),
    ( Names == [] -> true ; show(Options, unknown_places(Names)) ).

%   An image under other settings than were asked for: a recorded frame, a light that died.  Said once.
told_of_others(Image, Applied) :-
    \+ told_others,
    !,
    assertz(told_others),
    opened_with(Options),
    show(Options, others_applied(Image, Applied)).
told_of_others(_, _).

%   Settings that were applied in place of those that were asked for.
others_applied(settings(Levels, Shutter, Aperture), Told, Applied) :-
    \+ ( Told.lights = Levels, close_to(Told.shutter_s, Shutter), close_to(Told.aperture, Aperture) ),
    settings_dict(Applied, Told).

close_to(Applied, Asked) :-
    tolerance(Tolerance),
    !,
    abs(Applied / Asked - 1) =< Tolerance.

                /*******************************
                *            EVENTS            *
                *******************************/

%!  exogenous(-Actions) is det.
%
%   What has happened since the last call, in order of arrival.

exogenous(Actions) :-
    new_events(Events),
    findall(Action, ( member(Event, Events), event_action(Event, Action), \+ ours(Action) ), Told),
    new_surprises(Surprises),
    append(Told, Surprises, Actions).

% The target moved because it was told to: advance/1 has said so.
ours(target_moved) :-
    retract(own_move).

event_action(Event, Action) :-
    atom_string(Name, Event.event),
    event_action(Name, Event.get(args, _{}), Action).

event_action(light_fault, Args, light_fault(Light)) :-
    (   string(Args.get(light))
    ->  atom_string(Light, Args.light)
    ;   throw(error(server_error(bad_reply, "The image server tells of a light_fault and not of which light.",
                                 "The event has args {\"light\": NAME}, NAME being one that `describe` tells."), _))
    ).
event_action(camera_fault, _, camera_fault).
event_action(sun_changed, _, sun_changed).
event_action(target_moved, _, target_moved).
