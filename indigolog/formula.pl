:- module(indigolog_formula,
          [ holds/2,                  % +Formula, +Situation
            test/2,                   % +Formula, +Situation
            evaluate/3                % +Term, +Situation, -Value
          ]).
:- use_module(library(lists), [member/2]).
:- use_module(library(aggregate), [aggregate_all/3]).
:- use_module(theory).
:- use_module(situation).
:- use_module(substitution).
:- use_module(knowledge).

/** <module> Formulas over fluents

A formula is true or false in a situation.  Anything that is not a connective, a
quantifier, a procedure abbreviation or a fluent is a Prolog goal of the theory,
called with the fluents in it replaced by their values.
*/

%!  test(+Formula, +Situation) is nondet.
%
%   As holds/2, and without choice points for a ground formula.

test(Formula, Situation) :-
    (   ground(Formula)
    ->  holds(Formula, Situation)
    ->  true
    ;   holds(Formula, Situation)
    ).

%!  holds(+Formula, +Situation) is nondet.
%
%   Formula is true in Situation, perhaps after binding its free variables.

holds(P, _), var(P) =>
    throw(error(golog(not_a_formula(P)), _)).
holds(true, _) =>
    true.
holds(false, _) =>
    fail.
holds(and(P, Q), S) =>
    holds(P, S),
    holds(Q, S).
holds((P, Q), S) =>
    holds(P, S),
    holds(Q, S).
holds(and(Ps), S) =>
    all_hold(Ps, S).
holds(or(P, Q), S) =>
    (   holds(P, S)
    ;   holds(Q, S)
    ).
holds((P -> Q ; R), S) =>
    (   holds(P, S)
    ->  holds(Q, S)
    ;   holds(R, S)
    ).
holds((P -> Q), S) =>
    (   holds(P, S)
    ->  holds(Q, S)
    ).
holds((P ; Q), S) =>
    (   holds(P, S)
    ;   holds(Q, S)
    ).
holds(or(Ps), S) =>
    member(P, Ps),
    holds(P, S).
holds(neg(P), S) =>
    \+ holds(P, S).
holds(\+ P, S) =>
    \+ holds(P, S).
holds(impl(P, Q), S) =>
    (   holds(P, S)
    ->  \+ \+ holds(Q, S)
    ;   true
    ).
holds(equiv(P, Q), S) =>
    (   holds(P, S)
    ->  \+ \+ holds(Q, S)
    ;   \+ holds(Q, S)
    ).
holds(some(V, P), S) =>
    some(V, P, S).
holds(all(V, P), S) =>
    \+ some(V, neg(P), S).
holds(X = Y, S) =>
    (   ground(Y)                         % once, whatever X enumerates
    ->  evaluate(Y, S, V),
        evaluate(X, S, V)
    ;   evaluate(X, S, V),
        evaluate(Y, S, V)
    ).
holds(X < Y, S) =>
    evaluate(X, S, A), evaluate(Y, S, B), A < B.
holds(X > Y, S) =>
    evaluate(X, S, A), evaluate(Y, S, B), A > B.
holds(X =< Y, S) =>
    evaluate(X, S, A), evaluate(Y, S, B), A =< B.
holds(X >= Y, S) =>
    evaluate(X, S, A), evaluate(Y, S, B), A >= B.
holds(X =:= Y, S) =>
    evaluate(X, S, A), evaluate(Y, S, B), A =:= B.
holds(X =\= Y, S) =>
    evaluate(X, S, A), evaluate(Y, S, B), A =\= B.
holds(X is Y, S) =>
    evaluate(Y, S, B),
    evaluate(X, S, A),
    A is B.
holds(know(P), S) =>
    known(P, S).
holds(kwhether(P), S) =>
    known_whether(P, S).
holds(done(A), S) =>
    situation_history(S, History),
    member(A, History).
holds(forall(P, Q), S) =>
    \+ ( holds(P, S), \+ holds(Q, S) ).
holds(findall(T, P, L), S) =>
    findall(T, holds(P, S), L).
holds(aggregate_all(T, P, R), S) =>
    aggregate_all(T, holds(P, S), R).
holds(once(P), S) =>
    once(holds(P, S)).
holds(P, S) =>
    situation_theory(S, Theory),
    theory_module(Theory, Module),
    (   Module:proc(P, Body)
    ->  holds(Body, S)
    ;   evaluate(P, S, Goal),
        call_goal(Goal, P, Module)
    ).

% A fluent that stands alone is true when its value is.
call_goal(Goal, P, Module) :-
    (   callable(Goal)
    ->  Module:Goal
    ;   throw(error(golog(not_a_formula(P, Goal)), _))
    ).

all_hold([], _).
all_hold([P|Ps], S) :-
    holds(P, S),
    all_hold(Ps, S).

% some(+Variables, +Formula, +Situation)

some(V, P, S) :-
    (   is_list(V)
    ->  some_of(V, P, S)
    ;   nonvar(V), V = (V0, D)
    ->  evaluate(D, S, D1),
        situation_theory(S, Theory),
        domain_list(Theory, D1, Values),
        member(O, Values),
        substitute(V0, O, P, P1),
        holds(P1, S)
    ;   substitute(V, _, P, P1),
        holds(P1, S)
    ).

some_of([], P, S) :-
    holds(P, S).
some_of([V|Vs], P, S) :-
    some(V, some(Vs, P), S).

%!  evaluate(+Term, +Situation, -Value) is nondet.
%
%   Value is Term with each fluent in it, at any depth, replaced by its value.
%   Fluents with unbound arguments are enumerated.  Fails if the value of a fluent
%   is not known yet.
%
%   @error golog(no_value(Fluent, History)) for a functional fluent that has no value and
%          that no sensing axiom speaks of

evaluate(T, _, V), var(T) =>
    V = T.
evaluate(T, S, V), atom(T) =>
    (   S = s(th(Module, _, _), _, _, _, _),
        Module:'$fluent'(T, Kind)
    ->  value_of(T, Kind, S, V)
    ;   V = T
    ).
evaluate(T, _, V), atomic(T) =>
    V = T.
evaluate([H|L], S, V) =>
    V = [H1|L1],
    evaluate(H, S, H1),
    evaluate(L, S, L1).
evaluate(T, S, V) =>
    compound_name_arguments(T, Name, Args0),
    evaluate_arguments(Args0, S, Args),
    compound_name_arguments(T1, Name, Args),
    (   S = s(th(Module, _, _), _, _, _, _),
        Module:'$fluent'(T1, Kind)
    ->  value_of(T1, Kind, S, V)
    ;   V = T1
    ).

evaluate_arguments([], _, []).
evaluate_arguments([A|As], S, [B|Bs]) :-
    evaluate(A, S, B),
    evaluate_arguments(As, S, Bs).

value_of(F, Kind, S, V) :-
    (   ground(F)
    ->  fluent_status(F, S, Status),
        ground_value(Status, F, Kind, S, V)
    ;   fluent_value(F, S, V)
    ).

ground_value(v(V0), _, _, _, V) =>
    V = V0.
ground_value(undeclared, F, _, _, V) =>
    V = F.
ground_value(unknown, _, rel, _, _) =>
    fail.
ground_value(unknown, F, fun, S, _) =>
    situation_theory(S, Theory),
    (   sensed_template(Theory, F)
    ->  fail
    ;   situation_history(S, History),
        throw(error(golog(no_value(F, History)), _))
    ).
