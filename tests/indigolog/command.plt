:- module(test_indigolog_command, []).
:- use_module(library(plunit)).
:- use_module(library(aggregate), [aggregate_all/3]).
:- use_module(library(lists), [append/3, member/2, memberchk/2]).
:- use_module(library(process), [process_create/3, process_wait/2]).
:- use_module(library(readutil), [read_file_to_terms/3]).

/** <module> swipl indigolog/run.pl */

here(Folder) :-
    module_property(test_indigolog_command, file(Here)),
    file_directory_name(Here, Folder).

% run(+Words, +Input, -Status, -Output, -Errors): the command on the theory of the tests.
run(Words, Input, Status, Output, Errors) :-
    here(Folder),
    atom_concat(Folder, '/theories/lights.pl', Theory),
    run_on(Theory, Words, Input, Status, Output, Errors).

run_on(Theory, Words, Input, Status, Output, Errors) :-
    here(Folder),
    atom_concat(Folder, '/../../indigolog/run.pl', Script),
    current_prolog_flag(executable, Swipl),
    process_create(Swipl, [Script, '--', Theory|Words],
                   [stdin(pipe(In)), stdout(pipe(Out)), stderr(pipe(Err)), process(Process)]),
    call_cleanup(( call_cleanup(write(In, Input), close(In)),
                   read_string(Out, _, Output),
                   read_string(Err, _, Errors) ),
                 ( close(Out), close(Err), process_wait(Process, exit(Status)) )).

:- begin_tests(command).

test(offline, Status-Output == 0-"inc\nswitch(a)\n2 actions.\n") :-
    run(['[inc, switch(a)]'], "", Status, Output, _).

test(aborted_offline, Status-Output-Said == 1-"inc\n1 actions.\n"-true) :-
    run(['[inc, abort, inc]'], "", Status, Output, Errors),
    said(Errors, "the program was aborted", Said).

test(one_term, [forall(member(Text, ['[inc]. foo bar', 'inc. say(1', 'inc. inc.'])), Status-Output == 2-""]) :-
    run([Text], "", Status, Output, _).

test(a_term_with_its_end, [forall(member(Text, ['inc.', ' inc . % and so on'])), Status-Output == 0-"inc\n1 actions.\n"]) :-
    run([Text], "", Status, Output, _).

test(version_as_the_pack_says, Status-Output == 0-Said) :-
    here(Folder),
    atom_concat(Folder, '/../../indigolog/pack.pl', Pack),
    read_file_to_terms(Pack, Terms, []),
    memberchk(version(Version), Terms),
    format(string(Said), "indigolog ~w~n", [Version]),
    run(['--version'], "", Status, Output, _).

test(online_asks_the_terminal, Status-Output == 0-"look\ninc\n2 actions.\n") :-
    run(['[look, ?(door = open), inc]', '--online'], "open\n", Status, Output, _).

% The question tells what may be answered, where the axioms do.
test(tells_what_may_be_answered, true == Said) :-
    here(Folder),
    atom_concat(Folder, '/theories/treasure.pl', Theory),
    run_on(Theory, ['[peek, knock, look]', '--online'], "2\nhollow\ntrue\n", 0, _, Errors),
    said(Errors, "peek: sensing result (1, 2, 3)? knock: sensing result (dull, hollow)? look: sensing result (true, false)? ", Said).

test(asks_again, true == Said) :-
    here(Folder),
    atom_concat(Folder, '/theories/treasure.pl', Theory),
    run_on(Theory, [look, '--online'], "maybe\ntrue\n", 0, _, Errors),
    said(Errors, "maybe is not one of true, false", Said).

% In the words of the language, not in those that the interpreter writes.
test(program_that_remains, true == Said) :-
    run(['[prioritized_interrupts([interrupt(counter < 2, [inc, search([inc, inc])])])]', '--step'],
        "step\nstep\nprogram\nquit\n", 0, Output, _),
    said(Output, "pconc([search(inc),interrupt(counter<2,[inc,search([inc,inc])])],stop_interrupts)", Said).

