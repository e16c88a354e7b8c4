/** <module> Whether a server that does not answer is there at all, or refuses to talk */

:- module(bridge_handshake,
          [ handshake_refused/2,    % +Endpoint, +CurveOptions
            somebody_listens/1      % +Endpoint
          ]).
:- use_module(library(lists), [memberchk/2]).
:- use_module(zmq).

%   As for bridge/client.py.
probe_s(0.6).
again_ms(100).

% Of libzmq's monitor.
event(0x0001, connected).
event(0x1000, agreed).
event(0x2000, refused).             % no common protocol, or keys on one side only
event(0x4000, refused).             % a key that it does not know
event(0x0800, hung_up).             % so does a server who cannot read what was said to it: it has another key

%!  handshake_refused(+Endpoint, +CurveOptions) is semidet.
%
%   Something listens at Endpoint, and ends the connection of a client with these keys in its handshake, or hangs up
%   again and again.  A server that is not there, or stands still, does not refuse.

handshake_refused(Endpoint, Curve) :-
    again_ms(Again),
    probe_s(Seconds),
    zmq_clock(Now),
    Deadline is Now+Seconds,
    There is Now+Again/1000,
    zmq_socket(dealer, Socket, [reconnect_ivl(Again)|Curve]),
    call_cleanup(zmq_monitored(Socket, Monitor,
                               ( zmq_connect(Socket, Endpoint),
                                 heard(Monitor, There, connected),
                                 refused(Monitor, 0, Deadline)
                               )),
                 zmq_close(Socket)).

%!  somebody_listens(+Endpoint) is semidet.
%
%   A server that works, or stands still, does; one that has died does not.  Takes half a second where nobody does.

somebody_listens(Endpoint) :-
    probe_s(Seconds),
    zmq_clock(Now),
    Deadline is Now+Seconds,
    zmq_socket(dealer, Socket, []),
    call_cleanup(zmq_monitored(Socket, Monitor, ( zmq_connect(Socket, Endpoint), heard(Monitor, Deadline, connected) )),
                 zmq_close(Socket)).

refused(Monitor, HungUp, Deadline) :-
    heard(Monitor, Deadline, Event),
    (   Event == refused
    ->  true
    ;   Event == hung_up,
        HungUp > 0
    ->  true
    ;   memberchk(Event, [hung_up, connected]),
        ( Event == hung_up -> More = 1 ; More = HungUp ),
        refused(Monitor, More, Deadline)
    ).

%   What comes before Deadline.
heard(Monitor, Deadline, Event) :-
    zmq_clock(Now),
    Left is max(0, Deadline-Now),
    zmq_receive(Monitor, [Message, _Endpoint], Left, octet),
    string_codes(Message, [Low, High|_]),
    Code is High<<8 \/ Low,
    event(Code, Event),
    !.
