:- module(test_session_holding, []).
:- use_module(library(plunit)).
:- use_module(library(filesex)).
:- use_module('../../session/holding').
:- use_module('../await').

/** <module> What a session does with the words it is told in a file */

:- begin_tests(holding).

%   What a session that is told words one after another does with its files: held is there while it waits, only then.
test(waits_until_told, [setup(folder(Folder)), cleanup(delete_directory_and_contents(Folder)), true(Left == [])]) :-
    write_hold(Folder, pause),
    thread_create(session_holding:wait_while_held(Folder), Session),
    await(file_in(Folder, held)),
    directory_file_path(Folder, hold, Hold),
    delete_file(Hold),
    thread_join(Session, true),
    left(Folder, Left).

test(steps_once, [setup(folder(Folder)), cleanup(delete_directory_and_contents(Folder)), true(Left == [hold])]) :-
    write_hold(Folder, pause),
    thread_create(session_holding:wait_while_held(Folder), Session),
    await(file_in(Folder, held)),
    write_hold(Folder, step),
    thread_join(Session, true),
    left(Folder, Left).

%   A file that is still empty says nothing yet; a word that is none of ours lets it go on.
test(goes_on_at_another_word, [setup(folder(Folder)), cleanup(delete_directory_and_contents(Folder)), true(Left == [hold])]) :-
    write_hold(Folder, pause),
    thread_create(session_holding:wait_while_held(Folder), Session),
    await(file_in(Folder, held)),
    write_hold(Folder, ''),
    sleep(0.3),
    assertion(file_in(Folder, held)),
    write_hold(Folder, go),
    thread_join(Session, true),
    session_holding:wait_while_held(Folder),
    left(Folder, Left).

test(stops_while_it_waits, [ setup(folder(Folder)), cleanup(delete_directory_and_contents(Folder)),
                             true(Status-Left == exception(stopped(term))-[]) ]) :-
    write_hold(Folder, pause),
    thread_create(session_holding:wait_while_held(Folder), Session),
    await(file_in(Folder, held)),
    write_hold(Folder, stop),
    thread_join(Session, Status),
    left(Folder, Left).

:- end_tests(holding).

folder(Folder) :-
    tmp_file(holding, Folder),
    make_directory(Folder).

%   As a script would: at once, so that no empty file is read.
write_hold(Folder, Word) :-
    directory_file_path(Folder, new, New),
    directory_file_path(Folder, hold, Hold),
    setup_call_cleanup(open(New, write, Stream), format(Stream, "~w~n", [Word]), close(Stream)),
    rename_file(New, Hold).

file_in(Folder, Name) :-
    directory_file_path(Folder, Name, File),
    exists_file(File).

left(Folder, Left) :-
    directory_files(Folder, Files),
    subtract(Files, ['.', '..'], Left).
