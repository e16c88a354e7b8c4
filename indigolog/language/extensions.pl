:- module(indigolog_extensions,
          [ for_sequence/5            % +Variable, +Domain, +Program, +Situation, -Sequence
          ]).
/** <module> The constructs that the published interpreter adds, and atomic */

:- use_module(library(error), [must_be/2]).
:- use_module(library(lists), [append/3, member/2, nth0/3, nth0/4, select/3]).
:- use_module(action, [act/3, evaluated_action/3, pick/5, supposed/2]).
:- use_module(chance, [shuffled/2]).
:- use_module(configuration, [after_action/5, ends/3]).
:- use_module(context, [once_if_ground/2]).
:- use_module(formula, [evaluate/3, test/2]).
:- use_module(progression, [progress/3]).
:- use_module(remainder).
:- use_module(semantics).
:- use_module(situation, [last_action/2, situation_theory/2]).
:- use_module(substitution, [substitute/4]).
:- use_module(theory, [assignment/2, domain_list/3]).

term_expansion(Clause, Defining) :-
    construct_clause(Clause, Defining).


                /* Steps */

% Trans(??(P), S, E', S')  <=>  P[S] & E' = [] & S' = do(test(P), S)
construct(??(P), [formula(P)]).
trans(??(P), S, _, E1, S1) =>
    E1 = [],
    test(P, S),
    progress(test(P), S, S1).
must_step(??(_)).

% Trans(a, S, E', S')  <=>  E' = [] & S' = do(a, S), for a = wait and a = abort
construct(wait, []).
trans(wait, S, _, E1, S1) =>
    E1 = [],
    progress(wait, S, S1).
must_step(wait).

construct(abort, []).
trans(abort, S, _, E1, S1) =>
    E1 = [],
    progress(abort, S, S1).

% Trans(abort(F), S, E', S')  <=>  E' = [] & S' = do(e(F, false), S)
construct(abort(_), []).
trans(abort(F), S, _, E1, S1) =>
    E1 = [],
    progress(e(F, false), S, S1).

% The published interpreter prunes its search at commit; here search remembers instead which
% configurations led nowhere, and does not prune.
construct(commit, []).
trans(commit, _, _, _, _) =>
    throw(error(golog(no_commit), _)).

% Trans(a, S, E', S')  <=>  E' = [] & S' = do(a, S), for a = set(F) and a = unset(F) unless
%                          the theory declares an action of that name
construct(set(_), []).
trans(set(F), S, _, E1, S1) =>
    E1 = [],
    assign(set(F), S, S1).

construct(unset(_), []).
trans(unset(F), S, _, E1, S1) =>
    E1 = [],
    assign(unset(F), S, S1).

assign(A, S, S1) :-
    situation_theory(S, Theory),
    (   assignment(A, Theory)
    ->  ground(A),
        progress(A, S, S1)
    ;   act(A, S, S1)
    ).

% Trans(sim(a), S, E', S')  <=>  E' = [] & S' = do(sim(a[S]), S), for an exogenous action a
construct(sim(_), []).
trans(sim(A), S, _, E1, S1) =>
    E1 = [],
    evaluated_action(A, S, A1),
    supposed(A1, S),
    progress(sim(A1), S, S1).


                /* Choice */

% Trans(wndet(E, F), S, E', S')  <=>  Trans(E, S, E', S')
%                                     or ~(exists E0, S0: Trans(E, S, E0, S0)) & Trans(F, S, E', S')
% Final(wndet(E, F), S)          <=>  Final(E, S) & Final(F, S)
construct(wndet(E, F), [program(E), program(F)]).
trans(wndet(E, F), S, C, E1, S1) =>
    (   trans(E, S, C, E0, S0)
    *-> E1 = E0, S1 = S0
    ;   trans(F, S, C, E1, S1)
    ).
final(wndet(E, F), S, C) :-
    final(E, S, C),
    final(F, S, C).

% rndet(E, F)  =  ndet(E, F), in random order
construct(rndet(E, F), [program(E), program(F)]).
trans(rndet(E, F), S, C, E1, S1) =>
    shuffled([E, F], Es),
    member(E0, Es),
    trans(E0, S, C, E1, S1).
final(rndet(E, F), S, C) :-
    final(ndet(E, F), S, C).

% rpi(V, E)  =  pi(V, E), rpi(V, D, E)  =  pi(V, D, E), in random order
construct(rpi(V, E), [variable(V), program(E)]).
trans(rpi(V, E), S, C, E1, S1) =>
    pick(V, E, random, S, E0),
    trans(E0, S, C, E1, S1).
final(rpi(V, E), S, C) :-
    final(pi(V, E), S, C).

construct(rpi(V, D, E), [variable((V, D)), program(E)]).
trans(rpi(V, D, E), S, C, E1, S1) =>
    trans(rpi((V, D), E), S, C, E1, S1).
final(rpi(V, D, E), S, C) :-
    final(pi((V, D), E), S, C).


                /* Iteration */