test(an_answer_on_two_lines, Status == 0) :-
    run(['[look, ?(door = f(1)), inc]', '--online'], "\nf(\n1).\n", Status, _, _).

test(waits_for_an_event, Status-Output == 0-"inc\n1 actions.\n") :-
    run(['[wait, ?(counter = 10), inc]', '--online'], "nil.\nbump.\n", Status, Output, _).

test(no_more_input, Status-true == 2-Said) :-
    run([wait, '--online'], "", Status, _, Errors),
    said(Errors, "the input ended while the program waited", Said).

% The theory asks nobody, so that nothing can arrive.
test(waits_no_longer, Status-true == 2-Said) :-
    here(Folder),
    atom_concat(Folder, '/theories/deaf.pl', Theory),
    run_on(Theory, ['[act, wait]', '--online', '--max-wait', '0.2'], "", Status, _, Errors),
    said(Errors, "no exogenous action arrived within 0.2 s", Said).

% The theory's own file, and not a journal.
test(a_file_that_a_helper_misses, [setup(( tmp_file_stream(File, Stream, [encoding(utf8), extension(pl)]),
                                           format(Stream, "prim_action(go). poss(go, seen).~n", []),
                                           format(Stream, "seen :- open('/nowhere/at/all', read, _).~n", []),
                                           close(Stream) )),
                                   cleanup(delete_file(File)),
                                   forall(member(Mode, ['--online', '--offline'])),
                                   Status-true == 2-Said ]) :-
    run_on(File, [go, Mode], "", Status, _, Errors),
    said(Errors, "source_sink `'/nowhere/at/all'' does not exist", Said).

test(says_why_it_failed, Status-true == 1-Said) :-
    run(['[inc, ?(lit(b))]', '--online'], "", Status, _, Errors),
    said(Errors, "the program failed\nlit(b) is false", Said).

test(explains_why_there_is_no_execution, Status-true == 1-Said) :-
    run(['[star(inc, 1), ?(lit(b))]', '--explain'], "", Status, _, Errors),
    said(Errors, "after [inc]:\n  lit(b) is false", Said).

test(traces_search, true == Said) :-
    run(['search([inc, inc])', '--trace'], "", _, _, Errors),
    said(Errors, "search found a plan of 2 actions", Said).

test(trace_is_a_known_topic, true(Said \== true)) :-
    run(['search([inc, inc])', '--trace'], "", _, _, Errors),
    said(Errors, "debug topic", Said).

test(traces_events, true == Said) :-
    run(['[wait, look]', '--online', '--trace'], "bump\nopen\n", _, _, Errors),
    said(Errors, "exogenous action bump", Said0),
    said(Errors, "did look, which sensed open", Said1),
    ( Said0 == true -> Said = Said1 ; Said = Said0 ).

test(steps, Status-Output == 0-"Stepping through [inc,inc]. Commands: ? lists them\ninc\n1  inc\ninc\n\
The program may end here\n\"leap\" is not a command; ? lists them\n") :-
    run(['[inc, inc]', '--step'], "s\nnext\nr\nleap\nquit\n", Status, Output, _).

test(no_step_before_the_first, true(sub_string(Output, _, _, _, "\"step -1\" is not a command"))) :-
    run(['[inc, inc]', '--step'], "step -1\nquit\n", _, Output, _).

test(help_of_the_stepper, true == Said) :-
    run(['[inc, inc]', '--step'], "?\n", _, Output, _),
    said(Output, "exog ACTION (e)", Said).

test(a_file_to_include_that_is_not_there,
     [ setup(( tmp_file_stream(File, Stream, [encoding(utf8), extension(pl)]),
               format(Stream, "proc(go, []).~n~n:- include(nowhere).~n", []),
               close(Stream) )),
       cleanup(delete_file(File)),
       Status-true == 2-Said ]) :-
    run_on(File, [go], "", Status, _, Errors),
    format(string(Line), "~w:3:", [File]),
    said(Errors, Line, Said).

