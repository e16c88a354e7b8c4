:- module(test_session_processes, []).
:- use_module(library(plunit)).
:- use_module(library(filesex), [delete_directory_and_contents/1]).
:- use_module(library(prolog_wrap), [wrap_predicate/4]).
:- use_module(library(process), [process_create/3, process_wait/2]).
:- use_module(library(readutil), [read_line_to_string/2]).
:- use_module('../../../session/servers/kept_servers').
:- use_module('../../../session/servers/processes').
:- use_module('../../await').

/** <module> A server that is killed has gone when that is done */

running(Pid) :-
    format(atom(Words), "/proc/~w", [Pid]),
    exists_directory(Words).

an_hour_later(Time) :-
    flag(test_session_hours, Hours, Hours + 1),
    Time is 3600.0*Hours.

%   As a server of another session: what has started it has ended.
orphan(Base, Pid) :-
    atom_concat('ipc://', Base, Endpoint),
    process_create(path(sh),
                   ['-c', 'python3 -c "import time; time.sleep(60)" "$@" >/dev/null & echo $!', sh, '--endpoint', Endpoint],
                   [process(Parent), stdout(pipe(Out))]),
    read_line_to_string(Out, Line),
    close(Out),
    process_wait(Parent, _),
    number_string(Pid, Line).

:- begin_tests(processes).

test(a_child_that_is_killed_is_gone, fail) :-
    process_create(path(sleep), [60], [process(Pid)]),
    kill_process(process(image_server, Pid, 'none.log')),
    running(Pid).
test(so_is_a_server_that_was_found, [ setup(( tmp_file(kept, Folder), make_directory(Folder) )),
                                      cleanup(delete_directory_and_contents(Folder)) ]) :-
    atom_concat(Folder, '/server', Base),
    orphan(Base, Pid),
    keep_server(Base, process(image_server, Pid, 'none.log')),
    await(kept_running(Base, Pid)),    % from when it has been loaded, it has its words
    kill_process(kept(image_server, Pid, Base)),
    assertion(\+ kept_running(Base, Pid)).

% As where the clock is set, or a laptop was asleep: each time that it is asked it is an hour later.
test(a_clock_that_is_set_takes_no_time_from_a_process,
     [ setup(wrap_predicate(system:get_time(Time), an_hour_later, _, test_session_processes:an_hour_later(Time))),
       cleanup(unwrap_predicate(system:get_time/1, an_hour_later)),
       Status == exit(0) ]) :-
    process_create(path(sleep), [0.1], [process(Pid)]),
    ended_or_killed(60, Pid, Status).

:- end_tests(processes).
