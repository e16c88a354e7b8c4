:- module(indigolog_compiled,
          [ compile_axioms/1          % +Theory
          ]).
/** <module> Axioms compiled to clauses

Whether an action is possible, and what it does, is asked more often than anything else.
So the precondition and effect axioms are also compiled, when the theory is loaded, to
clauses of '$possible'/2 and '$sets_value'/3, '$sets_true'/3, '$sets_false'/3, for actions
that are _plain_: ground, primitive, and with no fluent in them, so that their arguments
stand for themselves (action.pl).  The abbreviations that an axiom uses are compiled with
it, for plain arguments.  A formula is compiled by unfolding its definition, meaning/3 of
formula.pl.  Only for theories in which every fluent has one value.
*/

:- use_module(library(apply), [maplist/3, maplist/5]).
:- use_module(library(lists), [append/3, member/2]).
:- use_module(library(occurs), [sub_term/2]).
:- use_module(formula, [meaning/3]).
:- use_module(progression, []).
:- use_module(substitution).
:- use_module(theory).

%!  compile_axioms(+Theory) is det.

compile_axioms(Theory) :-
    theory_module(Theory, Module),
    dynamic([ Module:'$possible'/2, Module:'$abbreviation'/2,
              Module:'$sets_value'/3, Module:'$sets_true'/3, Module:'$sets_false'/3 ]),
    forall(clause(Module:poss(A, P), Body),
           ( term_variables(A, Plain),
             goal(P, in(Theory, Plain, S), Goal),
             define(Module, '$possible'(A, S), Body, Goal) )),
    forall(clause(Module:causes_val(A, F, V, P), Body),
           compile_effect('$sets_value'(A, S, Effect), F-V, P, Body, S, Effect, Theory)),
    forall(clause(Module:causes_true(A, F, P), Body),
           compile_effect('$sets_true'(A, S, Effect), F-true, P, Body, S, Effect, Theory)),
    forall(clause(Module:causes_false(A, F, P), Body),
           compile_effect('$sets_false'(A, S, Effect), F-false, P, Body, S, Effect, Theory)).

compile_effect(Head, F-V, P, Body, S, Effect, Theory) :-
    theory_module(Theory, Module),
    arg(1, Head, A),
    term_variables(A, Plain),
    In = in(Theory, Plain, S),
    (   will_be_ground(F, In)
    ->  Effect = F-V,
        goal(P, In, Goal),
        ( Goal == true -> First = true ; First = (Goal -> true) ),
        define(Module, Head, Body, First)
    ;   define(Module, Head, Body, indigolog_progression:effect_of(F, V, P, S, Effect))
    ).

define(Module, Head, Condition, Goal) :-
    both(Condition, Goal, Body),
    assertz(Module:(Head :- Body)).


                /* Formulas */

% goal(+Formula, +In, -Goal): Goal is true_in(Formula, S), unfolded.  In is
% in(Theory, Plain, S), Plain being the variables that will be bound to plain terms.

goal(P, In, Goal), var(P) =>
    left(P, In, Goal).
goal(P, In, Goal), In = in(_, _, S), meaning(P, S, Meaning) =>
    unfolded(Meaning, In, Goal).
goal(P, In, Goal), abbreviation(P, In, Goal0) =>
    Goal = Goal0.
goal(P, In, Goal), In = in(Theory, _, _), fluent_template(Theory, P, _) =>
    theory_module(Theory, Module),
    value(P, In, Value, A),
    both(Value, indigolog_formula:true_value(A, P, Module), Goal).
goal(P, In, Goal) =>
    left(P, In, Goal).

left(P, in(_, _, S), indigolog_formula:true_in(P, S)).

% unfolded(+Meaning, +In, -Goal): what can be told before the situation is there is done.
unfolded((A, B), In, Goal) =>
    unfolded(A, In, A1),
    unfolded(B, In, B1),
    both(A1, B1, Goal).
unfolded((ground(T) -> A ; _), In, Goal), will_be_ground(T, In) =>
    unfolded(A, In, Goal).
unfolded((A -> B ; C), In, Goal) =>
    Goal = ( A1 -> B1 ; C1 ),
    unfolded(A, In, A1),
    unfolded(B, In, B1),
    unfolded(C, In, C1).
unfolded((A -> B), In, Goal) =>           % which may come to stand in a disjunction
    Goal = ( A1 -> B1 ; fail ),
    unfolded(A, In, A1),
    unfolded(B, In, B1).
unfolded((A ; B), In, Goal) =>
    Goal = ( A1 ; B1 ),
    unfolded(A, In, A1),
    unfolded(B, In, B1).
unfolded(\+ A, In, Goal) =>
    Goal = ( \+ A1 ),
    unfolded(A, In, A1).
unfolded(true_in(P, _), In, Goal) =>
    goal(P, In, Goal).
unfolded(instance(V, P, _, P1), _, Goal), one_variable(V) =>
    Goal = true,
    substitute(V, _, P, P1).
