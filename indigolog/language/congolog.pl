:- module(indigolog_congolog,
          [ by_priority/2             % +Interrupts, -Program
          ]).
/** <module> The constructs of ConGolog

Concurrency, with priorities or without, iterated, and interrupts (De Giacomo, Lesperance
and Levesque 2000).  Beside the rules there: what is beside a program that holds the lock
of atomic/1 waits.
*/

:- use_module(action, [pick/5]).
:- use_module(context).
:- use_module(formula, [holds_in/2]).
:- use_module(progression, [stop_interrupts/3, stopped_depth/2]).
:- use_module(remainder).
:- use_module(semantics).
:- use_module(situation, [situation_history/2]).

term_expansion(Clause, Defining) :-
    construct_clause(Clause, Defining).


                /* Concurrency */

% Trans(conc(E, F), S, E', S')  <=>  exists E0: E' = conc(E0, F) & Trans(E, S, E0, S')
%                                    or exists F0: E' = conc(E, F0) & Trans(F, S, F0, S')
% Final(conc(E, F), S)          <=>  Final(E, S) & Final(F, S)
construct(conc(E, F), [program(E), program(F)]).
trans(conc(E, F), S, C, E1, S1) =>
    (   free(F),
        trans(E, S, C, E0, S1),
        concurrent(E0, F, E1)
    ;   free(E),
        trans(F, S, C, F0, S1),
        concurrent(E, F0, E1)
    ).
final(conc(E, F), S, C) :-
    final(E, S, C),
    final(F, S, C).
must_step(conc(E, F)) :-
    ( never_final(E) -> true ; never_final(F) ).

% Trans(pconc(E, F), S, E', S')  <=>  exists E0: E' = pconc(E0, F) & Trans(E, S, E0, S')
%                                     or exists F0: E' = pconc(E, F0) & Trans(F, S, F0, S')
%                                        & ~exists E0, S0: Trans(E, S, E0, S0)
% Final(pconc(E, F), S)          <=>  Final(E, S) & Final(F, S)
construct(pconc(E, F), [program(E), program(F)]).
trans(pconc(E, F), S, C, E1, S1) =>
    (   free(F),
        trans(E, S, C, E0, S0)
    *-> S1 = S0,
        prioritized(E0, F, E1)
    ;   free(E),
        trans(F, S, C, F0, S1),
        prioritized(E, F0, E1)
    ).
final(pconc(E, F), S, C) :-
    final(E, S, C),
    final(F, S, C).
must_step(pconc(E, F)) :-
    ( never_final(E) -> true ; never_final(F) ).

% Trans(iconc(E), S, E', S')  <=>  exists E0: E' = conc(E0, iconc(E)) & Trans(E, S, E0, S')
% Final(iconc(E), S)          <=>  True
construct(iconc(E), [program(E)]).
trans(iconc(E), S, C, E1, S1) =>
    trans(E, S, C, E0, S1),
    concurrent(E0, iconc(E), E1).
final(iconc(_), _, _).


                /* Interrupts */

% interrupt(P, E)  =  while interrupts run do if P then E else False
% Trans  <=>  exists E0: E' = [E0, interrupt(P, E)] & interrupts run & P[S] & Trans(E, S, E0, S')
% Final  <=>  interrupts do not run
construct(interrupt(P, E), [formula(P), program(E)]).
trans(interrupt(P, E), S, C, E1, S1) =>
    interrupts_running(C),
    once_if_ground(P, holds_in(P, S)),
    trans(E, S, C, E0, S1),
    sequence(E0, [interrupt(P, E)], E1).
final(interrupt(_, _), _, C) :-
    \+ interrupts_running(C).

% interrupt(V, P, E)  =  interrupt of pi(V, if(P, E, ?(false)))
construct(interrupt(V, P, E), [variable(V), formula(P), program(E)]).
trans(interrupt(V, P, E), S, C, E1, S1) =>
    interrupts_running(C),
    pick(V, if(P, E, ?(false)), ordered, S, E0),
    trans(E0, S, C, E2, S1),
    sequence(E2, [interrupt(V, P, E)], E1).
final(interrupt(_, _, _), _, C) :-
    \+ interrupts_running(C).

% prioritized_interrupts(Is)  =  interrupts run, then pconc(I1, ... pconc(In, stop_interrupts))
% '$interrupts'(N, E) is what is left of it, N being how deep it stands in others
construct(prioritized_interrupts(Is), [programs(Is)]).
trans(prioritized_interrupts(Is), S, C, E1, S1) =>
    by_priority(Is, E),
    context_depth(C, N0),
    N is N0+1,
    trans('$interrupts'(N, E), S, C, E1, S1).
must_step(prioritized_interrupts(_)).

construct('$interrupts'(_, E), [program(E)]).
shown_as('$interrupts'(_, E), E).
trans('$interrupts'(N, E), S, C0, E1, S1) =>
    interrupts_context(N, C0, C),
    trans(E, S, C, E0, S1),
    (   interrupts_stopped(N, S, S1)
    ->  stopped_interrupts(E0, E1)
    ;   around(E0, '$interrupts'(N, E0), E1)
    ).
must_step('$interrupts'(_, _)).

% What goes on when interrupts have been stopped: each may end, none begins again.
construct('$stopped'(E), [program(E)]).
shown_as('$stopped'(E), E).
trans('$stopped'(E), S, C0, E1, S1) =>
    stopped_context(C0, C),
    trans(E, S, C, E0, S1),
    stopped_interrupts(E0, E1).
final('$stopped'(E), S, C0) :-
    stopped_context(C0, C),
    final(E, S, C).

% Trans(stop_interrupts, S, E', S')  <=>  E' = [] & S' = do(stop_interrupts, S)
% Final(stop_interrupts, S)          <=>  False
construct(stop_interrupts, []).
trans(stop_interrupts, S, C, E1, S1) =>
    E1 = [],
    context_depth(C, N),
    stop_interrupts(N, S, S1).
must_step(stop_interrupts).

%!  by_priority(+Interrupts, -Program) is det.
%
%   Each interrupt over all later ones; when all are blocked, they stop.

by_priority([], stop_interrupts).
by_priority([I|Is], pconc(I, E)) :-
    by_priority(Is, E).

% The step from S to S1 was a stop_interrupts of depth N.
interrupts_stopped(N, S, S1) :-
    situation_history(S1, [stop_interrupts|Before]),
    situation_history(S, Here),
    same_term(Before, Here),
    stopped_depth(S1, N).

stopped_interrupts(E, E1) :-
    (   E == []
    ->  E1 = []
    ;   around(E, '$stopped'(E), E1)
    ).
