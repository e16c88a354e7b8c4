:- module(session_acquisition_device,
          [ open_acquisition/1,         % +Options
            close_acquisition/0,
            can_execute/1,              % +Action
            execute/2,                  % +Action, -Sensing
            exogenous/1,                % -Actions
            resumed/1,                  % +Situation
            score_pose/2,               % +Pose, -Error
            seconds_spent/2             % -Waiting, -Parts
          ]).
:- use_module('../bridge/prolog/client').
:- use_module('../bridge/prolog/keys', [client_keys/4]).
:- use_module('../indigolog/indigolog', [fluent_value/3, situation_history/2]).
:- use_module('../domain/reasoning/merit', [default_threshold/1]).
:- use_module(library(apply), [maplist/2, maplist/3]).
:- use_module(library(lists), [append/3, member/2, memberchk/2, reverse/2, subtract/3, sum_list/2]).
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
    connection/2,                       % Name, Client or subscription
    own_move/0,                         % one for each move of ours that is not reported yet
    opened_with/1,                      % Options
    spent/2.                            % Part, Seconds

%!  open_acquisition(+Options) is det.
%
%   Connect to the servers.  Options: image_server(Endpoint),
%   vision_server(Endpoint), alive(:Goal) called while waiting, timeout(Seconds) of
%   a request, start(Args) for the request `start`, threshold(Px), max_iterations(N),
%   keys(Folder) with CURVE keys.

open_acquisition(Options) :-
    close_acquisition,
    assertz(opened_with(Options)),
    forall(member(Name, [image_server, vision_server]),
           ( Option =.. [Name, Endpoint],
             option(Option, Options),
             open_server(Name, Endpoint, Options) )).

open_server(Name, Endpoint, Options) :-
    option(alive(Alive), Options, true),
    option(timeout(Seconds), Options, 60),
    curve(Name, Options, Curve),
    client_open(Endpoint, Client, [alive(Alive), timeout(Seconds)|Curve]),
    assertz(connection(Name, Client)).

curve(Server, Options, [Curve]) :-
    option(keys(Folder), Options),
    !,
    client_keys(Folder, controller, Server, Curve).
curve(_, _, []).

%!  close_acquisition is det.

close_acquisition :-
    forall(retract(connection(Name, Connection)), close_connection(Name, Connection)),
    retractall(opened_with(_)),
    retractall(spent(_, _)),
    retractall(own_move).

close_connection(events, Subscription) =>
    events_close(Subscription).
close_connection(_, Client) =>
    client_close(Client).

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
    request(vision_server, start, Args, Result),
    Description = Result.describe,
    device_term(Description, Device),
    subscribe(Description),
    default_threshold(Default),
    option(threshold(Threshold), Options, Default),
    option(max_iterations(Limit), Options).
execute(capture(Image, Settings), Statistics) :-
    settings_dict(Settings, Dict),
    request(vision_server, capture, _{image:Image, settings:Dict}, Result),
    statistics_term(Result.statistics, Statistics).
execute(estimate(Images), Fix) :-
    request(vision_server, estimate, _{images:Images}, Result),
    fix_term(Result, Fix).
execute(discard(Image, _), true) :-
    request(vision_server, discard, _{image:Image}, _).
execute(set_parameter(Name, Value), true) :-
    dict_pairs(Args, parameters, [Name-Value]),
    request(vision_server, parameters, Args, _).
execute(advance(RangeM), true) :-
    request(image_server, move, _{range_m:RangeM}, _),
    assertz(own_move),
    request(vision_server, parameters, _{seed_pose:_{best_at_range_m:RangeM}}, _).

%!  resumed(+Situation) is det.
%
%   Take over a session that was interrupted in Situation: the vision server gets
%   its images back, and is told again what it had been told.

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
    request(vision_server, restore, Args.put(_{images:Images, discarded:Discarded}), Result),
    subscribe(Result.describe),
    reverse(Newest, Oldest),
    forall(( member(Action, Oldest), Action = set_parameter(_, _) ), execute(Action, _)).
resumed(_).

