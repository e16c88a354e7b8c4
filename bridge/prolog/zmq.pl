/** <module> ZeroMQ sockets

Sockets of libzmq as blobs. A socket belongs to the thread that opened it and is closed by zmq_close/1, or when it is
garbage; closing never waits (LINGER is 0). Waiting honours signals such as Ctrl-C.

A deadline that passes is failure; every error of libzmq is a term

    error(zmq_error(Errno, Message), context(bridge_zmq:Name/Arity, Culprit))

where Errno is an atom such as 'EADDRINUSE'. Timeouts are seconds from now, or `infinite`.
*/

:- module(bridge_zmq,
          [ zmq_socket/3,           % +Type, -Socket, +Options
            zmq_close/1,            % +Socket
            is_zmq_socket/1,        % @Term
            zmq_bind/2,             % +Socket, +Endpoint
            zmq_connect/2,          % +Socket, +Endpoint
            zmq_set/3,              % +Socket, +Option, +Value
            zmq_endpoint/2,         % +Socket, -Endpoint
            zmq_monitored/3,        % +Socket, -Monitor, :Goal
            zmq_send/3,             % +Socket, +Frames, +Timeout
            zmq_send/4,             % +Socket, +Frames, +Timeout, +Encoding
            zmq_receive/3,          % +Socket, -Frames, +Timeout
            zmq_receive/4,          % +Socket, -Frames, +Timeout, +Encoding
            zmq_curve_keypair/2,    % -PublicKey, -SecretKey
            zmq_private_file/1,     % +File
            zmq_open_sockets/1,     % -Count
            zmq_clock/1,            % -Seconds
            zmq_without_stops/1     % :Goal
          ]).
:- use_module(library(lists), [member/2]).
:- use_module(library(shlib), [use_foreign_library/1]).

:- module_property(bridge_zmq, file(Here)),
   file_directory_name(Here, Folder),
   atom_concat(Folder, '/zmq4pl', Library),
   use_foreign_library(Library).

:- meta_predicate
    zmq_without_stops(0),
    zmq_monitored(+, -, 0).

:- multifile prolog:error_message//1.

prolog:error_message(zmq_error(Errno, Message)) -->
    [ 'ZeroMQ refused: ~w (~w)'-[Message, Errno] ].

%!  zmq_socket(+Type, -Socket, +Options) is det.
%
%   Open a socket. Type is one of `dealer`, `router`, `pub`, `sub`, `xpub`, `xsub`, `req`, `rep`, `push`, `pull`
%   or `pair`. Options are Name(Value), each set as by zmq_set/3. When there are too many sockets, those that
%   are garbage are collected first.

zmq_socket(Type, Socket, Options) :-
    open_socket(Type, Socket0),
    catch(forall(member(Option, Options),
                 ( Option =.. [Name, Value],
                   zmq_set(Socket0, Name, Value)
                 )),
          Error,
          ( zmq_close(Socket0),
            throw(Error)
          )),
    Socket = Socket0.

open_socket(Type, Socket) :-
    opened(Type, Socket),
    !.
open_socket(Type, Socket) :-
    garbage_collect,
    garbage_collect_atoms,
    between(1, 100, _),             % libzmq gives closed sockets back a little later
    sleep(0.01),
    opened(Type, Socket),
    !.
open_socket(Type, Socket) :-
    zmq_open_(Type, Socket).

opened(Type, Socket) :-
    catch(zmq_open_(Type, Socket), error(zmq_error('EMFILE', _), _), fail).

%!  zmq_close(+Socket) is det.
%
%   Close at once; messages that have not left are lost. Closing twice is no error.

%!  is_zmq_socket(@Term) is semidet.
%
%   Term is a socket that is open.

%!  zmq_bind(+Socket, +Endpoint) is det.
%!  zmq_connect(+Socket, +Endpoint) is det.

%!  zmq_endpoint(+Socket, -Endpoint) is det.
%
%   Where the socket was bound last, a string; the port is a number where `*` was asked for.

%!  zmq_monitored(+Socket, -Monitor, :Goal) is semidet.
%
%   Call Goal once, and meanwhile tell Monitor, a socket, when Socket connects, and how each handshake ends, as by
%   zmq_socket_monitor(3).  The telling ends before Monitor is closed: else libzmq's thread, with something to tell and nobody
%   to take it, would wait for ever, and with it every socket of the process.

zmq_monitored(Socket, Monitor, Goal) :-
    flag(bridge_zmq_monitor, N, N+1),
    atom_concat('inproc://monitor-', N, Endpoint),
    setup_call_cleanup(zmq_socket(pair, Monitor, []),
                       ( zmq_monitor_(Socket, Endpoint), zmq_connect(Monitor, Endpoint), once(Goal) ),
                       ( zmq_unmonitor_(Socket), zmq_close(Monitor) )).

%!  zmq_set(+Socket, +Option, +Value) is det.
%
%   Option is one of `rcvhwm`, `reconnect_ivl`, `maxmsgsize`, `router_mandatory`, `xpub_welcome_msg`, `subscribe`,
%   `curve_server`, `curve_publickey`, `curve_secretkey`, `curve_serverkey`, with the meaning of libzmq's option of
%   that name. Keys are Z85 text of 40 characters.

%!  zmq_send(+Socket, +Frames, +Timeout) is semidet.
%!  zmq_send(+Socket, +Frames, +Timeout, +Encoding) is semidet.
%
%   Send a message of one or more frames of text, encoded as `utf8` (default) or, one character a byte, `octet`.
%   Fails when no peer took it in time.

zmq_send(Socket, Frames, Timeout) :-
    zmq_send(Socket, Frames, Timeout, utf8).

%!  zmq_receive(+Socket, -Frames, +Timeout) is semidet.
%!  zmq_receive(+Socket, -Frames, +Timeout, +Encoding) is semidet.
%
%   Receive a whole message, each frame a string. Fails when none came in time. Encoding is as for zmq_send/4, or
%   `header`: the first frame as UTF-8, and nothing of the others.
%
%   @error domain_error(utf8_frame, Index) when a frame is not UTF-8; the message is gone then.

zmq_receive(Socket, Frames, Timeout) :-
    zmq_receive(Socket, Frames, Timeout, utf8).

%!  zmq_curve_keypair(-PublicKey, -SecretKey) is det.
%
%   A fresh pair of CURVE keys.

%!  zmq_private_file(+File) is semidet.
%
%   Nobody but its owner may do anything with File, as befits a secret key.

%!  zmq_open_sockets(-Count) is det.
%
%   How many sockets of this process are open.

%!  zmq_clock(-Seconds) is det.
%
%   Time on a clock that nobody sets; for deadlines and durations.

%!  zmq_without_stops(:Goal) is semidet.
%
%   Call Goal once. Threads that it starts are never given Ctrl-C or a request to end, which the kernel else may give to
%   any thread that takes it: what is thrown in another than the main one ends nothing.
