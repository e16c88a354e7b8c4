:- module(indigolog_formula,
          [ holds_in/2,               % +Formula, +Situation
            test/2,                   % +Formula, +Situation
            evaluate/3,               % +Term, +Situation, -Value
            arguments_in/3,           % +Term, +World, -Term1
            true_in/2,                % +Formula, +World
            value_in/3                % +Term, +World, -Value
          ]).
:- use_module(library(assoc), [get_assoc/3]).
:- use_module(library(lists), [member/2]).
:- use_module(library(aggregate), [aggregate_all/3]).
:- use_module(initial).
:- use_module(theory).
:- use_module(situation).
:- use_module(world).
:- use_module(values, [stored/3]).
:- use_module(substitution).
:- use_module(knowledge).

/** <module> Formulas over fluents

A formula is true or false in a situation.  Anything that is not a connective, a
quantifier, a procedure abbreviation or a fluent is a Prolog goal of the theory,
called with the fluents in it replaced by their values.

Where fluents may have several possible values (knowledge.pl), a formula holds
in a situation if it is true in every world: whatever the values are.
*/

%!  test(+Formula, +Situation) is nondet.
%
%   As holds_in/2, and without choice points for a ground formula.

test(Formula, Situation) :-
    (   ground(Formula)
    ->  holds_in(Formula, Situation)
    ->  true
    ;   holds_in(Formula, Situation)
    ).

%!  holds_in(+Formula, +Situation) is nondet.
%
%   Formula is true in Situation, perhaps after binding its free variables.

holds_in(P, S) :-
    (   values_certain(S)
    ->  true_in(P, S)
    ;   in_all_worlds(true_in(P), S)
    ).

%!  evaluate(+Term, +Situation, -Value) is nondet.
%
%   Value is Term with each fluent in it, at any depth, replaced by its value.
%   Fluents with unbound arguments are enumerated.  Fails if the value of a fluent
%   is not known yet.
%
%   @error golog(no_value(Fluent, History)) for a functional fluent that has no value and
%          that no sensing axiom speaks of

evaluate(T, S, V) :-
    (   values_certain(S)
    ->  value_in(T, S, V)
    ;   in_all_worlds(known_value(T, V), S)
    ).

known_value(T, V, W) :-
    value_in(T, W, V).

%!  true_in(+Formula, +World) is nondet.
%
%   Formula is true in World.
%
%   @throws several_values(Fluent, Values) if it depends on a fluent that has
%           several possible values in World

true_in(P, _), var(P) =>
    throw(error(golog(not_a_formula(P)), _)).
true_in(true, _) =>
    true.
true_in(false, _) =>
    fail.
true_in(and(P, Q), S) =>
    true_in(P, S),
    true_in(Q, S).
true_in((P, Q), S) =>
    true_in(P, S),
    true_in(Q, S).
true_in(and(Ps), S) =>
    all_hold(Ps, S).
true_in(or(P, Q), S) =>
    (   true_in(P, S)
    ;   true_in(Q, S)
    ).
true_in((P -> Q ; R), S) =>
    (   true_in(P, S)
    ->  true_in(Q, S)
    ;   true_in(R, S)
    ).
true_in((P -> Q), S) =>
    (   true_in(P, S)
    ->  true_in(Q, S)
    ).
true_in((P ; Q), S) =>
    (   true_in(P, S)
    ;   true_in(Q, S)
    ).
true_in(or(Ps), S) =>
    member(P, Ps),
    true_in(P, S).
true_in(neg(P), S) =>
    \+ true_in(P, S).
true_in(\+ P, S) =>
    \+ true_in(P, S).
true_in(impl(P, Q), S) =>
    (   true_in(P, S)
    ->  \+ \+ true_in(Q, S)
    ;   true
    ).
true_in(equiv(P, Q), S) =>
    (   true_in(P, S)
    ->  \+ \+ true_in(Q, S)
    ;   \+ true_in(Q, S)
    ).
true_in(some(V, P), S) =>
    some(V, P, S).
true_in(all(V, P), S) =>
    \+ some(V, neg(P), S).
true_in(some(V, D, P), S) =>
    some((V, D), P, S).
true_in(all(V, D, P), S) =>
    \+ some((V, D), neg(P), S).
true_in(X = Y, S) =>
    (   ground(Y)                         % once, whatever X enumerates
    ->  value_in(Y, S, V),
        value_in(X, S, V)
    ;   value_in(X, S, V),
        value_in(Y, S, V)
    ).
true_in(X < Y, S) =>
    value_in(X, S, A), value_in(Y, S, B), A < B.
true_in(X > Y, S) =>
    value_in(X, S, A), value_in(Y, S, B), A > B.
true_in(X =< Y, S) =>
    value_in(X, S, A), value_in(Y, S, B), A =< B.
true_in(X >= Y, S) =>
    value_in(X, S, A), value_in(Y, S, B), A >= B.
true_in(X =:= Y, S) =>
    value_in(X, S, A), value_in(Y, S, B), A =:= B.
true_in(X =\= Y, S) =>
    value_in(X, S, A), value_in(Y, S, B), A =\= B.
