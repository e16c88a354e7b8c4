:- module(indigolog_golog, []).
/** <module> The constructs of Golog

Sequence, test, nondeterministic choice, conditional, loop, iteration, choice of arguments
(Levesque, Reiter, Lesperance, Lin and Scherl 1997), with the rules of De Giacomo,
Lesperance and Levesque (2000).
*/

:- use_module(action, [pick/5]).
:- use_module(context, [once_if_ground/2]).
:- use_module(formula, [holds_in/2, test/2]).
:- use_module(progression, [progress/3]).
:- use_module(remainder, [sequence/3]).
:- use_module(semantics).

term_expansion(Clause, Defining) :-
    construct_clause(Clause, Defining).


                /* The empty program, and sequence */

% Trans([], S, E', S')  <=>  False
% Final([], S)          <=>  True
construct([], []).
trans([], _, _, _, _) => fail.
final([], _, _).

% Trans([E|L], S, E', S')  <=>  exists E0: E' = [E0|L] & Trans(E, S, E0, S')
%                               or Final(E, S) & Trans(L, S, E', S')
% Final([E|L], S)          <=>  Final(E, S) & Final(L, S)
construct([E|L], [program(E), program(L)]).
trans([E|L], S, C, E1, S1) =>
    (   never_final(E)
    ->  trans(E, S, C, E0, S1),
        sequence(E0, L, E1)
    ;   L == []
    ->  trans(E, S, C, E1, S1)
    ;   \+ final(E, S, C)
    ->  trans(E, S, C, E0, S1),
        sequence(E0, L, E1)
    ;   (   trans(E, S, C, E0, S1),
            sequence(E0, L, E1)
        ;   once_if_ground(E, final(E, S, C)),
            trans(L, S, C, E1, S1)
        )
    ).
final([E|L], S, C) :-
    final(E, S, C),
    final(L, S, C).
must_step([E|L]) :-
    (   never_final(E)
    ->  true
    ;   L \== [],
        never_final(L)
    ).


                /* Test */

% Trans(?(P), S, E', S')  <=>  P[S] & E' = [] & S' = S
% Final(?(P), S)          <=>  False
construct(?(P), Parts) :-
    ( P == wait_exog_action -> Parts = [] ; Parts = [formula(P)] ).
trans(?(P), S, _, E1, S1) =>
    E1 = [],
    (   P == wait_exog_action             % as published, for wait
    ->  progress(wait, S, S1)
    ;   S1 = S,
        test(P, S)
    ).
must_step(?(_)).


                /* Nondeterministic choice */

% Trans(ndet(E, F), S, E', S')  <=>  Trans(E, S, E', S') or Trans(F, S, E', S')
% Final(ndet(E, F), S)          <=>  Final(E, S) or Final(F, S)
construct(ndet(E, F), [program(E), program(F)]).
trans(ndet(E, F), S, C, E1, S1) =>
    (   trans(E, S, C, E1, S1)
    ;   trans(F, S, C, E1, S1)
    ).
final(ndet(E, F), S, C) :-
    once_if_ground(E-F, ( final(E, S, C) ; final(F, S, C) )).
must_step(ndet(E, F)) :-
    never_final(E),
    never_final(F).


                /* Conditional */

% Trans(if(P, E, F), S, E', S')  <=>  P[S] & Trans(E, S, E', S') or ~P[S] & Trans(F, S, E', S')
% Final(if(P, E, F), S)          <=>  P[S] & Final(E, S) or ~P[S] & Final(F, S)
construct(if(P, E, F), [formula(P), program(E), program(F)]).
trans(if(P, E, F), S, C, E1, S1) =>
    (   holds_in(P, S)
    ->  trans(E, S, C, E1, S1)
    ;   trans(F, S, C, E1, S1)
    ).
final(if(P, E, F), S, C) :-
    (   holds_in(P, S)
    ->  final(E, S, C)
    ;   final(F, S, C)
    ).
must_step(if(_, E, F)) :-
    never_final(E),
    never_final(F).

% if(P, E)  =  if(P, E, [])
construct(if(P, E), [formula(P), program(E)]).
trans(if(P, E), S, C, E1, S1) =>
    test(P, S),
    !,
    trans(E, S, C, E1, S1).
final(if(P, E), S, C) :-
    final(if(P, E, []), S, C).


                /* Loop, and nondeterministic iteration */

% Trans(while(P, E), S, E', S')  <=>  exists E0: E' = [E0, while(P, E)] & P[S] & Trans(E, S, E0, S')
% Final(while(P, E), S)          <=>  ~P[S] or Final(E, S)
construct(while(P, E), [formula(P), program(E)]).
trans(while(P, E), S, C, E1, S1) =>
    test(P, S),
    trans(E, S, C, E0, S1),
    sequence(E0, [while(P, E)], E1).
final(while(P, E), S, C) :-
    (   holds_in(P, S)
    ->  final(E, S, C)
    ;   true
    ).

% Trans(star(E), S, E', S')  <=>  exists E0: E' = [E0, star(E)] & Trans(E, S, E0, S')
% Final(star(E), S)          <=>  True
construct(star(E), [program(E)]).
trans(star(E), S, C, E1, S1) =>
    trans(E, S, C, E0, S1),
    sequence(E0, [star(E)], E1).
final(star(_), _, _).


                /* Choice of arguments */

% Trans(pi(V, E), S, E', S')  <=>  exists x: Trans(E[V/x], S, E', S')
% Final(pi(V, E), S)          <=>  exists x: Final(E[V/x], S)
construct(pi(V, E), [variable(V), program(E)]).
trans(pi(V, E), S, C, E1, S1) =>
    pick(V, E, ordered, S, E0),
    trans(E0, S, C, E1, S1).
final(pi(V, E), S, C) :-
    pick(V, E, listed, S, E0),
    final(E0, S, C),
    !.
must_step(pi(_, E)) :-
    never_final(E).

% pi(V, D, E)  =  pi((V, D), E)
construct(pi(V, D, E), [variable((V, D)), program(E)]).
trans(pi(V, D, E), S, C, E1, S1) =>
    trans(pi((V, D), E), S, C, E1, S1).
final(pi(V, D, E), S, C) :-
    final(pi((V, D), E), S, C).
must_step(pi(_, _, E)) :-
    never_final(E).
