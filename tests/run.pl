/** <module> Run the Prolog tests

    swipl -g main tests/run.pl -- [NAME...]

loads every test file (`*.plt`) under this folder, or only those whose path below it contains one of the names, runs
them, says once more what was wrong, and prints a closing line. The exit status is 1 when a test failed, when a file did
not load without a warning, when plunit had something to complain about, or when there was nothing to run.  With TESTS=quick in the environment, what takes
seconds is left out or done less often.
*/

:- module(run_tests,
          [ main/0
          ]).
:- use_module(library(apply), [include/3]).
:- use_module(library(filesex), [directory_member/3]).
:- use_module(library(lists), [member/2]).
:- use_module(library(plunit), [run_tests/0]).

:- dynamic
    complaint/2,                        % Term, Kind: what was printed while loading, or by plunit
    phase/1,
    summary/1.

:- multifile
    user:message_hook/3,
    prolog:message//1.

user:message_hook(Term, Kind, _) :-
    note(Term, Kind),
    fail.                               % still printed

note(plunit(Summary), silent) :-
    is_dict(Summary),
    !,
    retractall(summary(_)),
    assertz(summary(Summary)).
note(Term, Kind) :-
    memberchk(Kind, [error, warning]),
    \+ phase(closing),
    (   phase(loading)
    ->  true
    ;   functor(Term, plunit, 1)        % tests themselves may print what they like
    ),
    assertz(complaint(Term, Kind)).

prolog:message(tests_done(Passed, Failed, Blocked, Complaints, Files)) -->
    [ '~d passed, ~d failed, ~d blocked, ~d warnings and errors, ~d files'-
      [Passed, Failed, Blocked, Complaints, Files] ].
prolog:message(tests_unknown(Names)) -->
    [ 'No test file has any of ~w in its path'-[Names] ].

%!  main is det.
%
%   Run the tests named on the command line, or all, and halt.

main :-
    current_prolog_flag(argv, Argv),
    names(Argv, Names),
    test_files(Names, Files),
    (   Files == []
    ->  print_message(error, tests_unknown(Names)),
        halt(1)
    ;   set_phase(loading),
        forall(member(File, Files), load_files(File, [imports([])])),
        set_phase(running),
        (   run_tests
        ->  Ok = true
        ;   Ok = false
        ),
        once_more,
        closing_line(Files, Clean),
        (   Ok == true,
            Clean == true
        ->  halt(0)
        ;   halt(1)
        )
    ).

set_phase(Phase) :-
    retractall(phase(_)),
    assertz(phase(Phase)).

%   Depending on how it was started, argv still holds the program's and the script's names.

names(Argv, Names) :-
    include(is_name, Argv, Names).

is_name(Word) :-
    file_base_name(Word, Base),
    \+ memberchk(Base, ['--', swipl, 'run.pl']).

test_files(Names, Files) :-
    module_property(run_tests, file(Here)),
    file_directory_name(Here, Folder),
    findall(File,
            ( directory_member(Folder, File, [recursive(true), extensions([plt])]),
              wanted(Names, Folder, File)
            ),
            Files0),
    sort(Files0, Files).

wanted([], _, _) :-
    !.
wanted(Names, Folder, File) :-
    atom_concat(Folder, Path, File),
    once(( member(Name, Names),
           sub_atom(Path, _, _, _, Name)
         )).

%   Who sees only the end of what is printed sees which tests failed.

once_more :-
    set_phase(closing),
    findall(Term-Kind, complaint(Term, Kind), Complaints),
    forall(member(Term-Kind, Complaints), print_message(Kind, Term)).

closing_line(Files, Clean) :-
    (   summary(Summary)
    ->  true
    ;   Summary = _{passed:0, failed:0, failed_assertions:0, blocked:0}
    ),
    aggregate_complaints(Complaints),
    length(Files, Count),
    Failed is Summary.failed + Summary.failed_assertions,
    (   Complaints =:= 0,
        Failed =:= 0,
        Summary.passed > 0
    ->  Clean = true,
        Level = informational
    ;   Clean = false,
        Level = error
    ),
    print_message(Level, tests_done(Summary.passed, Failed, Summary.blocked, Complaints, Count)).

aggregate_complaints(Count) :-
    predicate_property(complaint(_, _), number_of_clauses(Count)),
    !.
aggregate_complaints(0).
