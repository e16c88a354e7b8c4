/** <module> Waiting at a socket, with a deadline and somebody who looks after what is waited for */

:- module(bridge_slices,
          [ in_slices/3,            % :Goal, :Alive, +Deadline
            received/3,             % +Socket, -Header, +Timeout
            curve_option/2,         % +Options, -SocketOptions
            max_frame_bytes/1       % -Bytes
          ]).
:- use_module(library(lists), [memberchk/2]).
:- use_module(zmq).

:- meta_predicate in_slices(1, 0, +).

slice_s(0.1).                       % longest wait between two calls of the alive goal, chosen by hand

%!  max_frame_bytes(-Bytes) is det.
%
%   Of protocol version 1.

max_frame_bytes(67108864).

%!  received(+Socket, -Header, +Timeout) is semidet.
%
%   The first frame of a message.

received(Socket, Header, Timeout) :-
    zmq_receive(Socket, [Header], Timeout, header).

%!  in_slices(:Goal, :Alive, +Deadline) is semidet.
%
%   Goal with a time to wait added succeeds before the deadline; Alive is called in between.

in_slices(Goal, Alive, Deadline) :-
    slice_s(Slice),
    repeat,
    zmq_clock(Now),
    Left is Deadline-Now,
    (   Left =< 0
    ->  !,
        fail
    ;   Wait is min(Slice, Left),
        call(Goal, Wait)
    ->  !
    ;   ignore(Alive),
        fail
    ).

%!  curve_option(+Options, -SocketOptions) is det.
%
%   The keys in curve(PublicKey, SecretKey, ServerKey), where Options have it.

curve_option(Options, Curve) :-
    (   memberchk(curve(Public, Secret, Server), Options)
    ->  Curve = [ curve_publickey(Public), curve_secretkey(Secret), curve_serverkey(Server) ]
    ;   Curve = []
    ).
