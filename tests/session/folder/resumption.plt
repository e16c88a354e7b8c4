:- module(test_session_resumption, []).
:- use_module(library(plunit)).
:- use_module(library(lists)).
:- use_module(library(filesex), [delete_directory_and_contents/1]).
:- use_module('../../../session/folder/resumption').
:- use_module('../../../session/folder/session_file').

/** <module> What a session was asked to do, as it is kept */

in_new_folder(Goal) :-
    tmp_file(kept, Folder),
    make_directory(Folder),
    working_directory(Here, Folder),
    call_cleanup(call(Goal, Folder), ( working_directory(_, Here), delete_directory_and_contents(Folder) )).

kept(Given, Kept, Folder) :-
    forall(( member(Option, Given), arg(1, Option, File), sub_atom(File, _, _, 0, '.toml') ),
           ( open(File, write, Stream), close(Stream) )),
    locked_session_file(Folder, true),
    record_options(Given, "{}"),
    read_session_file(Folder, [described("{}")|Kept]).

:- begin_tests(resumption).

test(files_are_found_from_any_folder, forall(member(Name, [scenario, camera, lights, camera_model, seed_pose]))) :-
    Option =.. [Name, 'mine.toml'],
    in_new_folder(kept([Option], [Kept])),
    arg(1, Kept, File),
    is_absolute_file_name(File),
    file_base_name(File, 'mine.toml').

test(how_it_is_shown_is_not_kept, Kept == [image_server('ipc:///tmp/images'), seed(3)]) :-
    in_new_folder(kept([quiet(true), image_server('ipc:///tmp/images'), view(true), seed(3)], Kept)).

:- end_tests(resumption).
