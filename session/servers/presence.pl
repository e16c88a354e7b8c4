:- module(session_presence,
          [ expect_servers/4,           % +Named, +Answered, +Seconds, :Gone
            forget_presence/0
          ]).
/** <module> Whether the user's servers are there while one of them is waited for

A server that stands still, or works for long, is there.  What the servers of this session do is known from their processes.
*/

:- use_module('../../bridge/prolog/handshake', [somebody_listens/1]).
:- use_module('../../bridge/prolog/zmq', [zmq_clock/1]).
:- use_module(serving_processes, [serving_process/2]).
:- use_module(library(lists), [member/2, memberchk/2]).

:- meta_predicate expect_servers(+, +, +, 3).

:- dynamic
    looked/3.                           % Server, When, Since: whether anybody listened, and since when nobody does, or `there`

absent_s(5).                            % as of the clients in Python; longer for one that is being started
look_s(2).                              % between two looks whether anybody listens; chosen by hand
gone_s(25).                             % for one that has answered before, and may be started again; chosen by hand

%!  expect_servers(+Named, +Answered, +Seconds, :Gone) is det.
%
%   Named are Server-Endpoint of those that may have to answer, Answered the servers that have done so before, and Seconds how
%   long is waited by now.  When nobody listens any more where one was, Gone is called with Server, Endpoint and for how
%   many seconds it is waited for.
%
%   @error bridge_absent(Endpoint, Seconds)

expect_servers(Named, Answered, Seconds, Gone) :-
    forall(member(Server-Endpoint, Named),
           (   memberchk(Server, Answered)
           ->  ( look_s(Every), Seconds > Every -> look_for(Server, Endpoint, Gone) ; true )
           ;   expect_socket(Endpoint, Seconds)
           )).

%   Where a server has not answered yet, there is no such socket, and no process is about to make it, nobody will.
expect_socket(Endpoint, Seconds) :-
    absent_s(Most),
    Seconds > Most,
    atom_concat('ipc:///', Path, Endpoint),
    atom_concat(/, Path, Socket),
    \+ access_file(Socket, exist),
    \+ serving_process(Endpoint, _),
    !,
    throw(error(bridge_absent(Endpoint, Most), _)).
expect_socket(_, _).

look_for(Server, Endpoint, Gone) :-
    zmq_clock(Now),
    (   look_s(Every),
        looked(Server, Last, _),
        Now - Last < Every
    ->  true
    ;   seen(Server, Endpoint, Now, Gone, Since),
        retractall(looked(Server, _, _)),
        assertz(looked(Server, Now, Since))
    ),
    gone_s(Most),
    (   looked(Server, _, Gone0),
        Gone0 \== there,
        Now - Gone0 > Most
    ->  throw(error(bridge_absent(Endpoint, Most), _))
    ;   true
    ).

seen(Server, Endpoint, Now, Gone, Since) :-
    (   somebody_listens(Endpoint)
    ->  Since = there
    ;   looked(Server, _, Before),
        Before \== there
    ->  Since = Before
    ;   Since = Now,
        gone_s(Most),
        call(Gone, Server, Endpoint, Most)
    ).

%!  forget_presence is det.

forget_presence :-
    retractall(looked(_, _, _)).
