:- module(mutations, []).
/** <module> Do the tests notice a wrong interpreter?

    swipl tests/indigolog/mutations.pl [NUMBER...]

plants one mistake at a time (or those of the given numbers) in a copy of the interpreter, runs its tests
there until one fails, and prints which tests caught it.  The exit status is 1 if a mistake was not
caught.
*/

:- use_module(library(filesex), [copy_file/2, delete_directory_and_contents/1, directory_file_path/3, make_directory_path/1]).
:- use_module(library(lists), [member/2, nth1/3]).
:- use_module(library(process), [process_create/3, process_kill/2, process_wait/3]).
:- use_module(library(readutil), [read_file_to_string/3]).

:- initialization(main, main).

%   mutation(What, File, Old, New): Old occurs once in File.

mutation('if takes the other branch', golog,
         "    ->  trans(E, S, C, E1, S1)\n    ;   trans(F, S, C, E1, S1)\n    ).\nfinal(if",
         "    ->  trans(F, S, C, E1, S1)\n    ;   trans(E, S, C, E1, S1)\n    ).\nfinal(if").
mutation('ndet knows only its first program', golog,
         "    (   trans(E, S, C, E1, S1)\n    ;   trans(F, S, C, E1, S1)\n",
         "    (   trans(E, S, C, E1, S1)\n    ;   fail, trans(F, S, C, E1, S1)\n").
mutation('wndet is as ndet', extensions,
         "    *-> E1 = E0, S1 = S0\n",
         "    ,   E1 = E0, S1 = S0\n").
mutation('conc never steps its second program', congolog,
         "        concurrent(E, F0, E1)\n",
         "        concurrent(E, F0, E1), fail\n").
mutation('pconc has no priority', congolog,
         "    *-> S1 = S0,\n",
         "    ,   S1 = S0,\n").
mutation('interrupts in the reverse priority', congolog,
         "by_priority([I|Is], pconc(I, E))",
         "by_priority([I|Is], pconc(E, I))").
mutation('a stopped interrupt runs on', context,
         "stopped_context(c(N, _, M, K, FM, FK), c(N, false, ",
         "stopped_context(c(N, _, M, K, FM, FK), c(N, true, ").
mutation('a procedure that is entered is not final', semantics,
         "        enter_final(E, C, C1),\n",
         "        enter(E, C, C1),\n").
mutation('star(E, N) does not count', extensions,
         "    ;   M is N-1,\n",
         "    ;   M is N,\n").
mutation('a while loop is never final', golog,
         "    ->  final(E, S, C)\n    ;   true\n    ).\n",
         "    ->  final(E, S, C)\n    ;   fail\n    ).\n").
mutation('a sequence is final where its head is', golog,
         "    final(E, S, C),\n    final(L, S, C).\n",
         "    final(E, S, C), ( true ; final(L, S, C) ).\n").
mutation('gexec goes on without its condition', conditions,
         "    once_if_ground(P, holds_in(P, S)),\n    trans(E, S, C, E0, S1),\n    around(E0, gexec(P, E0), E1)",
         "    trans(E, S, C, E0, S1),\n    around(E0, gexec(P, E0), E1)").
mutation('goal/4 steps although it is done', conditions,
         "    \\+ holds_in(P, S),\n",
         "").
mutation('sync ends without silent steps', extensions,
         "    all_end(Es, S, C).\n\ntogether",
         "    final(Es, S, C).\n\ntogether").
mutation('atomic can be interrupted', extensions,
         "    ;   locked('$atomic'(E0), E1)\n",
         "    ;   E1 = E0\n").
mutation('what is beside a locked program steps', congolog,
         "    ;   free(E),\n        trans(F, S, C, F0, S1),\n        concurrent",
         "    ;   trans(F, S, C, F0, S1),\n        concurrent").
mutation('for goes through its domain in reverse', extensions,
         "    instances(Values, V, E, Es).\n",
         "    lists:reverse(Values, Reversed), instances(Reversed, V, E, Es).\n").
mutation('an inner variable is not hidden', substitution,
         "hides(pi(V, E),           X, D, pi(W, E), D1)           :- binds(V, X, D, W, D1).\n",
         "").
mutation('the last axiom counts, not the first', progression,
         "        sort(1, @<, Numbered, Unique),\n",
         "        sort(2, @>, Numbered, Latest), sort(1, @<, Latest, Unique),\n").
