:- module(test_indigolog_pack, []).
:- use_module(library(plunit)).
:- use_module(library(filesex), [copy_file/2, delete_directory_and_contents/1, directory_file_path/3,
                                 directory_member/3, make_directory_path/1, relative_file_name/3]).
:- use_module(library(process), [process_create/3, process_wait/2]).
:- use_module(library(uri), [uri_file_name/2]).
:- use_module(library(lists), [member/2]).

/** <module> The interpreter is a pack that needs nothing else of this project */

root(Root) :-
    module_property(test_indigolog_pack, file(Here)),
    file_directory_name(Here, Folder),
    absolute_file_name('../..', Root, [relative_to(Folder), file_type(directory)]).

% A copy of the interpreter, what tests it, and the page and the examples that those read.
alone(Tmp) :-
    tmp_file(pack, Tmp),
    forall(member(Part, ['indigolog', 'tests/indigolog', 'examples', 'docs/language.md', 'tests/run.pl']),
           copied(Part, Tmp)).

copied(Part, Tmp) :-
    root(Root),
    directory_file_path(Root, Part, From),
    (   exists_file(From)
    ->  copied_file(From, Root, Tmp)
    ;   forall(( directory_member(From, File, [recursive(true)]), exists_file(File) ),
               copied_file(File, Root, Tmp))
    ).

copied_file(File, Root, Tmp) :-
    directory_file_path(Root, '_', Anchor),
    relative_file_name(File, Anchor, Relative),
    directory_file_path(Tmp, Relative, Copy),
    file_directory_name(Copy, Folder),
    make_directory_path(Folder),
    copy_file(File, Copy).

swipl(Tmp, Words, Status, Output) :-
    current_prolog_flag(executable, Swipl),
    process_create(Swipl, Words,
                   [cwd(Tmp), stdin(null), stdout(pipe(Out)), stderr(pipe(Err)), process(Process)]),
    call_cleanup(( read_string(Out, _, Output), read_string(Err, _, Errors) ),
                 ( close(Out), close(Err), process_wait(Process, exit(Status)) )),
    (   Status == 0
    ->  true
    ;   print_message(error, format("~w", [Errors]))
    ).

:- begin_tests(pack, [setup(( alone(Tmp), nb_setval(pack_copy, Tmp) )),
                      cleanup(( nb_getval(pack_copy, Tmp), delete_directory_and_contents(Tmp) ))]).

test(attached, Status-Output == 0-"13\n") :-
    nb_getval(pack_copy, Tmp),
    swipl(Tmp,
          [ '-g', "attach_packs('.', [])", '-g', "use_module(library(indigolog))",
            '-g', "load_theory('examples/elevator.pl'), do(control, [], H), length(H, N), writeln(N)",
            '-t', halt ],
          Status, Output).

% Into an empty folder, and run in another that holds nothing but the example.
test(installed, [ setup(( tmp_file(packs, Packs), make_directory(Packs) )),
                  cleanup(delete_directory_and_contents(Packs)),
                  Status-Output == 0-"13\n" ]) :-
    nb_getval(pack_copy, Tmp),
    uri_file_name(URL, Tmp),
    format(atom(Install),
           "use_module(library(prolog_pack)), pack_install('~w/indigolog', [interactive(false), silent(true), package_directory(~q)])",
           [URL, Packs]),
    format(atom(Attach), "attach_packs(~q, [])", [Packs]),
    root(Root),
    directory_file_path(Root, 'examples/elevator.pl', Example),
    copy_file(Example, Packs),
    swipl(Packs,
          [ '-g', Install, '-g', Attach, '-g', "use_module(library(indigolog))",
            '-g', "load_theory('elevator.pl'), do(control, [], H), length(H, N), writeln(N)",
            '-t', halt ],
          Status, Output).

test(described, Status-Output == 0-"indigolog\n") :-
    nb_getval(pack_copy, Tmp),
    swipl(Tmp, ['-g', "attach_packs('.', []), pack_property(indigolog, version(_)), writeln(indigolog)", '-t', halt],
          Status, Output).

% Without what takes seconds: the files are the same, which have passed that.
test(passes_its_tests, [ condition(\+ getenv('TESTS', quick)), setup(setenv('TESTS', quick)), cleanup(unsetenv('TESTS')),
                         Status == 0 ]) :-
    nb_getval(pack_copy, Tmp),
    swipl(Tmp,
          ['-g', main, 'tests/run.pl', '--', 'indigolog/indigolog', language, examples, search, executive, explain, stepper],
          Status, _).

:- end_tests(pack).
