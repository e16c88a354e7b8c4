:- module(setup_prolog_pages, []).
/** <module> Pages from PlDoc

    swipl setup/prolog-pages.pl FOLDER

loads every module of the controller, collecting its comments, and writes FOLDER/<room>/<module>.html.
*/

:- use_module(library(doc_files), [doc_save/2]).
:- use_module(library(filesex), [directory_file_path/3, directory_member/3, make_directory_path/1]).
:- use_module(library(main), [main/0]).
:- use_module(library(pldoc), [doc_collect/1]).

:- initialization(main, main).

main([Folder]) :-
    doc_collect(true),
    forall(( room(Room), module_file(Room, File) ),
           load_files(File, [imports([]), qcompile(never)])),
    forall(room(Room), write_pages(Room, Folder)).

room('bridge/prolog').
room('domain/reasoning').
room(indigolog).
room(session).

write_pages(Room, Folder) :-
    directory_file_path(Folder, Room, Pages),
    make_directory_path(Pages),
    absolute_file_name(Pages, Root),
    doc_save(Room, [doc_root(Root), recursive(true), if(loaded), title('Lights and Camera')]).

module_file(Room, File) :-
    directory_member(Room, File, [recursive(true), extensions([pl])]),
    setup_call_cleanup(open(File, read, Stream), read_term(Stream, Term, []), close(Stream)),
    Term = (:- module(_, _)).