test(journal_and_back, [setup(tmp_file(journal, File)), cleanup(delete_file(File)),
                        First-Again-Replayed == "look\ninc\n2 actions.\n"-"look\ninc\n2 actions.\n"-"look\ninc\n2 actions.\n"]) :-
    Program = '[look, ?(door = open), inc]',
    run([Program, '--journal', File, '--seed', '7'], "open\n", 0, First, _),
    run([Program, '--resume', File], "", 0, Again, _),
    run([Program, '--replay', File], "", 0, Replayed, _).

test(the_same_journal_again, [setup(tmp_file(journal, File)), cleanup(delete_file(File)), Status-true == 2-Said]) :-
    run([inc, '--journal', File], "", 0, _, _),
    run([inc, '--journal', File], "", Status, _, Errors),
    said(Errors, "resume it (--resume, resume(File)), or name another file", Said).

test(bad_usage, [forall(wrong(Words, Text)), Status-true == 2-Said]) :-
    run(Words, "", Status, _, Errors),
    said(Errors, Text, Said).

test(no_such_theory, Status-Errors == 2-"no theory file /nowhere/at/all.pl\n") :-
    run_on('/nowhere/at/all.pl', [inc], "", Status, _, Errors).

% A file that is no theory: not a screen of errors.
test(the_first_errors_tell, Status-Count == 2-3) :-
    here(Folder),
    atom_concat(Folder, '/../../README.md', Theory),
    run_on(Theory, [inc], "", Status, _, Errors),
    split_string(Errors, "\n", "", Lines),
    aggregate_all(count, ( member(Line, Lines), sub_string(Line, 0, _, _, "ERROR: ") ), Count).

wrong([], "two arguments are needed").
wrong([inc, '--sideways'], "unknown option --sideways").
wrong([inc, '--max-actions', many], "--max-actions needs a whole number").
wrong([inc, '--max-actions', '-3'], "--max-actions needs a whole number from 0").
wrong([inc, '--seed=x'], "--seed needs a whole number").
wrong([inc, '--journal', '/nowhere/at/all'], "cannot open the journal /nowhere/at/all").
wrong(['foo('], "PROGRAM is not a Prolog term: it ends too early").
wrong(['foo bar'], "PROGRAM is not a Prolog term: operator expected").
wrong([inc, '--max-wait', soon], "--max-wait needs a number of seconds").
wrong([inc, '--max-wait', '1.0Inf'], "--max-wait needs a number of seconds").
wrong([inc, '--journal'], "--journal needs a file").
wrong([inc, Option, '/nowhere/at/all'], "the journal /nowhere/at/all does not exist") :-
    member(Option, ['--resume', '--replay']).

said(Text, Part, Said) :-
    (   sub_string(Text, _, _, _, Part)
    ->  Said = true
    ;   Said = Text
    ).

test(online_says_which_action_failed_and_why_there_is_no_plan,
     [ setup(( tmp_file_stream(File, Stream, [encoding(utf8), extension(pl)]),
               format(Stream, "prim_action(go). poss(go, true). rel_fluent(in). initially(in, false).~n", []),
               format(Stream, "causes_true(go, in, true). exog_action(failed(_, _)). execute(go, _) :- fail.~n", []),
               close(Stream) )),
       cleanup(delete_file(File)),
       Status-Output == 1-"0 actions.\n" ]) :-
    run_on(File, ['searchc([go, ?(in)])', '--online'], "", Status, Output, Errors),
    split_string(Errors, "\n", "", Lines),
    append(_, [ "go failed: execute/2 of the theory failed for go", "the program failed",
                "go failed (execute/2 of the theory failed for go), which the plan did not expect, and from there none is found for searchc(?(in))", "" ], Lines),
    !.

:- end_tests(command).
