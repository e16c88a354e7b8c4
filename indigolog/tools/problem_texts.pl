:- module(indigolog_problem_texts,
          [ problem//1,               % +What
            hint//1,                  % +Term
            step_hint//1              % +Program
          ]).
/** <module> What is said of a mistake in a theory or a program */

:- use_module(library(apply), [maplist/2, maplist/3]).
:- use_module(formula_parts, [is_formula/2]).
:- use_module(program_checks, [near_miss/3]).
:- use_module('../language/theory', [current_theory/1]).

%!  problem(+What)// is det.
%
%   What is that of a problem(Kind, File, Line, What) of checks.pl.

problem(What) -->
    { said(What, In, Format, Args0) },
    !,
    { maplist(argument, Args0, Args) },
    inside(In),
    [ Format-Args ],
    (   { What = unknown_call(_, E) }
    ->  step_hint(E)
    ;   { meant(What, Term) }
    ->  hint(Term)
    ;   []
    ).
problem(kept_variable(In, Part)) -->
    inside(In),
    { anonymous(Part, Shown) },
    [ 'a variable in ~W keeps in every round of the loop the value of the first: bind it with pi or some'-
          [Shown, [quoted(true), numbervars(true)]] ].
problem(unused_clause(In, clause(File, Line))) -->
    inside(In),
    (   { File == same }
    ->  [ 'the clause in line ~d comes first and matches all that this one does'-[Line] ]
    ;   { file_base_name(File, Name) },
        [ 'the clause in ~w, line ~d, comes first for the same calls: another name is needed'-[Name, Line] ]
    ).
problem(negated_variable(In, V, Negation)) -->
    inside(In),
    [ '~q has no value yet where ~q asks of it, which is true only where it is so of no ~q: give it a domain, or bind it before'-
          [V, Negation, V] ].
problem(axiom_arity(Given, Expected)) -->
    [ '~q has the wrong number of arguments: it is '-[Given] ],
    alternatives(Expected).
problem(recursion(Kind, Name, Path)) -->
    { functor(Name, F, N),
      length(Path, Length),
      Steps is Length-1 },
    [ 'procedure ~q can come back to itself, in ~D call(s), before any action or test'-[F/N, Steps] ],
    (   { Kind == program }
    ->  [ ': not all is found that may follow such a call; one after the action finds it'-[] ]
    ;   []
    ).

% anonymous(+Term, -Shown): its variables are underscores, where it is printed with ~p.
anonymous(Term, Shown) :-
    copy_term(Term, Shown),
    term_variables(Shown, Variables),
    maplist(=('$VAR'('_')), Variables).

argument('$pi'(Term), Shown) =>
    functor(Term, Name, Arity),
    Shown = Name/Arity.
argument(Arg, Shown) =>
    Shown = Arg.

% said(?What, -In, -Format, -Args): In is where in the theory that is, `none` where the file and the line are enough;
% '$pi'(T) is shown as name and arity.
said(unknown_action(Axiom, A), none, '~w axiom for ~q, which is not a declared action', [Axiom, '$pi'(A)]).
said(axiom_of_procedure(Axiom, A), none, '~w axiom for ~q, which is a procedure, not an action: it never applies',
     [Axiom, '$pi'(A)]).
said(unknown_fluent(Axiom, F), none, '~w axiom for ~q, which is not a declared fluent', [Axiom, '$pi'(F)]).
said(unknown_call(In, Call), In, '~q is neither an action nor a procedure of the theory', ['$pi'(Call)]).
said(no_instance(In, A), In, 'action ~q is not one of those that are declared', [A]).
said(no_clause(In, A), In, 'no clause of the procedure ~q matches ~q', ['$pi'(A), A]).
said(no_program(In, E), In, '~q stands where a program must', [E]).
said(no_formula(In, P), In, '~q stands where a formula must', [P]).
said(procedure_tested(In, P), In, '~q stands where a formula must, and is a procedure that acts', ['$pi'(P)]).
said(formula_run(In, P), In, '~q stands where a program must, and is a formula: ?(~q) tests it', ['$pi'(P), P]).
said(unknown_formula(In, P), In, '~q is neither a fluent nor an abbreviation nor a predicate', ['$pi'(P)]).
said(fluent_arity(In, F, Declared), In, '~q has the name of the fluent ~q', ['$pi'(F), Declared]).
said(no_number(In, T), In, '~q is calculated with, and is neither a fluent nor bound by pi or some', [T]).
said(constant_equality(In, P), In, '~q compares constants: neither side is a fluent', [P]).
said(never_equal(In, F, V), In, 'relational fluent ~q is compared with ~q, neither true nor false', [F, V]).
said(unknown_assigned(In, E, F), In, '~q: ~q is not a declared fluent', [E, '$pi'(F)]).
said(functional_assigned(In, E, F), In, '~q is for relational fluents, ~q is functional', ['$pi'(E), '$pi'(F)]).
said(undeclared_instance(In, F), In, 'fluent ~q is not one of those that are declared', [F]).
said(impossible_value(F, V), none, '~q is not among the initial values of ~q', [V, F]).
said(two_values(F, V, First), none, 'fluent ~q is initially ~q: the value ~q given here does not count', [F, First, V]).
said(open_value(F, V), none, 'fluent ~q is initially ~p, which is not ground: it matches another value each time',
     [F, V]).
