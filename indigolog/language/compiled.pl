:- module(indigolog_compiled,
          [ compile_axioms/1,         % +Theory
            possible_plain/2,         % +Action, +Situation
            plain_effect/3,           % +Action, +Situation, -Effect
            known_plain/2,            % +Term, +Theory
            learn_plain/2             % +Action, +Theory
          ]).
:- use_module(library(apply), [maplist/3, maplist/5]).
:- use_module(library(lists), [append/3, member/2, memberchk/2]).
:- use_module(library(occurs), [sub_term/2]).
:- use_module(formula, []).
:- use_module(situation, []).
:- use_module(substitution).
:- use_module(theory).

/** <module> Axioms compiled to clauses

Whether an action is possible, and what it does, is asked more often than anything else.
So the precondition and effect axioms are also compiled, when the theory is loaded, to
clauses of '$possible'/2 and '$sets_value'/3, '$sets_true'/3, '$sets_false'/3, for actions
that are _plain_: ground, primitive, and with no fluent in them, so that their arguments
stand for themselves.  The abbreviations that an axiom uses are compiled with it, for
plain arguments.  A compiled goal does what indigolog_formula:true_in/2 does with the
formula, and what is rare is left to true_in/2.  Only for theories in which every fluent
has one value.
*/

% Most actions that are remembered as plain.
most_plain(10_000).

%!  known_plain(+Term, +Theory) is semidet.
%
%   Term was learnt to be a plain action.

known_plain(Term, Theory) :-
    plain_actions(Theory, Trie),
    ground(Term),
    trie_lookup(Trie, Term, plain).

%!  learn_plain(+Action, +Theory) is det.
%
%   Remember the ground primitive Action, if it is plain.

learn_plain(Action, Theory) :-
    (   plain_actions(Theory, Trie),
        trie_property(Trie, value_count(N)),
        most_plain(Most),
        N < Most,
        \+ ( sub_term(T, Action), callable(T), fluent_template(Theory, T, _) )
    ->  trie_insert(Trie, Action, plain)
    ;   true
    ).

%!  possible_plain(+Action, +Situation) is nondet.
%
%   The plain Action is possible.

possible_plain(A, S) :-
    S = s(th(Module, _, _, _), _, _, _, _),
    Module:'$possible'(A, S).

%!  plain_effect(+Action, +Situation, -Effect) is nondet.
%
%   Effect of the plain Action: Fluent-Value, or open(Fluent, Value, Condition).

plain_effect(A, S, Effect) :-
    S = s(th(Module, _, _, _), _, _, _, _),
    (   Module:'$sets_value'(A, S, Effect)
    ;   Module:'$sets_true'(A, S, Effect)
    ;   Module:'$sets_false'(A, S, Effect)
    ).

%!  compile_axioms(+Theory) is det.

compile_axioms(Theory) :-
    theory_module(Theory, Module),
    dynamic([ Module:'$possible'/2, Module:'$abbreviation'/2,
              Module:'$sets_value'/3, Module:'$sets_true'/3, Module:'$sets_false'/3 ]),
    forall(clause(Module:poss(A, P), Body),
           ( term_variables(A, Plain),
             goal(P, in(Theory, Plain, S), Goal),
             define(Module, '$possible'(A, S), (Body, Goal)) )),
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
        define(Module, Head, (Body, once(Goal)))
    ;   define(Module, Head, (Body, indigolog_situation:effect_of(F, V, P, S, Effect)))
    ).

define(Module, Head, Body) :-
    simpler(Body, Body1),
    assertz(Module:(Head :- Body1)).


                /* Formulas */

% goal(+Formula, +In, -Goal): Goal is true_in(Formula, S).  In is in(Theory, Plain, S),
% Plain being the variables that will be bound to plain terms.

goal(P, In, Goal), var(P) =>
    left(P, In, Goal).
goal(true, _, Goal) =>
    Goal = true.
goal(false, _, Goal) =>
    Goal = fail.
goal(and(P, Q), In, Goal) =>
    Goal = (P1, Q1),
    goal(P, In, P1),
    goal(Q, In, Q1).
goal(and([P|Ps]), In, Goal), is_list(Ps) =>
    (   Ps == []
    ->  goal(P, In, Goal)
    ;   goal(and(P, and(Ps)), In, Goal)
    ).
goal(or(P, Q), In, Goal) =>
    Goal = ( P1 ; Q1 ),
    goal(P, In, P1),
    goal(Q, In, Q1).