mutation('an effect on all instances does not count before one on one', progression,
         "sets(open(Pattern, _, Condition), F, Situation) :-\n",
         "sets(open(Pattern, _, Condition), F, Situation) :-\n    fail,\n").
mutation('all instances have their initial value', situation,
         "            (   effect_instance(Effects, Before, Fluent, Status0)\n",
         "            (   fail, effect_instance(Effects, Before, Fluent, Status0)\n").
mutation('causes_false makes true', progression,
         "    ;   Module:causes_false(A, F, Condition), V = false\n",
         "    ;   Module:causes_false(A, F, Condition), V = true\n").
mutation('set makes false', progression,
         "assigned(set(F), F-true).",
         "assigned(set(F), F-false).").
mutation('a built-in effect hides the action of a theory', theory,
         "assignment(set(F), Theory) => \\+ action_template(Theory, set(F), _).",
         "assignment(set(_), _) => true.").
mutation('what follows a plan is tested again', search,
         "            E1 = [],\n            S1 = S\n",
         "            fail,\n            E1 = [],\n            S1 = S\n").
mutation('impl is and', formula,
         "means(impl(P, Q), S, ( true_in(P, S) -> \\+ \\+ true_in(Q, S) ; true )).",
         "means(impl(P, Q), S, ( true_in(P, S) -> \\+ \\+ true_in(Q, S) ; fail )).").
mutation('all is some', formula,
         "means(all(V, P), S, \\+ ( instance(V, P, S, P1), \\+ true_in(P1, S) )).",
         "means(all(V, P), S, \\+ \\+ ( instance(V, P, S, P1), true_in(P1, S) )).").
mutation('one world is enough to know', knowledge,
         "    in_all_worlds(Goal, W1),\n    in_each(Vs, F, Goal, W).",
         "    in_all_worlds(Goal, W1), ( true ; in_each(Vs, F, Goal, W) ).").
mutation('nothing is rejected', sensing,
         "    exclude(rejected(F, A, R, Module, S), Vs0, Vs),",
         "    exclude([_]>>fail, Vs0, Vs),").
mutation('kwhether is know', knowledge,
         "        known(neg(P), S)\n",
         "        fail\n").
mutation('effects do not look at all worlds', knowledge,
         "    append(Here, More, Results),\n    results_of_each(Vs, F, Goal, W, More).",
         "    append(Here, [], Results), ( true ; results_of_each(Vs, F, Goal, W, More) ).").
mutation('a plan forgets all but the first result', conditional,
         "    branches(Rs, A, S, Rest, Branches1).\n",
         "    Branches1 = [], ( true ; branches(Rs, A, S, Rest, Branches1) ).\n").
mutation('case takes the oldest result', conditional,
         "    member(e(A, R), History),\n",
         "    lists:reverse(History, Oldest), member(e(A, R), Oldest),\n").
mutation('search is content with its first step', depth_first,
         "onward(E, S, C, _, []) :-\n    final(E, S, C).\n",
         "onward(_, _, _, _, []).\n").
mutation('a compiled condition is not negated', compiled,
         "    Goal = ( \\+ A1 ),\n    unfolded(A, In, A1).",
         "    unfolded(A, In, Goal).").
mutation('a compiled quantifier keeps its value', compiled,
         "    substitute(V, _, P, P1).",
         "    substitute(V, none, P, P1).").
mutation('a compiled equality of arguments binds them', compiled,
         "    (   (   var(V), \\+ plain(V, In)\n",
         "    (   (   var(V)\n").
mutation('compiled effects of causes_false are left out', progression,
         "            ;   Module:'$sets_false'(Action, Situation, Effect)\n",
         "").
mutation('any action is plain', action,
         "        \\+ ( sub_term(T, Action), callable(T), fluent_template(Theory, T, _) )\n",
         "        true\n").
mutation('what was set last is lost when the list is full', values,
         "    ;   put_pairs(Recent, Old, Old1),\n",
         "    ;   put_pairs([], Old, Old1),\n").
mutation('a conditional plan goes on whatever happens', monitor,
         "    plan_expects(Expected, S),\n    !.\nas_planned(Plan",
         "    ( plan_expects(Expected, S) ; true ),\n    !.\nas_planned(Plan").
mutation('a conditional plan made again forgets what was done', monitor,
         "    (   memberchk(N1, Own)\n",
         "    (   memberchk(N1, Own), fail\n").
