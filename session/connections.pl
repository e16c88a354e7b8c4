:- module(session_connections,
          [ open_connections/1,         % +Options
            close_connections/0,
            ask/4,                      % +Server, +Op, +Args, -Result
            listen/1,                   % +Description
            arrived/1,                  % -Events
            seconds_spent/2             % -Waiting, -Parts
          ]).
:- use_module('../bridge/prolog/client').
:- use_module('../bridge/prolog/keys', [client_keys/4]).
:- use_module(library(apply), [maplist/2]).
:- use_module(library(lists), [append/3, member/2, sum_list/2]).
:- use_module(library(option), [option/2, option/3]).

/** <module> The session's connections: to both servers, and to the image server's events */

:- dynamic
    connection/2,                       % image_server or vision_server, Client
    subscription/1,
    opened_with/1,                      % Options
    spent/2.                            % Part, Seconds

%!  open_connections(+Options) is det.
%
%   Options: image_server(Endpoint), vision_server(Endpoint), alive(:Goal) called while waiting, timeout(Seconds) of
%   a request, keys(Folder) with CURVE keys.

open_connections(Options) :-
    close_connections,
    assertz(opened_with(Options)),
    forall(member(Name, [image_server, vision_server]), open_server(Name, Options)).

open_server(Name, Options) :-
    Option =.. [Name, Endpoint],
    option(Option, Options),
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

%!  close_connections is det.

close_connections :-
    forall(retract(connection(_, Client)), client_close(Client)),
    forall(retract(subscription(Subscription)), events_close(Subscription)),
    retractall(opened_with(_)),
    retractall(spent(_, _)).

%!  ask(+Server, +Op, +Args, -Result) is det.
%
%   @error error of bridge/prolog/client.pl when the server does not do it

ask(Server, Op, Args, Result) :-
    connection(Server, Client),
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
    opened_with(Options),
    option(image_server(Server), Options),
    reachable(Description.events, Server, Events),
    curve(image_server, Options, Curve),
    events_open(Events, Subscription, Curve),
    assertz(subscription(Subscription)).
listen(_).

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