goal(or([P|Ps]), In, Goal), is_list(Ps) =>
    (   Ps == []
    ->  goal(P, In, Goal)
    ;   goal(or(P, or(Ps)), In, Goal)
    ).
goal(neg(P), In, Goal) =>
    Goal = ( \+ P1 ),
    goal(P, In, P1).
goal(some(V, P), In, Goal), one_variable(V) =>
    substitute(V, _, P, P1),
    goal(P1, In, Goal).
goal(all(V, P), In, Goal), one_variable(V) =>
    goal(neg(some(V, neg(P))), In, Goal).
goal(X = Y, In, Goal) =>
    value(X, In, XGoal, A),
    value(Y, In, YGoal, B),
    equal(XGoal, YGoal, A, B, Equal),
    (   will_be_ground(Y, In)
    ->  Goal = (YGoal, XGoal, Equal)
    ;   Goal = ( ground(Y) -> YGoal, XGoal, Equal ; XGoal, YGoal, Equal )
    ).
goal(P, In, Goal), comparison(P, X, Y, A, B, Compare) =>
    Goal = (XGoal, YGoal, Compare),
    value(X, In, XGoal, A),
    value(Y, In, YGoal, B).
goal(X is Y, In, Goal) =>
    Goal = (YGoal, XGoal, A is B),
    value(Y, In, YGoal, B),
    value(X, In, XGoal, A).
goal(P, In, Goal), abbreviation(P, In, Goal0) =>
    Goal = Goal0.
goal(P, In, Goal), In = in(Theory, _, _), fluent_template(Theory, P, _) =>
    theory_module(Theory, Module),
    value(P, In, Value, A),
    Goal = (Value, indigolog_formula:call_goal(A, P, Module)).
goal(P, In, Goal) =>
    left(P, In, Goal).

left(P, in(_, _, S), indigolog_formula:true_in(P, S)).

% Without what is always true.
simpler(Goal, Simple), nonvar(Goal), Goal = (A, B) =>
    simpler(A, A1),
    simpler(B, B1),
    (   A1 == true -> Simple = B1
    ;   B1 == true -> Simple = A1
    ;   Simple = (A1, B1)
    ).
simpler(Goal, Simple), nonvar(Goal), Goal = (A ; B) =>
    Simple = (A1 ; B1),
    simpler(A, A1),
    simpler(B, B1).
simpler(Goal, Simple), nonvar(Goal), Goal = (A -> B) =>
    Simple = (A -> B1),
    simpler(B, B1).
simpler(Goal, Simple), nonvar(Goal), Goal = (\+ A) =>
    Simple = (\+ A1),
    simpler(A, A1).
simpler(Goal, Simple), nonvar(Goal), Goal = once(A) =>
    simpler(A, A1),
    (   A1 == true
    ->  Simple = true
    ;   Simple = (A1 -> true)
    ).
simpler(Goal, Simple) =>
    Simple = Goal.

one_variable(V) :-
    ( var(V) -> true ; atom(V), V \== [] ).

% Where one of the goals gives the value, it is given the other value.
equal(XGoal, YGoal, A, B, Equal) :-
    (   gives(XGoal, A)
    ->  A = B, Equal = true
    ;   gives(YGoal, B)
    ->  A = B, Equal = true
    ;   Equal = (A = B)
    ).

gives(indigolog_formula:value_of(_, _, _, V), A) :-
    V == A.
gives(indigolog_formula:value_in(_, _, V), A) :-
    V == A.
gives((_, Goal), A) :-
    gives(Goal, A).

comparison(X < Y, X, Y, A, B, A < B).
comparison(X > Y, X, Y, A, B, A > B).
comparison(X =< Y, X, Y, A, B, A =< B).
comparison(X >= Y, X, Y, A, B, A >= B).
comparison(X =:= Y, X, Y, A, B, A =:= B).
comparison(X =\= Y, X, Y, A, B, A =\= B).

% value(+Term, +In, -Goal, -Value): Goal is value_in(Term, S, Value), or true where
% Term stands for itself.

value(X, In, Goal, V), var(X) =>
    In = in(_, Plain, S),
    (   member(Y, Plain),
        X == Y
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

will_be_ground(Term, in(_, Plain, _)) :-
    term_variables(Term, Variables),
    \+ ( member(V, Variables),
         \+ ( member(P, Plain), P == V ) ).


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
    define(Module, Defined, Goal).