true_in(X is Y, S) =>
    value_in(Y, S, B),
    value_in(X, S, A),
    A is B.
true_in(know(P), W) =>
    actual_situation(W, S),
    known(P, S).
true_in(kwhether(P), W) =>
    actual_situation(W, S),
    known_whether(P, S).
true_in(done(A), S) =>
    situation_history(S, History),
    member(A, History).
true_in(forall(P, Q), S) =>
    \+ ( true_in(P, S), \+ true_in(Q, S) ).
true_in(findall(T, P, L), S) =>
    findall(T, true_in(P, S), L).
true_in(aggregate_all(T, P, R), S) =>
    aggregate_all(T, true_in(P, S), R).
true_in(once(P), S) =>
    once(true_in(P, S)).
true_in(P, S) =>
    S = s(th(Module, _, _, _), _, _, _, _),
    (   Module:proc(P, Body)
    ->  true_in(Body, S)
    ;   value_in(P, S, Goal),
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
    true_in(P, S),
    all_hold(Ps, S).

% some(+Variables, +Formula, +Situation)

some(V, P, S) :-
    (   is_list(V)
    ->  some_of(V, P, S)
    ;   nonvar(V), V = (V0, D)
    ->  value_in(D, S, D1),
        situation_theory(S, Theory),
        domain_list(Theory, D1, Values),
        member(O, Values),
        substitute(V0, O, P, P1),
        true_in(P1, S)
    ;   substitute(V, _, P, P1),
        true_in(P1, S)
    ).

some_of([], P, S) :-
    true_in(P, S).
some_of([V|Vs], P, S) :-
    some(V, some(Vs, P), S).

%!  value_in(+Term, +World, -Value) is nondet.
%
%   As evaluate/3, in a world.

value_in(T, _, V), var(T) =>
    V = T.
value_in(T, S, V), atom(T) =>
    (   S = s(th(Module, _, _, _), _, _, _, _),
        Module:'$fluent'(T, Kind)
    ->  value_of(T, Kind, S, V)
    ;   V = T
    ).
value_in(T, _, V), atomic(T) =>
    V = T.
value_in([H|L], S, V) =>
    V = [H1|L1],
    value_in(H, S, H1),
    value_in(L, S, L1).
value_in(T, S, V) =>
    arguments_in(T, S, T1),
    (   S = s(th(Module, _, _, _), _, _, _, _),
        Module:'$fluent'(T1, Kind)
    ->  value_of(T1, Kind, S, V)
    ;   V = T1
    ).

%!  arguments_in(+Term, +World, -Term1) is nondet.
%
%   Term1 is the compound Term with its arguments replaced by their values.

arguments_in(T, S, T1) :-
    compound_name_arity(T, Name, Arity),
    (   Arity == 1                        % the common cases, without lists
    ->  arg(1, T, A),
        value_in(A, S, A1),
        ( A1 == A -> T1 = T ; compound_name_arguments(T1, Name, [A1]) )
    ;   Arity == 2
    ->  arg(1, T, A),
        arg(2, T, B),
        value_in(A, S, A1),
        value_in(B, S, B1),
        ( A1 == A, B1 == B -> T1 = T ; compound_name_arguments(T1, Name, [A1, B1]) )
    ;   compound_name_arguments(T, Name, Args0),
        values_in(Args0, S, Args),
        compound_name_arguments(T1, Name, Args)
    ).

values_in([], _, []).
values_in([A|As], S, [B|Bs]) :-
    value_in(A, S, B),
    values_in(As, S, Bs).

value_of(F, Kind, S, V) :-
    (   ground(F)
    ->  fluent_status(F, S, Status),
        ground_value(Status, F, Kind, S, V)
    ;   S = s(Theory, Map, _, _, []),
        ground_instances(Theory, F, Instance, Status)
    ->  call(Instance),                   % the common case, inlined
        (   ( Map = recent(_, _, _) -> stored(Map, F, Value) ; get_assoc(F, Map, Value) )
        ->  (   Value = '$any'(Values)
            ->  throw(several_values(F, Values))
            ;   V = Value
            )
        ;   Status = v(Value)
        ->  V = Value
        ;   instance_value(Status, F, V)
        )
    ;   fluent_instance(F, S),
        (   ground(F)
        ->  fluent_status(F, S, Status),
            instance_value(Status, F, V)
        ;   fluent_value(F, S, V)
        )
    ).

instance_value(v(V0), _, V) =>
    V = V0.
instance_value(any(Vs), F, _) =>
    throw(several_values(F, Vs)).
instance_value(_, _, _) =>
    fail.

ground_value(v(V0), _, _, _, V) =>
    V = V0.
ground_value(any(Vs), F, _, _, _) =>
    throw(several_values(F, Vs)).
ground_value(undeclared, F, _, _, V) =>
    V = F.
ground_value(unknown, F, Kind, S, _) =>
    situation_theory(S, Theory),
    (   only_knowledge(S)
    ->  throw(no_value(F))
    ;   ( Kind == rel ; sensed_template(Theory, F) )
    ->  fail
    ;   situation_history(S, History),
        throw(error(golog(no_value(F, History)), _))
    ).
