/** <module> The events that a server publishes */

:- module(bridge_events,
          [ events_open/2,          % +Endpoint, -Subscription
            events_open/3,          % +Endpoint, -Subscription, :Options
            events_poll/2,          % +Subscription, -Events
            events_close/1          % +Subscription
          ]).
:- use_module(library(apply), [convlist/3]).
:- use_module(library(option), [meta_options/3, option/3]).
:- use_module(json).
:- use_module(slices).
:- use_module(zmq).

:- meta_predicate events_open(+, -, :).

welcome_s(5.0).                     % an event server that is there answers at once; chosen by hand

%!  events_open(+Endpoint, -Subscription) is det.
%!  events_open(+Endpoint, -Subscription, :Options) is det.
%
%   Subscribe to the events published at Endpoint. Returns when the server has confirmed it, so that no event is
%   lost from then on. Options timeout (default 5), alive and curve are as in client_open/3.
%
%   @error bridge_timeout(Endpoint, subscribe, Seconds) when nobody publishes there.

events_open(Endpoint, Subscription) :-
    events_open(Endpoint, Subscription, []).

events_open(Endpoint, Subscription, Options0) :-
    meta_options(is_meta, Options0, Options),
    welcome_s(Default),
    option(timeout(Timeout), Options, Default),
    option(alive(Alive), Options, true),
    curve_option(Options, Curve),
    max_frame_bytes(Max),
    zmq_socket(sub, Socket, [subscribe(""), rcvhwm(0), maxmsgsize(Max)|Curve]),
    catch(( zmq_connect(Socket, Endpoint),
            (   in_slices(received(Socket, _Welcome), Alive, Timeout, _)
            ->  true
            ;   throw(error(bridge_timeout(Endpoint, subscribe, Timeout), _))
            )
          ),
          Error,
          ( zmq_close(Socket),
            throw(Error)
          )),
    Subscription = '$bridge_events'(Socket).

%!  events_poll(+Subscription, -Events) is det.
%
%   Events are those that came since the last call, in order; [] for none. Never waits. Each is a dict with keys
%   `event` (a string), `args` (a dict) and `sequence` (counts from 1).

events_poll('$bridge_events'(Socket), Events) :-
    waiting(Socket, Headers),
    convlist(event, Headers, Events).

is_meta(alive).

waiting(Socket, Headers) :-
    (   received(Socket, Header, 0)
    ->  Headers = [Header|More],
        waiting(Socket, More)
    ;   Headers = []
    ).

event(Header, Event) :-
    catch(json_term(Header, Event), error(syntax_error(_), _), fail),
    is_dict(Event),
    get_dict(event, Event, Name),
    get_dict(sequence, Event, _),
    Name \== "welcome".

%!  events_close(+Subscription) is det.
%
%   End a subscription. Closing twice is no error.

events_close('$bridge_events'(Socket)) :-
    zmq_close(Socket).
