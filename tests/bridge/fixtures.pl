:- module(bridge_fixtures,
          [ socket_endpoint/1,      % -Endpoint
            with_mock/4,            % +Kind, +Script, -Endpoint, :Goal
            with_child/4,           % +Goal, -Process, -Out, :Body
            python/1,               % -Program
            impostor/3,             % +Endpoint, :Replies, -Thread
            eventually/1            % :Goal
          ]).
/** <module> Peers for the tests of the Prolog side of the bridge */

:- use_module(library(http/json), [json_read_dict/3, json_write_dict/2]).
:- use_module(library(lists), [member/2]).
:- use_module(library(process), [process_create/3, process_kill/2, process_wait/2]).
:- use_module('../../bridge/prolog/zmq').

:- meta_predicate
    with_mock(+, +, -, 0),
    with_child(+, -, -, 0),
    impostor(+, 2, -),
    eventually(0).

root(Root) :-
    module_property(bridge_fixtures, file(Here)),
    file_directory_name(Here, Folder),
    file_directory_name(Folder, Tests),
    file_directory_name(Tests, Root).

%!  python(-Program) is det.

python(Program) :-
    root(Root),
    atom_concat(Root, '/.venv/bin/python', Program).

%!  socket_endpoint(-Endpoint) is det.
%
%   A fresh ipc endpoint.

socket_endpoint(Endpoint) :-
    tmp_file(socket, Path),
    atom_concat('ipc://', Path, Endpoint).

%!  with_mock(+Kind, +Script, -Endpoint, :Goal) is semidet.
%
%   Run Goal while a mock server (`image` or `vision`) follows Script, a dict as of bridge/mocks.py, in a process of
%   its own.

with_mock(Kind, Script, Endpoint, Goal) :-
    root(Root),
    python(Python),
    socket_endpoint(Endpoint),
    tmp_file(script, File),
    setup_call_cleanup(open(File, write, Out), json_write_dict(Out, Script), close(Out)),
    current_prolog_flag(pid, Pid),
    setup_call_cleanup(
        process_create(Python,
                       [ '-m', 'bridge.mocks', Kind, '--endpoint', Endpoint, '--parent', Pid, '--script', File ],
                       [ process(Process), cwd(Root), stdin(null) ]),
        once(Goal),
        ( process_kill(Process, 9),
          process_wait(Process, _),
          delete_socket(Endpoint),
          atom_concat(Endpoint, '-events', Events),
          delete_socket(Events)
        )).

%!  delete_socket(+Endpoint) is det.
%
%   Delete the file of an ipc endpoint whose server could not do it.

delete_socket(Endpoint) :-
    atom_concat('ipc://', File, Endpoint),
    catch(delete_file(File), error(existence_error(_, _), _), true).

%!  with_child(+Goal, -Process, -Out, :Body) is semidet.
%
%   Run Body while another Prolog runs Goal with the sockets loaded. Out is its standard output.

with_child(Goal, Process, Out, Body) :-
    root(Root),
    atom_concat(Root, '/bridge/prolog/zmq', Zmq),
    format(atom(Load), 'use_module(~q)', [Zmq]),
    setup_call_cleanup(
        process_create(path(swipl), [ '-g', Load, '-g', Goal, '-t', 'halt(9)' ],
                       [ process(Process), stdout(pipe(Out)), stderr(null), stdin(null) ]),
        once(Body),
        ( catch(process_kill(Process, 9), _, true),
          catch(process_wait(Process, _), _, true),
          close(Out)
        )).

%!  impostor(+Endpoint, :Replies, -Thread) is det.
%
%   A thread that listens on Endpoint and answers each request with what call(Replies, Request, Headers) says, until
%   it throws. A request is a dict, a reply its text. It lists the ids that it saw as its exit value.

impostor(Endpoint, Replies, Thread) :-
    thread_self(Me),
    thread_create(impostor_thread(Endpoint, Replies, Me), Thread),
    thread_get_message(listening(Thread)).

impostor_thread(Endpoint, Replies, Creator) :-
    zmq_socket(router, Socket, []),
    zmq_bind(Socket, Endpoint),
    thread_self(Me),
    thread_send_message(Creator, listening(Me)),
    impostor_loop(Socket, Replies, []).

impostor_loop(Socket, Replies, Seen) :-
    zmq_receive(Socket, [Route, Text], infinite, octet),
    setup_call_cleanup(open_string(Text, In), json_read_dict(In, Request, []), close(In)),
    Ids = [Request.id|Seen],
    call(Replies, Request, Headers),
    (   Headers == stop
    ->  thread_exit(Ids)
    ;   forall(member(Header, Headers), zmq_send(Socket, [Route, Header], 1, octet)),
        impostor_loop(Socket, Replies, Ids)
    ).

%!  eventually(:Goal) is semidet.
%
%   Goal becomes true within a generous time.

eventually(Goal) :-
    zmq_clock(Start),
    eventually(Goal, Start).

eventually(Goal, _) :-
    call(Goal),
    !.
eventually(Goal, Start) :-
    zmq_clock(Now),
    Now - Start < 60,
    sleep(0.01),
    eventually(Goal, Start).