mutation('one action too many', turn,
         "            Count >= Max\n",
         "            Count > Max\n").
mutation('the world is asked after the program has ended', turn,
         "        ;   next(T1, E, S)\n",
         "        ;   next(T0, E, S)\n").
mutation('a list of variables with domains hides nothing', substitution,
         "    ->  member(V0, V), binds(V0, X)\n",
         "    ->  member(V0, V), V0 == X\n").
mutation('constraints do not tell configurations apart', memory,
         "variant_sha1(E1-Values-Constraints, Key)",
         "variant_sha1(E1-Values, Key)").

main :-
    current_prolog_flag(argv, Argv),
    findall(I-M, numbered(Argv, I, M), Chosen),
    flag(missed, _, 0),
    forall(member(I-M, Chosen), tried(I, M)),
    flag(missed, Missed, Missed),
    length(Chosen, N),
    Caught is N-Missed,
    format("~d of ~d caught~n", [Caught, N]),
    ( Missed =:= 0 -> halt(0) ; halt(1) ).

numbered(Argv, I, mutation(What, File, Old, New)) :-
    findall(mutation(W, F, O, N), mutation(W, F, O, N), All),
    nth1(I, All, mutation(What, File, Old, New)),
    (   Argv == [] -> true ; atom_number(Word, I), member(Word, Argv) ).

tried(I, mutation(What, File, Old, New)) :-
    setup_call_cleanup(
        ( tmp_file(mutation, Folder), copied(Folder) ),
        ( planted(Folder, File, Old, New),
          (   member(Tests, [language, 'indigolog.plt', values, open_effects, differential, '']),
              fails(Folder, Tests, How)
          ->  named(Tests, Name),
              format("~|~t~d~3+ caught  ~w~t~20| ~w: ~w~n", [I, Name, What, How])
          ;   format("~|~t~d~3+ MISSED  ~t~20| ~w~n", [I, What]),
              flag(missed, M, M+1)
          ),
          flush_output ),
        delete_directory_and_contents(Folder)).

named('', 'others') :- !.
named('indigolog.plt', constructs) :- !.
named(Name, Name).

% The tests need these, in their places.
copied(Folder) :-
    module_property(mutations, file(Here)),
    file_directory_name(Here, Tests),
    atom_concat(Tests, '/../../', Root),
    forall(member(Pattern, ['indigolog/*.pl', 'indigolog/*/*.pl', 'tests/run.pl', 'tests/indigolog/*.p*',
                            'tests/indigolog/theories/*.pl', 'docs/*.md', 'examples/*.pl', 'benchmarks/theories/*.pl',
                            'benchmarks/golog.pl']),
           ( atom_concat(Root, Pattern, Whole),
             expand_file_name(Whole, Files),
             forall(member(File, Files), copy_below(Root, File, Folder)) )).

copy_below(Root, File, Folder) :-
    atom_concat(Root, Path, File),
    directory_file_path(Folder, Path, Target),
    file_directory_name(Target, Directory),
    make_directory_path(Directory),
    copy_file(File, Target).

planted(Folder, File, Old, New) :-
    atomic_list_concat([Folder, '/indigolog/*/', File, '.pl'], Pattern),
    expand_file_name(Pattern, [Path]),
    read_file_to_string(Path, Text, [encoding(utf8)]),
    (   findall(B, sub_string(Text, B, _, _, Old), [Before])
    ->  true
    ;   throw(error(existence_error(mutated_text, File-Old), _))
    ),
    sub_string(Text, 0, Before, _, Head),
    string_length(Old, Length),
    After is Before+Length,
    sub_string(Text, After, _, 0, Tail),
    setup_call_cleanup(open(Path, write, Out, [encoding(utf8)]),
                       format(Out, "~s~s~s", [Head, New, Tail]),
                       close(Out)).

% A run of the tests that does not end in three minutes fails too.
fails(Folder, Tests, How) :-
    atom_concat('indigolog/', Tests, Name),
    process_create(path(swipl), ['-g', main, 'tests/run.pl', '--', Name],
                   [ cwd(Folder), stdout(null), stderr(null), process(Process) ]),
    process_wait(Process, Status, [timeout(180)]),
    (   Status == timeout
    ->  process_kill(Process, kill),
        process_wait(Process, _, []),
        How = 'does not end'
    ;   Status \== exit(0),
        How = 'a test fails'
    ).
