:- module(indigolog_action,
          [ act/3,                    % +Term, +Situation, -Situation1
            evaluated_action/3,       % +Term, +Situation, -Action
            supposed/2,               % +Action, +Situation
            pick/5                    % +Variables, +Program, +Order, +Situation, -Instance
          ]).
/** <module> Primitive actions, and the choice of arguments */

:- use_module(library(lists), [member/2]).
:- use_module(library(occurs), [sub_term/2]).
:- use_module(chance, [shuffled/2]).
:- use_module(formula, [arguments_in/3, holds_in/2, evaluate/3]).
:- use_module(progression, [progress/3, progress_plain/3]).
:- use_module(situation).
:- use_module(substitution).
:- use_module(theory).

% Most actions that are remembered as plain.
most_plain(10_000).

%!  act(+Term, +Situation, -Situation1) is nondet.
%
%   The arguments of Term are evaluated; it must then be a primitive action, and
%   possible.

act(Term, S, S1) :-
    situation_theory(S, Theory),
    known_plain(Term, Theory),
    !,
    theory_module(Theory, Module),
    once(Module:'$possible'(Term, S)),
    progress_plain(Term, S, S1).
act(Term, S, S1) :-
    evaluated_action(Term, S, A),
    situation_theory(S, Theory),
    theory_module(Theory, Module),
    (   ground(A)
    ->  primitive(A, Term, Module, Theory),
        ( Term == A -> learn_plain(A, Theory) ; true ),
        possible(A, Module, S),
        !
    ;   primitive(A, Term, Module, Theory),
        possible(A, Module, S),
        (   ground(A)
        ->  true
        ;   throw(error(golog(open_action(A)), _))
        )
    ),
    progress(A, S, S1).

% Term was learnt to be a plain action (compiled.pl).
known_plain(Term, Theory) :-
    plain_actions(Theory, Trie),
    ground(Term),
    trie_lookup(Trie, Term, plain).

% Remember the ground primitive Action, if it is plain.
learn_plain(Action, Theory) :-
    (   plain_actions(Theory, Trie),
        trie_property(Trie, value_count(N)),
        most_plain(Most),
        N < Most,
        \+ ( sub_term(T, Action), callable(T), fluent_template(Theory, T, _) )
    ->  trie_insert(Trie, Action, plain)
    ;   true
    ).

%!  evaluated_action(+Term, +Situation, -Action) is nondet.

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

% primitive(+Action, +Term, +Module, +Theory): Action is Term with its arguments evaluated.  A procedure, which Term would
% call if a clause matched it, is handed them as they are.
primitive(A, Term, Module, Theory) :-
    (   Module:prim_action(A)
    *-> true
    ;   action_template(Theory, A, _)
    ->  fail
    ;   called_procedure(Theory, A)
    ->  findall(F, ( sub_term(F, Term), callable(F), fluent_template(Theory, F, _) ), Fluents),
        throw(error(golog(no_clause(Term, Fluents)), _))
    ;   throw(error(golog(unknown_action(A)), _))
    ).

possible(A, Module, S) :-
    Module:poss(A, P),
    holds_in(P, S).

%!  supposed(+Action, +Situation) is det.
%
%   @error golog(unknown_exogenous(Action)) if it is not a declared exogenous action

supposed(A, S) :-
    situation_module(S, Module),
    (   Module:exog_action(A)
    *-> true
    ;   throw(error(golog(unknown_exogenous(A)), _))
    ).

%!  pick(+Variables, +Program, +Order, +Situation, -Instance) is nondet.
%
%   Instance is Program with values for Variables, a variable or a list, each with a
%   domain or without; Order is `ordered`, where r(V) asks for random order, `random` for
%   all, or `listed`, whatever is asked for.

pick([], E, _, _, E0) =>
    E0 = E.
pick([V|Vs], E, Order, S, E0) =>
    pick(V, E, Order, S, E1),
    pick(Vs, E1, Order, S, E0).
pick(V, E, Order, S, E0), nonvar(V), V = (V0, D) =>
    (   nonvar(V0), V0 = r(V1)
    ->  ( Order == ordered -> Order1 = random ; Order1 = Order )
    ;   V1 = V0, Order1 = Order
    ),
    evaluate(D, S, D1),
    situation_theory(S, Theory),
    domain_list(Theory, D1, Values0),
    ( Order1 == random -> shuffled(Values0, Values) ; Values = Values0 ),
    member(X, Values),
    substitute(V1, X, E, E0).
pick(V, E, _, _, E0) =>
    substitute(V, _, E, E0).
