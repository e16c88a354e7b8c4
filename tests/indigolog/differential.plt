:- module(test_indigolog_differential, []).
:- use_module(library(plunit)).
:- use_module(library(process), [process_create/3, process_wait/2]).

/** <module> Random agents behave as the axioms say: what agreement.pl compares, for 400 programs, 100 where TESTS=quick */

agreement(Programs, Seed, Status, Words) :-
    module_property(test_indigolog_differential, file(Here)),
    file_directory_name(Here, Folder),
    atom_concat(Folder, '/agreement.pl', Script),
    current_prolog_flag(executable, Swipl),
    process_create(Swipl, [Script, Programs, Seed], [stdout(pipe(Out)), process(Process)]),
    call_cleanup(read_string(Out, _, Words), ( close(Out), process_wait(Process, Status) )).

:- begin_tests(differential).

test(alike, Status-Start == exit(0)-Expected) :-
    (   getenv('TESTS', quick)
    ->  Programs = 100
    ;   Programs = 400
    ),
    format(string(Expected), "~d programs alike: ", [Programs]),
    agreement(Programs, 1, Status, Words),
    string_length(Expected, Length),
    sub_string(Words, 0, Length, _, Start).

:- end_tests(differential).
