:- module(session_connections,
          [ open_connections/1,         % +Options
            end_session/0,
            close_connections/0,
            ask/4,                      % +Server, +Op, +Args, -Result
            has_answered/1,             % +Server
            given_up/1,                 % +Server
            listen/1,                   % +Description
            listen_again/0,
            arrived/1,                  % -Events
            seconds_spent/2,            % -Waiting, -Parts
            waits_for_server/0
          ]).
/** <module> The session's connections: to both servers, and to the image server's events */

:- use_module('../../bridge/prolog/client').
:- autoload('../../bridge/prolog/keys', [client_keys/4]).
:- use_module('../../bridge/prolog/zmq', [zmq_clock/1]).
:- use_module(presence).
:- use_module(library(apply), [maplist/2]).
:- use_module(library(lists), [append/3, member/2, memberchk/2, sum_list/2]).
:- use_module(library(option), [option/2]).

:- dynamic
    connection/2,                       % image_server or vision_server, Client
    subscription/1,
    answered/1,                         % Server
    asked/3,                            % Server, Op, Since: what is waited for
    listening/1,                        % Description of the device whose events are subscribed to
    connected_with/1,                   % Options
    gave_up/1,                          % Endpoint
    spent/2.                            % Part, Seconds

%   A request to a server that the user started is sent again as often: it may come back.
again_s(2).                             % chosen by hand
request_s(own, 240).                    % one of our own is known to live while it is slow
request_s(named, 90).                   % more than a minute of overload or standstill
first_s(30).                            % until one of the user's has answered for the first time; chosen by hand
exposures_a_capture(40).                % beside: more than the vision server waits for (20); chosen by hand

%!  open_connections(+Options) is det.
%
%   Options: image_server(Endpoint), vision_server(Endpoint), own(Names) of the servers that are this session's, keys(Folder)
%   with CURVE keys, waiting(:Goal), called with Name, Op and the seconds so far while an answer is waited for,
%   gone(:Goal), called with Name, Endpoint and Seconds when nobody listens there any more, which is waited for so long, and
%   lost(:Goal), called with Name, Op and Error where there is no answer: if it succeeds the request is made again.

open_connections(Options) :-
    close_connections,
    assertz(connected_with(Options)),
    forall(member(Name, [image_server, vision_server]), open_server(Name, Options)).