said(exogenous_step(In, A), In, '~q is an exogenous action: as a step of a program it is never possible', [A]).
said(unknown_event(A), none, 'exog_occurs tells of ~q, which is not a declared exogenous action: it is ignored', ['$pi'(A)]).
said(no_commit(In), In, 'commit is not of this language: search does not prune what it may still need', []).
said(idle_loop(In, E), In, 'the loop ~q makes no action: once begun, only an exogenous action can end it', [E]).
said(empty_loop(In, E), In, 'the loop ~q has nothing to do: it ends at once, whatever its condition', [E]).
said(no_domain(In, D), In, 'the domain ~q is neither a list nor a predicate of one argument', [D]).
said(no_variable(In, V), In, '~q stands where a variable must: a Prolog variable or an atom', [V]).
said(no_count(In, E, N), In, '~q takes a whole number, not ~q', ['$pi'(E), N]).
said(no_seconds(In, E, T), In, '~q takes a number of seconds from 0, not ~q', ['$pi'(E), T]).
said(no_list(In, E, A), In, '~q takes a list, not ~q', ['$pi'(E), A]).
said(no_result(In, P, R), In, '~q gives its result to ~q, an atom that neither pi nor some binds: a Prolog variable takes it',
     ['$pi'(P), R]).
said(captured_value(In, V, Value), In, '~q is the name of a variable here and a value ~w: where the value comes in it is \
taken for the variable', [V, Where]) :-
    value_place(Value, Where).
said(unused(In, Construct, V), In, '~w binds ~q, which is not used', [Construct, V]).
said(no_poss(A), none, 'action ~q has no precondition axiom and will never be possible', ['$pi'(A)]).
said(no_initial(F), none, 'fluent ~q has no initial value: initially(~p, Value) gives it one', ['$pi'(F), Shown]) :-
    anonymous(F, Shown).
said(no_initial_value(F), none, 'fluent ~q has no initial value: initially(~q, Value) gives it one', [F, F]).
said(undefined_call(PI), none, '~q is called here and not defined', [PI]).
said(misspelt(Name, Meant), none, '~q is used nowhere, and is no axiom: ~q may be meant', [Name, Meant]).
said(two_kinds(F), none, 'fluent ~q is declared relational and functional', ['$pi'(F)]).
said(two_uses(P), none, 'procedure ~q has the name of an action or a fluent, and hides it', ['$pi'(P)]).
said(reserved(A), none, '~q is an entry of the interpreter\'s own in histories: the action needs another name',
     ['$pi'(A)]).
said(hidden(A), none, '~q has the name of a construct of the language, which hides it', ['$pi'(A)]).
said(not_relational(F), none, 'causes_true and causes_false are for relational fluents, ~q is functional', ['$pi'(F)]).
said(not_boolean(F, V), none, 'relational fluent ~q is given the value ~q, neither true nor false', ['$pi'(F), V]).

value_place(program, 'in the program').
value_place(clause(same, Line), Where) :-
    !,
    format(atom(Where), 'in line ~d', [Line]).
value_place(clause(File, Line), Where) :-
    file_base_name(File, Name),
    format(atom(Where), 'in ~w, line ~d', [Name, Line]).

% What may have been meant by another name or number of arguments.
meant(unknown_action(_, A), A).
meant(unknown_event(A), A).
meant(unknown_fluent(_, F), F).
meant(unknown_formula(_, P), P).
meant(unknown_assigned(_, _, F), F).

inside(none) -->
    [].
inside(in(In, _)) -->
    (   { nonvar(In), In = of(What, A) }
    ->  { functor(A, Name, Arity) },
        [ '~w of ~q: '-[What, Name/Arity] ]
    ;   { In == program }
    ->  [ 'program: '-[] ]
    ;   { functor(In, Name, Arity) },
        [ 'procedure ~q: '-[Name/Arity] ]
    ).

%!  hint(+Term)// is det.
%
%   Another number of arguments may have been meant, or what Prolog would write so.
hint(Term) -->
    (   { in_golog(Term, Words) }
    ->  [ ': ~w'-[Words] ]
    ;   { current_theory(Theory),
          near_miss(Theory, Term, Declared) }
    ->  [ '; there is ~q'-[Declared] ]
    ;   []
    ).

%!  step_hint(+Program)// is det.
%
%   The same where Program is to make a step; it may be a formula, too.
step_hint(E) -->
    (   { current_theory(Theory),
          \+ in_golog(E, _),
          \+ near_miss(Theory, E, _),
          is_formula(E, Theory) }
    ->  { anonymous(E, Shown) },
        [ '; ?(~p) tests it, or calls the predicate'-[Shown] ]
    ;   hint(E)
    ).

in_golog(true, 'nothing to do is []').
in_golog((_, _), 'a sequence is a list, [E, F]').
in_golog((_ -> _ ; _), 'that is if(P, E, F)') :- !.
in_golog((_ ; _), 'a choice is ndet(E, F)').
in_golog((_ -> _), 'that is if(P, E)').

alternatives([PI]) --> [ '~q'-[PI] ].
alternatives([PI, PI2|PIs]) --> [ '~q or '-[PI] ], alternatives([PI2|PIs]).