% star(E, N)  =  star(E) of at most N rounds
construct(star(E, _), [program(E)]).
trans(star(E, N), S, C, E1, S1) =>
    must_be(integer, N),
    N > 0,
    trans(E, S, C, E0, S1),
    (   N =:= 1
    ->  E1 = E0
    ;   M is N-1,
        sequence(E0, [star(E, M)], E1)
    ).
final(star(_, _), _, _).

% for(V, D, E)  =  [E[V/d1], ..., E[V/dn]], for D = [d1, ..., dn]
construct(for(V, D, E), [variable((V, D)), program(E)]).
trans(for(V, D, E), S, C, E1, S1) =>
    for_sequence(V, D, E, S, Es),
    trans(Es, S, C, E1, S1).
final(for(V, D, E), S, C) :-
    for_sequence(V, D, E, S, Es),
    final(Es, S, C).

%!  for_sequence(+Variable, +Domain, +Program, +Situation, -Sequence) is det.

for_sequence(V, D, E, S, Es) :-
    evaluate(D, S, D1),
    situation_theory(S, Theory),
    domain_list(Theory, D1, Values),
    instances(Values, V, E, Es).

instances([], _, _, []).
instances([X|Xs], V, E, [E1|Es]) :-
    substitute(V, X, E, E1),
    instances(Xs, V, E, Es).


                /* Concurrency */

% rconc([E1, ..., En])  =  conc(E1, ... conc(En-1, En)), in random order
construct(rconc(E, F), [program(E), program(F)]).
trans(rconc(E, F), S, C, E1, S1) =>
    trans(rconc([E, F]), S, C, E1, S1).
final(rconc(E, F), S, C) :-
    final([E, F], S, C).

construct(rconc(Es), [programs(Es)]).
trans(rconc(Es), S, C, E1, S1) =>
    places(Es, Places),
    shuffled(Places, Order),
    member(I, Order),
    nth0(I, Es, E, Rest),
    trans(E, S, C, E0, S1),
    nth0(I, Es1, E0, Rest),
    around(E0, rconc(Es1), E1).
final(rconc(Es), S, C) :-
    final(Es, S, C).

% places(+Programs, -Places): of those that may step, all others being free.
places(Es, Places) :-
    findall(I, ( nth0(I, Es, E), \+ free(E) ), Locked),
    places(Locked, Es, Places).

places([], Es, Places) =>
    findall(I, nth0(I, Es, _), Places).
places([I], _, Places) =>
    Places = [I].
places(_, _, Places) =>
    Places = [].

% Trans(rrobin(Es), S, E', S')  <=>  exists E, E0: Es = Before + [E] + After & Trans(E, S, E0, S')
%                                    & E' = rrobin(Before + After + [E0])
% Final(rrobin(Es), S)          <=>  Final of each
construct(rrobin(Es), [programs(Es)]).
trans(rrobin(Es), S, C, E1, S1) =>
    select(E, Es, Rest),
    all_free(Rest),
    trans(E, S, C, E0, S1),
    append(Rest, [E0], Es1),
    around(E0, rrobin(Es1), E1).
final(rrobin(Es), S, C) :-
    final(Es, S, C).

% Trans(sync(Es), S, E', S')  <=>  exists a: S' = do(a, S) & E' = sync(Es') & Es is not [] &
%                                  each E of Es comes by steps without an action, then a, to its E0 of Es'
% Final(sync(Es), S)          <=>  each comes by steps without an action to where it is final
construct(sync(Es), [programs(Es)]).
trans(sync(Es), S, C, E1, S1) =>
    Es = [_|_],
    together(Es, S, C, Es1, none, Action),
    around_all(Es1, sync(Es1), E1),
    progress(Action, S, S1).
final(sync(Es), S, C) :-
    all_end(Es, S, C).

together([], _, _, [], Action, Action).
together([E|Es], S, C, [E1|E1s], Action0, Action) :-
    after_action(E, S, C, E1, S1),
    last_action(S1, A),
    (   Action0 == none
    ->  true
    ;   A == Action0
    ),
    together(Es, S, C, E1s, A, Action).

all_end([], _, _).
all_end([E|Es], S, C) :-
    ends(E, S, C),
    all_end(Es, S, C).

% Trans(atomic(E), S, E', S')  <=>  exists E0: E' = E0 holding the lock, or [] if E0 is & Trans(E, S, E0, S')
% Final(atomic(E), S)          <=>  Final(E, S)
construct(atomic(E), [program(E)]).
trans(atomic(E), S, C, E1, S1) =>
    trans(E, S, C, E0, S1),
    atomic_rest(E0, E1).
final(atomic(E), S, C) :-
    final(E, S, C).

% What is left of it lets the lock go when it is final.
construct('$atomic'(E), [program(E)]).
shown_as('$atomic'(E), atomic(E)).
trans('$atomic'(E), S, C, E1, S1) =>
    (   trans(E, S, C, E0, S1),
        atomic_rest(E0, E1)
    ;   once_if_ground(E, final(E, S, C)),
        E1 = [],
        S1 = S
    ).
final('$atomic'(E), S, C) :-
    final(E, S, C).

atomic_rest(E0, E1) :-
    (   E0 == []
    ->  E1 = []
    ;   locked('$atomic'(E0), E1)
    ).