request(Name, Op, Args, Result) :-
    connection(Name, Client),
    client_request(Client, Op, Args, Result, []),
    (   get_dict(seconds, Result, Seconds)
    ->  dict_pairs(Seconds, _, Pairs),
        maplist(add_seconds, Pairs)
    ;   true
    ).

add_seconds(Part-Seconds) :-
    ( retract(spent(Part, Before)) -> true ; Before = 0.0 ),
    After is Before + Seconds,
    assertz(spent(Part, After)).

%!  seconds_spent(-Waiting, -Parts) is det.
%
%   How long this side waited for replies so far, and where the servers' time went,
%   as Part-Seconds pairs.

seconds_spent(Waiting, Parts) :-
    findall(Part-Seconds, spent(Part, Seconds), Parts),
    findall(Seconds,
            ( connection(Name, Client), Name \== events, client_seconds(Client, Seconds) ),
            All),
    sum_list(All, Waiting).

%!  score_pose(+Pose, -Error) is semidet.
%
%   How far off a pose is, for the report; fails where the truth is not known.

score_pose(pose(Rotation, Translation), Error) :-
    connection(image_server, Client),
    catch(client_request(Client, score,
                         _{pose:_{rotation_vector:Rotation, translation:Translation}},
                         Result, []),
          error(server_error(unsupported, _, _), _), fail),
    Error = Result.error,
    is_dict(Error).

                /*******************************
                *            EVENTS            *
                *******************************/

subscribe(Description) :-
    string(Description.get(events)),
    !,
    opened_with(Options),
    (   option(image_server(Server), Options)
    ->  reachable(Description.events, Server, Events)
    ;   Events = Description.events
    ),
    curve(image_server, Options, Curve),
    events_open(Events, Subscription, Curve),
    assertz(connection(events, Subscription)).
subscribe(_).

%   A server that listens on every interface cannot know under which name it is called.
reachable(Events, Server, Reachable) :-
    member(Everywhere, ["tcp://0.0.0.0:", "tcp://[::]:"]),
    string_concat(Everywhere, Port, Events),
    !,
    split_string(Server, ":", "", Parts),
    append(Host, [_], Parts),
    append(Host, [Port], Named),
    atomic_list_concat(Named, :, Reachable).
reachable(Events, _, Events).

%!  exogenous(-Actions) is det.
%
%   What has happened since the last call, in order of arrival.

exogenous(Actions) :-
    connection(events, Subscription),
    !,
    events_poll(Subscription, Events),
    findall(Action,
            ( member(Event, Events), event_action(Event, Action), \+ ours(Action) ),
            Actions).
exogenous([]).

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

                /*******************************
                *        DICTS AND TERMS       *
                *******************************/

device_term(D, device(Lights, D.shutters_s, D.apertures, sensor(Gain, ReadE, FullWellE, Gamma),
                      exposure(Shutter, Aperture))) :-
    maplist(light_term, D.lights, Lights),
    Camera = D.camera,
    Gain = Camera.gain,
    ReadE = Camera.read_noise_e,
    FullWellE = Camera.full_well_e,
    Gamma = Camera.gamma,
    Shutter = D.reference.shutter_s,
    Aperture = D.reference.aperture.

light_term(Dict, light(Name, Dict.levels)) :-
    atom_string(Name, Dict.name).

settings_dict(settings(Levels, Shutter, Aperture),
              _{lights:Levels, shutter_s:Shutter, aperture:Aperture}).

statistics_term(S, statistics(S.p50, S.p95, S.dark_fraction, S.saturated_fraction, Blur)) :-
    (   number(S.get(blur_px)) -> Blur = S.blur_px ; Blur = unknown ).

fix_term(Result, no_pose) :-
    Result.pose == null,
    !.
fix_term(R, fix(pose(R.pose.rotation_vector, R.pose.translation), R.covariance,
                quality(R.rms_px, R.uncertainty, R.supported_fraction, R.score, R.ambiguity),
                Lines)) :-
    maplist(line_term, R.lines, Lines).

line_term(L, line(L.line, L.visible_px, L.support, L.rms_px)).
