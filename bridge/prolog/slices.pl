/** <module> Waiting at a socket, with a deadline and somebody who looks after what is waited for */

:- module(bridge_slices,
          [ in_slices/4,            % :Goal, :Alive, +Seconds, -Left
            received/3,             % +Socket, -Header, +Timeout
            curve_option/2,         % +Options, -SocketOptions
            max_frame_bytes/1       % -Bytes
          ]).
:- use_module(library(lists), [memberchk/2]).
:- use_module(zmq).

:- meta_predicate in_slices(1, 0, +, -).

slice_s(0.1).                       % longest wait between two calls of the alive goal, chosen by hand
most_of_a_slice_s(1.0).             % longer, and this process stood still; chosen by hand

%!  max_frame_bytes(-Bytes) is det.
%
%   Of protocol version 1.

max_frame_bytes(67108864).

%!  received(+Socket, -Header, +Timeout) is semidet.
%
%   The first frame of a message.

received(Socket, Header, Timeout) :-
    zmq_receive(Socket, [Header], Timeout, header).

%!  in_slices(:Goal, :Alive, +Seconds, -Left) is semidet.
%
%   Goal with a time to wait added succeeds within Seconds, of which so many are left; Alive is called in between.  While this
%   process stands still, as one that is suspended, nobody waits: of such a slice only a second counts.

in_slices(Goal, Alive, Seconds, Left) :-
    Seconds > 0,
    slice_s(Slice),
    most_of_a_slice_s(Most),
    zmq_clock(Start),
    Wait is min(Slice, Seconds),
    (   call(Goal, Wait)
    ->  Answered = true
    ;   ignore(Alive),
        Answered = false
    ),
    zmq_clock(End),
    After is Seconds - min(End - Start, Most),
    (   Answered == true
    ->  Left = After
    ;   in_slices(Goal, Alive, After, Left)
    ).

%!  curve_option(+Options, -SocketOptions) is det.
%
%   The keys in curve(PublicKey, SecretKey, ServerKey), where Options have it.

curve_option(Options, Curve) :-
    (   memberchk(curve(Public, Secret, Server), Options)
    ->  Curve = [ curve_publickey(Public), curve_secretkey(Secret), curve_serverkey(Server) ]
    ;   Curve = []
    ).
