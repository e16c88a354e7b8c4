:- module(indigolog_formula,
          [ holds_in/2,               % +Formula, +Situation
            test/2,                   % +Formula, +Situation
            evaluate/3,               % +Term, +Situation, -Value
            meaning/3,                % +Formula, ?World, -Goal
            true_in/2,                % +Formula, +World
            value_in/3,               % +Term, +World, -Value
            value_of/4,               % +Fluent, +Kind, +World, -Value
            arguments_in/3,           % +Term, +World, -Term1
            instance/4,               % +Variables, +Term, +World, -Term1
            true_value/3,             % +Value, +Formula, +Module
            call_goal/3               % +Goal, +Formula, +Module
          ]).
/** <module> Formulas over fluents

A formula is true or false in a situation.  Anything that is not a connective, a
quantifier, a procedure abbreviation or a fluent is a Prolog goal of the theory,
called with the fluents in it replaced by their values.

Where fluents may have several possible values (knowledge.pl), a formula holds
in a situation if it is true in every world: whatever the values are.

means/3 is the definition.  true_in/2 is compiled from it, clause by clause, when this file
is loaded; compiled.pl unfolds it for the axioms of a theory.
*/

:- use_module(library(aggregate), [aggregate_all/3]).
:- use_module(library(lists), [member/2]).
:- use_module(initial).
:- use_module(knowledge).
:- use_module(situation).
:- use_module(substitution).
:- use_module(theory).
:- use_module(values, [stored/3]).

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


                /* What formulas mean */

%!  meaning(+Formula, ?World, -Goal) is semidet.
%
%   Formula, one that begins with a connective, is true in World where Goal is.

meaning(P, S, Goal) :-
    generalised(P, G),
    means(G, S, Goal),
    subsumes_term(G, P),
    !,
    G = P.

%!  true_in(+Formula, +World) is nondet.
%
%   Formula is true in World.
%
%   @throws several_values(Fluent, Values) if it depends on a fluent that has
%           several possible values in World

:- discontiguous means/3, true_in/2.

term_expansion(means(P, S, Goal), [ means(P, S, Goal), (true_in(P, S) => Goal) ]).

true_in(P, _), var(P) =>
    throw(error(golog(not_a_formula(P)), _)).

means(true, _, true).
means(false, _, fail).
means(and(P, Q), S, ( true_in(P, S), true_in(Q, S) )).
means((P, Q), S, ( true_in(P, S), true_in(Q, S) )).
means(and([]), _, true).
means(and([P|Ps]), S, ( true_in(P, S), true_in(and(Ps), S) )).
means(or(P, Q), S, ( true_in(P, S) ; true_in(Q, S) )).
means((P -> Q ; R), S, ( true_in(P, S) -> true_in(Q, S) ; true_in(R, S) )).
means((P -> Q), S, ( true_in(P, S) -> true_in(Q, S) )).
means((P ; Q), S, ( true_in(P, S) ; true_in(Q, S) )).
means(or([]), _, fail).
means(or([P]), S, true_in(P, S)).
means(or([P|Ps]), S, ( true_in(P, S) ; true_in(or(Ps), S) )).
means(neg(P), S, \+ true_in(P, S)).
means(\+ P, S, \+ true_in(P, S)).
means(impl(P, Q), S, ( true_in(P, S) -> \+ \+ true_in(Q, S) ; true )).
means(equiv(P, Q), S, ( true_in(P, S) -> \+ \+ true_in(Q, S) ; \+ true_in(Q, S) )).
means(some(V, P), S, ( instance(V, P, S, P1), true_in(P1, S) )).
means(all(V, P), S, \+ ( instance(V, P, S, P1), \+ true_in(P1, S) )).
means(some(V, D, P), S, ( instance((V, D), P, S, P1), true_in(P1, S) )).
means(all(V, D, P), S, \+ ( instance((V, D), P, S, P1), \+ true_in(P1, S) )).
means(X = Y, S,
      (   ground(Y)                       % once, whatever X enumerates
      ->  value_in(Y, S, V), value_in(X, S, V)
      ;   value_in(X, S, V), value_in(Y, S, V)
      )).
