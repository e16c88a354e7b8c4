:- module(indigolog_messages, []).
/** <module> What the interpreter says */

:- use_module(library(apply), [exclude/3]).
:- use_module(library(lists), [append/3, member/2]).
:- use_module('../language/history', [history_situation/2, own_step/1]).
:- use_module(explain, [why/3]).
:- use_module(explanation_text, [explanations//1, shown_program/2]).
:- use_module(problem_texts, [hint//1, problem//1, step_hint//1]).

:- multifile prolog:message//1, prolog:error_message//1.

prolog:message(golog(Message)) -->
    message(Message).
prolog:error_message(golog(Error)) -->
    error_text(Error).
prolog:message(error(Formal, Where)) -->
    { nonvar(Where), Where = golog(world(Asked), Context) },
    '$messages':translate_message(error(Formal, Context)),
    { copy_term(Asked, Shown), numbervars(Shown, 23, _, [singletons(true)]) },
    [ nl, '  in ~W of the theory'-[Shown, [quoted(true), portray(true), numbervars(true), max_depth(14)]] ].
prolog:message(error(Formal, Where)) -->
    { nonvar(Where),
      Where = golog(at(E, History), Point),
      (   nonvar(Point), Point = point(_, _, Context) -> true ; Context = Point ) },
    '$messages':translate_message(error(Formal, Context)),
    point(Point, E),
    { shown_program(E, Shown) },
    [ nl, '  in ~W'-[Shown, [quoted(true), portray(true), numbervars(true), max_depth(14)]] ],
    where(History).

point(Point, E) -->
    (   { nonvar(Point), Point = point(Part, Bindings, _), Part \== E }
    ->  { shown_program(Part, Shown) },
        [ nl, '  at ~W'-[Shown, [quoted(true), portray(true), numbervars(true), max_depth(14)]] ],
        bindings(Bindings)
    ;   []
    ).

bindings([]) --> [].
bindings([B|Bs]) -->
    [ nl, '  with ~q'-[B] ],
    bindings(Bs).

where([]) --> [ nl, '  in the initial situation'-[] ].
where([A|H]) -->
    { actions([A|H], Actions), length(Actions, N) },
    [ nl, '  after ~D actions, newest first ~W'-
          [N, [A|H], [quoted(true), portray(true), max_depth(8)]] ].

actions(History, Actions) :-
    exclude(own_step, History, Actions).

message(prompt(sensing(A, Results))) -->
    [ '~q: sensing result'-[A] ],
    (   { Results == [] }
    ->  []
    ;   { some_terms(Results, Text) },
        [ ' (~w)'-[Text] ]
    ),
    [ '? ', flush ].
message(long_execution(N)) -->
    [ '~D actions and no end yet: a loop that never ends goes on until half of the stack is used, for minutes;'-[N], nl,
      'Ctrl-C ends it, and a limit (--max-actions, do/4) before that'-[] ].
message(prompt(step)) -->
    [ '> ', flush ].
message(prompt(exogenous)) -->
    [ 'Exogenous action (nil. for none)? '-[], flush ].

message(progress(plan(found, Actions))) -->
    { length(Actions, N) },
    [ 'search found a plan of ~D actions: ~p'-[N, Actions] ].
message(progress(plan(kept, Actions))) -->
    { length(Actions, N) },
    [ 'the world is not as expected; the ~D actions left of the plan still do: ~p'-[N, Actions] ].
message(progress(planned_again(Plan))) -->
    [ 'the world is not as expected; the conditional plan is now ~p'-[Plan] ].
message(progress(planning(Text))) -->
    [ 'planning: ~p'-[Text] ].
message(search_budget(max_mb(Megabytes, Configurations))) -->
    [ 'search gave up: it had met ~D configurations, ~D MB, and found no plan; '-[Configurations, Megabytes],
      'search(E, [max_mb(M)]) allows for more, strategy(iterative) or an estimate needs less'-[] ].
message(search_budget(Budget)) -->
    [ 'search used up its budget ~q before it found a plan: it fails'-[Budget] ].
message(progress(waiting)) -->
    [ 'waiting for an exogenous action'-[] ].
message(progress(executed(_, A, none))) -->
    [ 'did ~p'-[A] ].
message(progress(executed(_, A, Sensing))) -->
    { Sensing \== none },
    [ 'did ~p, which sensed ~p'-[A, Sensing] ].
message(progress(exogenous(_, A))) -->
    [ 'exogenous action ~p'-[A] ].
message(progress(failed(_, A, Reason))) -->
    [ '~p failed: ~p'-[A, Reason] ].
message(device_left(Device)) -->
    [ 'Device ~q does not end: its thread is left behind'-[Device] ].
message(no_answer_of(Answer, Results)) -->
    { some_terms(Results, Text) },
    [ '~q is not one of ~w'-[Answer, Text] ].
message(open_answer(Answer)) -->
    [ '~p has variables in it; a ground term, please'-[Answer] ].
message(directive(Missing)) -->
    (   { Missing = file(File) }
    ->  [ 'there is no file ~q'-[File] ]
    ;   { Missing = predicate(PI) },
        [ 'there is no ~q'-[PI] ]
    ),
    [ '; if this is to load an interpreter, leave it out: one is here already'-[] ].
message(no_term(Text)) -->
    [ '~w: not a Prolog term; once more, please'-[Text] ].
message(undeclared_event(A)) -->
    [ 'Ignored ~q: the theory declares no such exogenous action'-[A] ].

message(problem(File, Line, What)) -->
    (   { File == program }
    ->  []
    ;   [ '~w:~d: '-[File, Line] ]
    ),
    problem(What).

% The first few of a list, as they are read.
some_terms(Terms, Text) :-
    most_terms(Most),
    length(Terms, N),
    (   N =< Most
    ->  Shown = Terms, More = ''
    ;   length(Shown, Most),
        append(Shown, _, Terms),
        More = ', ...'
    ),
    findall(Word, ( member(T, Shown), format(atom(Word), "~q", [T]) ), Words),
    atomic_list_concat(Words, ', ', Listed),
    atom_concat(Listed, More, Text).

most_terms(8).                          % chosen by hand

error_text(Error) -->
    { said(Error, Format, Args) },
    !,
    [ Format-Args ].
error_text(search_option(Option)) -->
    [ '~q is not an option of search/2: strategy(depth, breadth, iterative, best, astar or beam(Width)), '-[Option], nl,
      'heuristic(Term), cost(Term), cost(Action, Term), weight(W), max_nodes(N), max_seconds(T), max_mb(M), anytime(true)'-[] ].
error_text(search_depth(N)) -->
    [ 'search followed an execution for ~D actions without coming to its end; '-[N], nl,
      'search(E, [strategy(depth)]) goes on within its budget, strategy(breadth) finds a shorter one if there is one'-[] ].
error_text(unknown_action(A)) -->
    { functor(A, Name, Arity) },
    [ '~q is neither an action nor a procedure of the theory (~q)'-[Name/Arity, A] ],
    step_hint(A).
error_text(unknown_entry(A)) -->
    [ '~p in a history is not an action of the theory'-[A] ],
    ( { callable(A) } -> hint(A) ; [] ).
error_text(open_end(N, Open)) -->
    [ 'no end was found within ~D actions, and ~D steps left another choice open; a loop as star(E) goes on before'-[N, Open], nl,
      'what follows it is tried: while(neg(P), E) in place of [star(E), ?(P)], or search(E, [strategy(breadth)]), which'-[], nl,
      'finds a shorter execution if there is one; one that long may go on to a limit that is given (--max-actions, do/4)'-[] ].
error_text(no_end(N)) -->
    [ 'no end was found within ~D actions, which fill half of the stack; a loop as star(E) goes on before what'-[N], nl,
      'follows it is tried: while(neg(P), E) in place of [star(E), ?(P)], a limit (--max-actions, do/4) or'-[], nl,
      'search(E, [strategy(breadth)]) finds a shorter execution if there is one, swipl --stack-limit=4g a longer one'-[] ].
error_text(no_clause(Call, Fluents)) -->
    { functor(Call, Name, Arity) },
    [ 'no clause of the procedure ~q matches ~p'-[Name/Arity, Call] ],
    (   { Fluents = [F|_] }
    ->  [ ': the fluent ~p is handed over by name; pi(x, [?(x = ~p), E]) binds x to its value'-[F, F] ]
    ;   []
    ).
error_text(recursion(Call, N)) -->
    [ 'procedure calls nest ~D deep without an action, the last is ~W'-
          [N, Call, [quoted(true), max_depth(8)]] ].
error_text(program_ended(Outcome, Rest, History)) -->
    { actions(History, Actions), length(Actions, N) },
    [ 'the program ended as ~w after ~D actions'-[Outcome, N] ],
    stands(Outcome, Rest, History).
error_text(no_value(F, History)) -->
    [ 'fluent ~q has no value'-[F] ],
    after(History).

% said(?Error, -Format, -Args): those that take no more than that.
said(unknown_formula(Name/Arity), '~q is neither a fluent nor an abbreviation nor a predicate', [Name/Arity]).
said(undeclared_instance(F), 'fluent ~q is not one of those that are declared', [F]).
said(silent(N), 'the program made ~D steps without an action', [N]).
said(search_value(heuristic, Term), 'the estimate ~p has no value that is a number from 0 on', [Term]).
said(search_value(cost(A), Term), 'the cost ~p of ~q has no value that is a number from 0 on', [Term, A]).
said(reported, 'the theory or the program is wrong: see above', []).
said(no_commit, 'commit is not of this language: search does not prune what it may still need', []).
said(open_program, 'the program is an unbound variable where a step is asked of it', []).
said(open_action(A), 'action ~q is not ground', [A]).
said(not_a_program(E), '~q is not a program', [E]).
said(no_journal(File), 'the journal ~w does not exist or tells of no run', [File]).
said(other_program(File, Program), 'the journal ~w tells of another program, ~q', [File, Program]).
said(journal_differs(Entry, _), 'the program does not come to what the journal tells next, ~q', [Entry]).
said(journal(File, Line), '~w:~d: not a fact of a journal', [File, Line]).
said(no_device(Module, PI), '~q is not a device: it does not define ~q', [Module, PI]).
said(unknown_option(Option), '~p is not an option of indigolog/2', [Option]).
said(option_value(Option, What), 'the option ~p takes ~w', [Option, What]).
said(no_run(Name), 'no run named ~q is going on', [Name]).
said(called_halt, 'halt was called, which would end Prolog and not the program: abort ends a program', []).
said(nothing_runs(A), '~q was reported, and no program runs', [A]).
said(several_runs(A), '~q was reported, and several programs run: report_exogenous(Run, Action) says which is meant', [A]).
said(journal_in_use(File), '~w is the journal of another run that is going on', [File]).
said(journal_exists(File),
     '~w is there already, and a journal tells of one run: resume it (--resume, resume(File)), or name another file', [File]).
said(journal_not_written(File, Why), 'cannot write the journal ~w: ~w', [File, Why]).
said(run_exists(Name), 'a run named ~q is going on already', [Name]).
said(nothing_happened(Seconds), 'no exogenous action arrived within ~w s', [Seconds]).
said(deadline(started, Seconds), 'the device did not start within ~w s', [Seconds]).
said(deadline(A, Seconds), 'the device did not finish ~q within ~w s', [A, Seconds]).
said(device_failed(theory, A), 'execute/2 of the theory failed for ~q', [A]) :- !.
said(device_failed(D, A), 'device ~q failed to execute ~q', [D, A]).
said(not_boolean_result(A, F, R), '~q sensed ~q, but ~q, which it senses, is true or false', [A, R, F]).
said(nothing_sensed(A), 'no sensing result was given for ~q', [A]).
said(open_result(A), 'the sensing result that was given for ~q has variables in it', [A]).
said(open_event(A), 'the exogenous action ~p is not ground', [A]).
said(no_event(A), '~p is told where an exogenous action must be: one each time, and not in a list', [A]).
said(no_events(D, nothing), 'device ~q: its exogenous/1 failed; with nothing to report it gives []', [D]).
said(no_events(D, As), 'device ~q reports ~p: its exogenous/1 gives a list of ground actions', [D, As]).
said(no_theory, 'No theory is loaded: call load_theory(File) first', []).
said(load(Files, Count), '~w error(s) while loading the theory ~q: see above', [Count, Files]).
said(module_header(File, Own), '~w begins with module(~q, ...): a theory file is plain Prolog with no header', [File, Own]).
said(no_domain(D), '~q is neither a list nor a predicate of the theory whose one argument is that list, or each element', [D]).
said(not_a_formula(P), '~q is not a formula', [P]).
said(not_a_formula(P, G), '~q is not a formula: its value is ~q', [P, G]).
said(effect_not_ground(A, F, V), 'an effect of ~q sets ~q to ~q, which is not ground', [A, F, V]).
said(impossible_result(A, R, F), 'the result ~q of ~q contradicts every possible value of ~q', [R, A, F]).
said(cannot_branch(P),
     'branch(~q): neither a relational fluent nor Fluent = Value for a fluent with several possible values', [P]).
said(achieve_option(O), '~q is not an option of achieve/3: actions(List), id(Name), simid(Id), mess(Text)', [O]).
said(simulator_loops(Id),
     'simulator(~q, Condition, Action) goes on for ever: its actions do not make its conditions false', [Id]).
said(unknown_exogenous(A), 'sim(~q): the theory declares no such exogenous action', [A]).
said(no_answer(wait), 'the input ended while the program waited for an exogenous action', []).
said(no_answer(A), 'the input ended before it gave a sensing result for ~q', [A]).

% What a program that failed could not get past.
stands(failed, Rest, History) -->
    { catch(( history_situation(History, S), why(Rest, S, [Why|Whys]) ), _, fail) },
    !,
    [ ':'-[], nl ],
    explanations([Why|Whys]).
stands(_, _, _) --> [].

after(History) -->
    { actions(History, Actions) },
    after_actions(Actions).

after_actions([]) --> [ ' in the initial situation'-[] ].
after_actions([A|H]) -->
    { length([A|H], N) },
    [ ' after ~D actions, the last of them ~q'-[N, A] ].
