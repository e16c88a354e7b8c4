:- module(test_session_presence, []).
:- use_module(library(plunit)).
:- use_module(library(process), [process_create/3, process_kill/2, process_wait/2]).
:- use_module(library(readutil), [read_line_to_string/2]).
:- use_module('../../../session/servers/presence').

/** <module> Whether a server of the user's is waited for that has not answered yet */

waited_for(Endpoint, Seconds) :-
    expect_servers([image_server-Endpoint], [], Seconds, never).

%   A server that is still being loaded: it has been given its words, and no socket.
starting(Words, Pid) :-
    process_create(path(python3), ['-c', 'import time; print(flush=True); time.sleep(60)'|Words],
                   [process(Pid), stdout(pipe(Out))]),
    read_line_to_string(Out, _),        % only now has it its words
    close(Out).

ended(Pid) :-
    process_kill(Pid),
    process_wait(Pid, _).

:- begin_tests(presence).

test(nobody_will_listen_where_there_is_no_socket, throws(error(bridge_absent('ipc:///nowhere/at-all', 5), _))) :-
    waited_for('ipc:///nowhere/at-all', 4),
    waited_for('ipc:///nowhere/at-all', 6).
test(a_server_that_is_being_started_is_waited_for) :-
    setup_call_cleanup(starting(['--endpoint', 'ipc:///nowhere/soon'], Pid), waited_for('ipc:///nowhere/soon', 6), ended(Pid)).
test(so_is_one_whose_endpoint_is_in_one_word_with_its_option) :-
    setup_call_cleanup(starting(['--endpoint=ipc:///nowhere/soon'], Pid), waited_for('ipc:///nowhere/soon', 6), ended(Pid)).
test(who_only_asks_there_starts_none, throws(error(bridge_absent(_, _), _))) :-
    setup_call_cleanup(starting(['--image-server', 'ipc:///nowhere/soon'], Pid),
                       waited_for('ipc:///nowhere/soon', 6),
                       ended(Pid)).

:- end_tests(presence).