means(X < Y, S, ( value_in(X, S, A), value_in(Y, S, B), A < B )).
means(X > Y, S, ( value_in(X, S, A), value_in(Y, S, B), A > B )).
means(X =< Y, S, ( value_in(X, S, A), value_in(Y, S, B), A =< B )).
means(X >= Y, S, ( value_in(X, S, A), value_in(Y, S, B), A >= B )).
means(X =:= Y, S, ( value_in(X, S, A), value_in(Y, S, B), A =:= B )).
means(X =\= Y, S, ( value_in(X, S, A), value_in(Y, S, B), A =\= B )).
means(X is Y, S, ( value_in(Y, S, B), value_in(X, S, A), A is B )).
means(know(P), W, ( actual_situation(W, S), known(P, S) )).
means(kwhether(P), W, ( actual_situation(W, S), known_whether(P, S) )).
means(done(A), S, ( situation_history(S, History), member(A, History) )).
means(forall(P, Q), S, \+ ( true_in(P, S), \+ true_in(Q, S) )).
means(findall(T, P, L), S, findall(T, true_in(P, S), L)).
means(aggregate_all(T, P, R), S, aggregate_all(T, true_in(P, S), R)).
means(once(P), S, once(true_in(P, S))).

% An abbreviation, a fluent, or a goal of the theory.
true_in(P, S) =>
    situation_module(S, Module),
    (   Module:proc(P, Body)
    ->  true_in(Body, S)
    ;   ( compound(P), P \= [_|_] -> arguments_in(P, S, Q) ; Q = P ),
        (   Module:'$fluent'(Q, Kind)
        ->  value_of(Q, Kind, S, Value),
            true_value(Value, P, Module)
        ;   call_goal(Q, P, Module)
        )
    ).

%!  true_value(+Value, +Formula, +Module) is nondet.
%
%   Formula is a fluent that stands alone: it is true when its Value is.  One that is not declared with these
%   arguments has itself as its value, and is true only if a predicate of that name says so.
%
%   @error golog(undeclared_instance(Fluent))

true_value(Value, P, Module) :-
    (   Value == true
    ->  true
    ;   functor(P, Name, Arity, compound),
        functor(Value, Name, Arity, compound),
        \+ predicate_property(Module:Value, visible)
    ->  throw(error(golog(undeclared_instance(Value)), _))
    ;   call_goal(Value, P, Module)
    ).

%!  call_goal(+Goal, +Formula, +Module) is nondet.
%
%   Goal is Formula with values in place of fluents.

call_goal(Goal, P, Module) :-
    (   callable(Goal),
        Goal \== [],
        Goal \= [_|_]                     % which Prolog would load as files
    ->  Module:Goal
    ;   throw(error(golog(not_a_formula(P, Goal)), _))
    ).

%!  instance(+Variables, +Term, +World, -Term1) is nondet.
%
%   Term1 is Term with values for Variables, a variable or a list, each with a domain or
%   without.

instance(V, T, S, T1) :-
    (   is_list(V)
    ->  instance_of_each(V, T, S, T1)
    ;   nonvar(V), V = (V0, D)
    ->  value_in(D, S, D1),
        situation_theory(S, Theory),
        domain_list(Theory, D1, Values),
        member(X, Values),
        substitute(V0, X, T, T1)
    ;   substitute(V, _, T, T1)
    ).

instance_of_each([], T, _, T).
instance_of_each([V|Vs], T0, S, T) :-
    instance(V, T0, S, T1),
    instance_of_each(Vs, T1, S, T).


                /* The values of terms */

%!  value_in(+Term, +World, -Value) is nondet.
%
%   As evaluate/3, in a world.

value_in(T, _, V), var(T) =>
    V = T.
value_in(T, S, V), atom(T) =>
    situation_module(S, Module),
    (   Module:'$fluent'(T, Kind)
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
    situation_module(S, Module),
    (   Module:'$fluent'(T1, Kind)
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

%!  value_of(+Fluent, +Kind, +World, -Value) is nondet.
%
%   Value of a declared Fluent, of Kind `rel` or `fun`, whose instances are enumerated.

value_of(F, Kind, S, V) :-
    (   ground(F)
    ->  fluent_status(F, S, Status),
        ground_value(Status, F, Kind, S, V)
    ;   situation_open(S, []),
        situation_theory(S, Theory),
        ground_instances(Theory, F, Instance, Status)
    ->  situation_values(S, Values),      % the common case
        call(Instance),
        (   stored(Values, F, Value)
        ->  (   Value = '$any'(Possible)
            ->  throw(several_values(F, Possible))
            ;   V = Value
            )
        ;   instance_value(Status, F, V)
        )
    ;   fluent_instance(F, S, Status),
        instance_value(Status, F, V)
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
