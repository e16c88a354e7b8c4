:- module(test_indigolog_interpreter_page, []).
:- use_module(library(plunit)).
:- use_module(library(lists), [append/3, member/2]).
:- use_module(library(process), [process_create/3, process_wait/2]).
:- use_module(library(readutil), [read_file_to_string/3]).
:- use_module('../../indigolog/indigolog').

/** <module> What docs/interpreter.md shows is what happens */

root(Root) :-
    module_property(test_indigolog_interpreter_page, file(Here)),
    file_directory_name(Here, Folder),
    absolute_file_name('../..', Root, [relative_to(Folder), file_type(directory)]).

line(Line) :-
    root(Root),
    atom_concat(Root, '/docs/interpreter.md', Page),
    read_file_to_string(Page, Text, []),
    split_string(Text, "\n", "", Lines),
    member(Line0, Lines),
    string_concat("    ", Line, Line0).

% words(-Words): of a command line of the page.
words(Words) :-
    line(Line),
    string_concat("swipl indigolog/run.pl -- ", Rest, Line),
    split_string(Rest, " ", "", Words).

run(Words, Input, Status, Output) :-
    root(Root),
    current_prolog_flag(executable, Swipl),
    process_create(Swipl, ['indigolog/run.pl', '--'|Words],
                   [cwd(Root), stdin(pipe(In)), stdout(pipe(Out)), stderr(null), process(Process)]),
    call_cleanup(( call_cleanup(write(In, Input), close(In)), read_string(Out, _, Output) ),
                 ( close(Out), process_wait(Process, exit(Status)) )).

% The lines that are typed in the session by hand, and what is printed.
typed(Typed) :-
    line(Line),
    string_concat("> ", Typed, Line).

printed(Printed) :-
    findall(Line, line(Line), Lines),
    append(_, ["> next"|Session], Lines),
    append(Answers, ["> quit"|_], Session),
    member(Printed, Answers),
    \+ string_concat("> ", _, Printed).

:- begin_tests(interpreter_page).

test(there_are_commands, true(Count >= 5)) :-
    aggregate_all(count, words(_), Count).

test(commands, [forall(words(Words)), Status == 0]) :-
    run(Words, "", Status, _).

test(by_hand, Lines == Expected) :-
    findall(Line, ( typed(Typed), atomics_to_string([Typed, "\n"], Line) ), Input0),
    atomics_to_string(Input0, Input),
    once(( words(Words), append(_, ["--step"], Words) )),
    run(Words, Input, 0, Output),
    split_string(Output, "\n", "", [_|Lines0]),
    once(append(Lines, [""], Lines0)),
    findall(Line, printed(Line), Expected).

test(from_prolog) :-
    root(Root),
    atom_concat(Root, '/examples/elevator.pl', File),
    load_theory(File),
    once(do(control, [], [_|_])).

:- end_tests(interpreter_page).