unfolded(value_in(X, _, V), In, Goal) =>
    value(X, In, Value, A),
    (   (   var(V), \+ plain(V, In)
        ;   gives(Value, A)               % the goal is given the other value
        )
    ->  V = A,
        Goal = Value
    ;   both(Value, A = V, Goal)
    ).
unfolded(Goal0, _, Goal) =>
    (   predicate_property(system:Goal0, defined),
        \+ predicate_property(system:Goal0, meta_predicate(_))
    ->  Goal = Goal0
    ;   Goal = indigolog_formula:Goal0
    ).

both(A, B, Goal) :-
    (   A == true -> Goal = B
    ;   B == true -> Goal = A
    ;   Goal = (A, B)
    ).

one_variable(V) :-
    ( var(V) -> true ; atom(V), V \== [] ).

gives(indigolog_formula:value_of(_, _, _, V), A) :-
    V == A.
gives(indigolog_formula:value_in(_, _, V), A) :-
    V == A.
gives((_, Goal), A) :-
    gives(Goal, A).

% value(+Term, +In, -Goal, -Value): Goal is value_in(Term, S, Value), or true where
% Term stands for itself.

value(X, In, Goal, V), var(X) =>
    In = in(_, _, S),
    (   plain(X, In)
    ->  Goal = true, V = X
    ;   Goal = indigolog_formula:value_in(X, S, V)
    ).
value(X, In, Goal, V), atomic(X) =>
    In = in(Theory, _, S),
    (   atom(X),
        fluent_template(Theory, X, Kind)
    ->  Goal = indigolog_formula:value_of(X, Kind, S, V)
    ;   Goal = true, V = X
    ).
value(X, In, Goal, V) =>
    In = in(Theory, _, S),
    compound_name_arguments(X, Name, Xs),
    values(Xs, In, Last, Goal, Vs),
    compound_name_arguments(Y, Name, Vs),
    (   fluent_template(Theory, Y, Kind)
    ->  Last = indigolog_formula:value_of(Y, Kind, S, V)
    ;   Last = true, V = Y
    ).

values([], _, Last, Last, []).
values([X|Xs], In, Last, Goal, [V|Vs]) :-
    value(X, In, Goal0, V),
    (   Goal0 == true
    ->  Goal = Goal1
    ;   Goal = (Goal0, Goal1)
    ),
    values(Xs, In, Last, Goal1, Vs).

plain(V, in(_, Plain, _)) :-
    member(P, Plain),
    P == V,
    !.

will_be_ground(Term, In) :-
    term_variables(Term, Variables),
    \+ ( member(V, Variables), \+ plain(V, In) ).


                /* Abbreviations */

% abbreviation(+Formula, +In, -Goal): Formula is an abbreviation, and its arguments are
% plain.  '$abbreviation'(Formula, Body) gives what to call with the situation.

abbreviation(P, In, Goal) :-
    In = in(Theory, _, S),
    \+ fluent_template(Theory, P, _),
    will_be_ground(P, In),
    \+ ( sub_term(T, P), callable(T), fluent_template(Theory, T, _) ),
    theory_module(Theory, Module),
    functor(P, Name, Arity),
    functor(Head, Name, Arity),
    compiled_abbreviation(Head, Module, Theory),
    (   findall(Head-Body-If, clause(Module:'$abbreviation'(Head, Body), If), [Head1-Only-true]),
        subsumes_term(Head1, P)
    ->  Head1 = P,                        % the one clause, whatever the arguments
        Only =.. Parts0,
        append(Parts0, [S], Parts),
        Goal =.. Parts
    ;   Goal = ( '$abbreviation'(P, Body) -> call(Body, S) ; Left ),
        left(P, In, Left)
    ).

compiled_abbreviation(Head, Module, Theory) :-
    (   clause(Module:'$abbreviation'(Done, _), _),
        \+ Done \= Head
    ->  true
    ;   findall(abbreviates(Head, Body, Condition), clause(Module:proc(Head, Body), Condition), Clauses),
        Clauses \== [],
        maplist(declare(Module), Clauses, Compiled),
        maplist(compile_abbreviation(Theory), Clauses, Compiled)
    ).

% All clauses are declared before the first is compiled: they may use one another.
declare(Module, abbreviates(Head, Body, Condition), Compiled) :-
    term_variables(Head-Body, Variables),
    flag(indigolog_compiled, N, N+1),
    atom_concat('$formula ', N, Name),
    Compiled =.. [Name|Variables],
    assertz(Module:('$abbreviation'(Head, Compiled) :- Condition)).

compile_abbreviation(Theory, abbreviates(Head, Body, _), Compiled) :-
    theory_module(Theory, Module),
    term_variables(Head, Plain),
    goal(Body, in(Theory, Plain, S), Goal),
    Compiled =.. Parts0,
    append(Parts0, [S], Parts),
    Defined =.. Parts,
    define(Module, Defined, true, Goal).
