:- module(indigolog_action,
          [ act/3,                    % +Term, +Situation, -Situation1
            evaluated_action/3,       % +Term, +Situation, -Action
            supposed/2,               % +Action, +Situation
            pick/5                    % +Variables, +Program, +Order, +Situation, -Instance
          ]).
:- use_module(library(lists), [member/2]).
:- use_module(chance, [shuffled/2]).
:- use_module(compiled, [known_plain/2, learn_plain/2, possible_plain/2]).
:- use_module(formula, [arguments_in/3, holds_in/2, evaluate/3]).
:- use_module(situation).
:- use_module(substitution).
:- use_module(theory).
:- use_module(world, [values_certain/1]).

/** <module> Primitive actions, and the choice of arguments */

%!  act(+Term, +Situation, -Situation1) is nondet.
%
%   The arguments of Term are evaluated; it must then be a primitive action, and
%   possible.

act(Term, S, S1) :-
    S = s(Theory, _, _, _, _),
    known_plain(Term, Theory),
    !,
    once(possible_plain(Term, S)),
    progress_plain(Term, S, S1).
act(Term, S, S1) :-
    evaluated_action(Term, S, A),
    situation_theory(S, Theory),
    theory_module(Theory, Module),
    (   ground(A)
    ->  primitive(A, Module, Theory),
        ( Term == A -> learn_plain(A, Theory) ; true ),
        possible(A, Module, S),
        !
    ;   primitive(A, Module, Theory),
        possible(A, Module, S),
        (   ground(A)
        ->  true
        ;   throw(error(golog(open_action(A)), _))
        )
    ),
    progress(A, S, S1).

%!  evaluated_action(+Term, +Situation, -Action) is nondet.

evaluated_action(set(F), _, A) =>
    A = set(F).
evaluated_action(unset(F), _, A) =>
    A = unset(F).
evaluated_action(Term, _, A), atom(Term) =>
    A = Term.
evaluated_action(Term, S, A), compound(Term) =>
    (   values_certain(S)
    ->  arguments_in(Term, S, A)
    ;   compound_name_arguments(Term, Name, Args0),
        values(Args0, S, Args),
        compound_name_arguments(A, Name, Args)
    ).
evaluated_action(Term, _, _) =>
    throw(error(golog(not_a_program(Term)), _)).

values([], _, []).
values([A|As], S, [B|Bs]) :-
    evaluate(A, S, B),
    values(As, S, Bs).

primitive(set(_), _, _) =>
    true.
primitive(unset(_), _, _) =>
    true.
primitive(A, Module, Theory) =>
    (   Module:prim_action(A)
    *-> true
    ;   action_template(Theory, A, _)
    ->  fail
    ;   called_procedure(Theory, A)
    ->  throw(error(golog(no_clause(A)), _))
    ;   throw(error(golog(unknown_action(A)), _))
    ).

possible(set(F), _, _) =>
    ground(F).
possible(unset(F), _, _) =>
    ground(F).
possible(A, Module, S) =>
    Module:poss(A, P),
    holds_in(P, S).


%!  supposed(+Action, +Situation) is det.
%
%   @error golog(unknown_exogenous(Action)) if it is not a declared exogenous action

supposed(A, S) :-
    situation_theory(S, Theory),
    theory_module(Theory, Module),
    (   Module:exog_action(A)
    *-> true
    ;   throw(error(golog(unknown_exogenous(A)), _))
    ).


                /* Choices of arguments */

%!  pick(+Variables, +Program, +Order, +Situation, -Instance) is nondet.
%
%   Instance is Program with values for Variables, a variable or a list, each with a
%   domain or without; Order is `ordered` or `random`.

pick([], E, _, _, E0) =>
    E0 = E.
pick([V|Vs], E, Order, S, E0) =>
    pick(V, E, Order, S, E1),
    pick(Vs, E1, Order, S, E0).
pick(V, E, Order, S, E0), nonvar(V), V = (V0, D) =>
    (   nonvar(V0), V0 = r(V1)
    ->  Order1 = random
    ;   V1 = V0, Order1 = Order
    ),
    evaluate(D, S, D1),
    situation_theory(S, Theory),
    domain_list(Theory, D1, Values0),
    in_order(Order1, Values0, Values),
    member(X, Values),
    substitute(V1, X, E, E0).
pick(V, E, _, _, E0) =>
    substitute(V, _, E, E0).

in_order(ordered, Values, Values).
in_order(random, Values0, Values) :-
    shuffled(Values0, Values).
