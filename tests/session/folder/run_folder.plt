:- module(test_session_run_folder, []).
:- use_module(library(plunit)).
:- use_module(library(apply)).
:- use_module(library(filesex), [delete_directory_and_contents/1]).
:- use_module(library(lists)).
:- use_module('../../../session/folder/run_folder', []).

/** <module> Sessions that begin at the same time */

made(Folder) :-
    session_run_folder:made_folder([], plan{controller:heuristic, target:cube}, Folder).

%   Of threads that wait for each other, as near to the same moment as it goes.
made_at_once(Count, Folders) :-
    message_queue_create(Start),
    findall(Thread,
            ( between(1, Count, _),
              thread_create(( thread_get_message(Start, go), made(Folder), thread_exit(Folder) ), Thread) ),
            Threads),
    forall(member(_, Threads), thread_send_message(Start, go)),
    maplist([Thread, Folder]>>thread_join(Thread, exited(Folder)), Threads, Folders),
    message_queue_destroy(Start).

in_a_new_folder(Goal) :-
    tmp_file(runs, Here),
    make_directory(Here),
    working_directory(Before, Here),
    call_cleanup(Goal, ( working_directory(_, Before), delete_directory_and_contents(Here) )).

:- begin_tests(run_folder).

test(sessions_that_begin_at_once_have_folders_of_their_own) :-
    forall(between(1, 100, _),
           in_a_new_folder(( made_at_once(6, Folders),
                             assertion(is_set(Folders)),
                             assertion(forall(member(Folder, Folders), exists_directory(Folder))) ))).

:- end_tests(run_folder).
