:- module(indigolog_problem_texts,
          [ problem//1,               % +What
            hint//1                   % +Term
          ]).
/** <module> What is said of a mistake in a theory or a program */

:- use_module(library(apply), [maplist/2]).
:- use_module(program_checks, [near_miss/3]).
:- use_module('../language/theory', [current_theory/1]).

%!  problem(+What)// is det.
%
%   What is that of a problem(Kind, File, Line, What) of checks.pl.

problem(unknown_action(Axiom, A)) -->
    { functor(A, Name, Arity) },
    [ '~w axiom for ~q, which is not a declared action'-[Axiom, Name/Arity] ],
    hint(A).
problem(axiom_of_procedure(Axiom, A)) -->
    { functor(A, Name, Arity) },
    [ '~w axiom for ~q, which is a procedure, not an action: it never applies'-[Axiom, Name/Arity] ].
problem(unknown_fluent(Axiom, F)) -->
    { functor(F, Name, Arity) },
    [ '~w axiom for ~q, which is not a declared fluent'-[Axiom, Name/Arity] ],
    hint(F).
problem(unknown_call(In, Call)) -->
    { functor(Call, Name, Arity) },
    inside(In),
    [ '~q is neither an action nor a procedure of the theory'-[Name/Arity] ],
    hint(Call).
problem(no_instance(In, A)) -->
    inside(In),
    [ 'action ~q is not one of those that are declared'-[A] ].
problem(no_clause(In, A)) -->
    inside(In),
    { functor(A, Name, Arity) },
    [ 'no clause of the procedure ~q matches ~q'-[Name/Arity, A] ].
problem(no_program(In, E)) -->
    inside(In),
    [ '~q stands where a program must'-[E] ].
problem(no_formula(In, P)) -->
    inside(In),
    [ '~q stands where a formula must'-[P] ].
problem(unknown_formula(In, P)) -->
    { functor(P, Name, Arity) },
    inside(In),
    [ '~q is neither a fluent nor an abbreviation nor a predicate'-[Name/Arity] ],
    hint(P).
problem(fluent_arity(In, F, Declared)) -->
    { functor(F, Name, Arity) },
    inside(In),
    [ '~q has the name of the fluent ~q'-[Name/Arity, Declared] ].
problem(no_number(In, T)) -->
    inside(In),
    [ '~q is compared as a number and is no fluent'-[T] ].
problem(constant_equality(In, P)) -->
    inside(In),
    [ '~q compares constants: neither side is a fluent'-[P] ].
problem(never_equal(In, F, V)) -->
    inside(In),
    [ 'relational fluent ~q is compared with ~q, neither true nor false'-[F, V] ].
problem(undeclared_instance(In, F)) -->
    inside(In),
    [ 'fluent ~q is not one of those that are declared'-[F] ].
problem(impossible_value(F, V)) -->
    [ '~q is not among the initial values of ~q'-[V, F] ].
problem(two_values(F, V, First)) -->
    [ 'fluent ~q is initially ~q: the value ~q given here does not count'-[F, First, V] ].
problem(exogenous_step(In, A)) -->
    inside(In),
    [ '~q is an exogenous action: as a step of a program it is never possible'-[A] ].
problem(no_commit(In)) -->
    inside(In),
    [ 'commit is not of this language: search does not prune what it may still need'-[] ].
problem(idle_loop(In, E)) -->
    inside(In),
    [ 'the loop ~q makes no action: once begun, only an exogenous action can end it'-[E] ].
problem(no_domain(In, D)) -->
    inside(In),
    [ 'the domain ~q is neither a list nor a predicate of one argument'-[D] ].
problem(unused(In, Construct, V)) -->
    inside(In),
    [ '~w binds ~q, which is not used'-[Construct, V] ].
problem(no_poss(A)) -->
    { functor(A, Name, Arity) },
    [ 'action ~q has no precondition axiom and will never be possible'-[Name/Arity] ].
problem(no_initial(F)) -->
    { functor(F, Name, Arity) },
    [ 'fluent ~q has no initial value'-[Name/Arity] ].
problem(no_initial_value(F)) -->
    [ 'fluent ~q has no initial value'-[F] ].
problem(kept_variable(In, Part)) -->
    inside(In),
    { copy_term(Part, Shown),
      term_variables(Shown, Variables),
      maplist(=('$VAR'('_')), Variables) },
    [ 'a variable in ~W keeps in every round of the loop the value of the first: bind it with pi or some'-
          [Shown, [quoted(true), numbervars(true)]] ].
problem(two_kinds(F)) -->
    { functor(F, Name, Arity) },
    [ 'fluent ~q is declared relational and functional'-[Name/Arity] ].
problem(two_uses(P)) -->
    { functor(P, Name, Arity) },
    [ 'procedure ~q has the name of an action or a fluent, and hides it'-[Name/Arity] ].
problem(reserved(A)) -->
    { functor(A, Name, Arity) },
    [ '~q is an entry of the interpreter\'s own in histories: the action needs another name'-[Name/Arity] ].
problem(hidden(A)) -->
    { functor(A, Name, Arity) },
    [ '~q has the name of a construct of the language, which hides it'-[Name/Arity] ].
problem(not_relational(F)) -->
    { functor(F, Name, Arity) },
    [ 'causes_true and causes_false are for relational fluents, ~q is functional'-[Name/Arity] ].
problem(not_boolean(F, V)) -->
    { functor(F, Name, Arity) },
    [ 'relational fluent ~q is given the value ~q, neither true nor false'-[Name/Arity, V] ].
problem(axiom_arity(Given, Expected)) -->
    [ '~q has the wrong number of arguments: '-[Given] ],
    alternatives(Expected).
problem(recursion(Name, Path)) -->
    { functor(Name, F, N),
      length(Path, Length),
      Steps is Length-1 },
    [ 'procedure ~q can come back to itself, in ~D call(s), before any action or test'-[F/N, Steps] ].

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
%   Another number of arguments may have been meant.
hint(Term) -->
    (   { current_theory(Theory),
          near_miss(Theory, Term, Declared) }
    ->  [ '; there is ~q'-[Declared] ]
    ;   []
    ).

alternatives([PI]) --> [ 'it is ~q'-[PI] ].
alternatives([PI, PI2|PIs]) --> [ '~q or '-[PI] ], alternatives([PI2|PIs]).