open_server(Name, Options) :-
    Option =.. [Name, Endpoint],
    option(Option, Options),
    whose(Name, Options, Whose),
    request_s(Whose, Seconds),
    again_s(Again),
    ( Whose == own -> Retries = 2 ; Retries is Seconds // Again ),
    curve(Name, Options, Curve),
    client_open(Endpoint, Client, [server(Name), alive(session_connections:waiting(Name)), retries(Retries)|Curve]),
    assertz(connection(Name, Client)).

:- public waiting/1.

waiting(Name) :-
    (   connected_with(Options),
        option(waiting(Goal), Options)
    ->  ( asked(Name, Op, Since) -> true ; Op = subscribe, zmq_clock(Since) ),
        zmq_clock(Now),
        Seconds is Now - Since,
        findall(Server-Endpoint, may_have_to_answer(Name, Options, Server, Endpoint), Named),
        findall(Server, answered(Server), Answered),
        option(gone(Gone), Options),
        expect_servers(Named, Answered, Seconds, Gone),
        call(Goal, Name, Op, Seconds)
    ;   true
    ).

%   One of the user's; the vision server waits for the image server, too.
may_have_to_answer(Name, Options, Server, Endpoint) :-
    member(Server, [image_server, vision_server]),
    memberchk(Name, [Server, vision_server]),
    whose(Server, Options, named),
    Option =.. [Server, Endpoint],
    option(Option, Options).

curve(Server, Options, [Curve]) :-
    option(keys(Folder), Options),
    !,
    client_keys(Folder, controller, Server, Curve).
curve(_, _, []).

%!  end_session is det.
%
%   Tell the vision server that what it holds for this session is not needed any more, if it still hears.

end_session :-
    (   connection(vision_server, Client)
    ->  catch(client_request(Client, end, _{}, _, [timeout(1)]), error(_, _), true)
    ;   true
    ).

%!  close_connections is det.

close_connections :-
    forall(retract(connection(_, Client)), client_close(Client)),
    forall(retract(subscription(Subscription)), events_close(Subscription)),
    retractall(answered(_)),
    retractall(asked(_, _, _)),
    retractall(listening(_)),
    retractall(connected_with(_)),
    forget_presence,
    retractall(gave_up(_)),
    retractall(spent(_, _)).

%!  ask(+Server, +Op, +Args, -Result) is det.
%
%   @error error of bridge/prolog/client.pl when the server does not do it

ask(Server, Op, Args, Result) :-
    connection(Server, Client),
    zmq_clock(Now),
    asserta(asked(Server, Op, Now), Asked),
    request_seconds(Server, Args, Seconds),
    catch(client_request(Client, Op, Args, Result0, [timeout(Seconds)]), Error, true),
    erase(Asked),
    (   nonvar(Error)
    ->  connected_with(Opened),
        option(lost(Goal), Opened),
        (   call(Goal, Server, Op, Error)
        ->  ask(Server, Op, Args, Result)
        ;   note_end(Error),
            throw(Error)
        )
    ;   Result = Result0,
        ( answered(Server) -> true ; assertz(answered(Server)) ),
        (   get_dict(seconds, Result, Parts)
        ->  dict_pairs(Parts, _, Pairs),
            maplist(add_seconds, Pairs)
        ;   true
        )
    ).

note_end(error(bridge_timeout(Endpoint, _, _), _)) => assertz(gave_up(Endpoint)).
note_end(error(bridge_absent(Endpoint, _), _))     => assertz(gave_up(Endpoint)).
note_end(_)                                        => true.

%!  given_up(+Server) is semidet.
%
%   It was asked in vain for as long as was to be waited for it.

given_up(Server) :-
    connected_with(Options),
    Option =.. [Server, Endpoint],
    option(Option, Options),
    gave_up(Endpoint).

request_seconds(Server, Args, Seconds) :-
    connected_with(Options),
    whose(Server, Options, Whose),
    ( Whose == named, \+ answered(Server) -> first_s(Base) ; request_s(Whose, Base) ),
    (   get_dict(settings, Args, Settings),
        is_dict(Settings)               % of one image; `predict` has a list of them
    ->  exposures_a_capture(Exposures),
        Seconds is Base + Exposures*Settings.shutter_s
    ;   Seconds = Base
    ).

whose(Server, Options, Whose) :-
    option(own(Own), Options),
    ( memberchk(Server, Own) -> Whose = own ; Whose = named ).

%!  waits_for_server is semidet.
%
%   The answer to a request is waited for.

waits_for_server :-
    asked(_, _, _),
    !.

%!  has_answered(+Server) is semidet.

has_answered(Server) :-
    answered(Server).

add_seconds(Part-Seconds) :-
    ( retract(spent(Part, Before)) -> true ; Before = 0.0 ),
    After is Before + Seconds,
    assertz(spent(Part, After)).

%!  seconds_spent(-Waiting, -Parts) is det.
%
%   How long this side waited for replies so far, and where the servers' time went, as Part-Seconds pairs.

seconds_spent(Waiting, Parts) :-
    findall(Part-Seconds, spent(Part, Seconds), Parts),
    findall(Seconds, ( connection(_, Client), client_seconds(Client, Seconds) ), All),
    sum_list(All, Waiting).

%!  listen(+Description) is det.
%
%   Subscribe to the events of a device, where it publishes any.

listen(Description) :-
    string(Description.get(events)),
    !,
    assertz(listening(Description)),
    subscribe.
listen(_).

subscribe :-
    listening(Description),
    connected_with(Options),
    option(image_server(Server), Options),
    reachable(Description.events, Server, Events),
    curve(image_server, Options, Curve),
    request_s(own, Seconds),
    catch(events_open(Events, Subscription,
                      [alive(session_connections:waiting(image_server)), timeout(Seconds)|Curve]),
          Error, true),
    (   nonvar(Error)
    ->  option(lost(Goal), Options),
        ( call(Goal, image_server, subscribe, Error) -> true ; throw(Error) ),
        ( subscription(_) -> true ; subscribe )
    ;   assertz(subscription(Subscription))
    ).

%!  listen_again is det.
%
%   Subscribe anew, where events are listened to: none that was sent before comes after this.

listen_again :-
    forall(retract(subscription(Subscription)), events_close(Subscription)),
    ( listening(_) -> subscribe ; true ).

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

%!  arrived(-Events) is det.
%
%   The events since the last call, in order of arrival, as of events_poll/2.

arrived(Events) :-
    (   subscription(Subscription)
    ->  events_poll(Subscription, Events)
    ;   Events = []
    ).
