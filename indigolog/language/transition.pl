:- module(indigolog_transition,
          [ step/4,                   % +Program, +Situation, -Program1, -Situation1
            trans/5                   % +Program, +Situation, +Context, -Program1, -Situation1
          ]).
:- use_module(library(lists), [member/2, memberchk/2, nth0/3, append/3, select/3]).
:- use_module(library(error), [must_be/2]).
:- use_module(theory).
:- use_module(situation).
:- use_module(formula, [holds_in/2, test/2]).
:- use_module(termination).
:- use_module(context).
:- use_module(action).
:- use_module('../search/search').
:- use_module('../search/conditional', [chosen_branch/4]).
:- use_module('../search/monitor').
:- use_module(chance).

/** <module> Trans: one step of a program

trans(E, S, C, E1, S1): program E in situation S may make a single step to
program E1 in situation S1.  The rules are those of De Giacomo, Lesperance and
Levesque (2000) for ConGolog and of De Giacomo and Levesque (1999) for search;
docs/language.md states the rule of every construct.  A step of a sequence is
first a step of its head; only a head that may be final lets the rest begin.
*/

%!  step(+Program, +Situation, -Program1, -Situation1) is nondet.
%
%   A step from the top: errors are told with the program and the situation.

step(E, S, E1, S1) :-
    top_context(C),
    catch(trans(E, S, C, E1, S1), Error, in_step(Error, E, S)).

%!  trans(+Program, +Situation, +Context, -Program1, -Situation1) is nondet.

trans(E, _, _, _, _), var(E) =>
    throw(error(golog(open_program), _)).
trans([], _, _, _, _) =>
    fail.
trans([E|L], S, C, E1, S1) =>                       % Trans(E;L)
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
trans(?(P), S, _, E1, S1) =>
    E1 = [],
    (   P == wait_exog_action
    ->  progress(wait, S, S1)
    ;   S1 = S,
        test(P, S)
    ).
trans(??(P), S, _, E1, S1) =>
    E1 = [],
    test(P, S),
    progress(test(P), S, S1).
trans(ndet(E, F), S, C, E1, S1) =>
    (   trans(E, S, C, E1, S1)
    ;   trans(F, S, C, E1, S1)
    ).
trans(wndet(E, F), S, C, E1, S1) =>                 % F only where E cannot
    (   trans(E, S, C, E0, S0)
    *-> E1 = E0, S1 = S0
    ;   trans(F, S, C, E1, S1)
    ).
trans(rndet(E, F), S, C, E1, S1) =>
    shuffled([E, F], Es),
    member(E0, Es),
    trans(E0, S, C, E1, S1).
trans(if(P, E), S, C, E1, S1) =>
    test(P, S),
    !,
    trans(E, S, C, E1, S1).
trans(if(P, E, F), S, C, E1, S1) =>
    (   holds_in(P, S)
    ->  trans(E, S, C, E1, S1)
    ;   trans(F, S, C, E1, S1)
    ).
trans(while(P, E), S, C, E1, S1) =>
    test(P, S),
    trans(E, S, C, E0, S1),
    sequence(E0, [while(P, E)], E1).
trans(star(E), S, C, E1, S1) =>
    trans(E, S, C, E0, S1),
    sequence(E0, [star(E)], E1).
trans(star(E, N), S, C, E1, S1) =>                  % at most N times
    must_be(integer, N),
    N > 0,
    trans(E, S, C, E0, S1),
    (   N =:= 1
    ->  E1 = E0
    ;   M is N-1,
        sequence(E0, [star(E, M)], E1)
    ).
trans(pi(V, E), S, C, E1, S1) =>
    pick(V, E, ordered, S, E0),
    trans(E0, S, C, E1, S1).
trans(pi(V, D, E), S, C, E1, S1) =>
    pick((V, D), E, ordered, S, E0),
    trans(E0, S, C, E1, S1).
trans(rpi(V, E), S, C, E1, S1) =>
    pick(V, E, random, S, E0),
    trans(E0, S, C, E1, S1).
trans(rpi(V, D, E), S, C, E1, S1) =>
    pick((V, D), E, random, S, E0),
    trans(E0, S, C, E1, S1).
trans(for(V, D, E), S, C, E1, S1) =>
    for_sequence(V, D, E, S, E0),
    trans(E0, S, C, E1, S1).
trans(conc(E, F), S, C, E1, S1) =>
    (   trans(E, S, C, E0, S1),
        concurrent(E0, F, E1)
    ;   trans(F, S, C, F0, S1),
        concurrent(E, F0, E1)
    ).
trans(pconc(E, F), S, C, E1, S1) =>                 % E goes first whenever it can
    (   trans(E, S, C, E0, S0)
    *-> S1 = S0,
        prioritized(E0, F, E1)
    ;   trans(F, S, C, F0, S1),
        prioritized(E, F0, E1)
    ).
trans('$locked'(E), S, C, E1, S1) =>
    locked(E, S, C, E1, S1).
trans(iconc(E), S, C, E1, S1) =>
    trans(E, S, C, E0, S1),
    concurrent(E0, iconc(E), E1).
trans(rconc(E, F), S, C, E1, S1) =>
    trans(rconc([E, F]), S, C, E1, S1).
trans(rconc(Es), S, C, E1, S1) =>
    numbered(Es, Numbered),
    shuffled(Numbered, Order),
    member(I-E, Order),
    trans(E, S, C, E0, S1),
    replaced(I, Es, E0, Es1),
    around(E0, rconc(Es1), E1).
trans(rrobin(Es), S, C, E1, S1) =>                  % whoever moved goes to the end
    select(E, Es, Rest),
    trans(E, S, C, E0, S1),
    append(Rest, [E0], Es1),
    around(E0, rrobin(Es1), E1).
trans(sync(Es), S, C, E1, S1) =>
    together(Es, S, C, Es1, none, Action),
    (   memberchk('$locked'(_), Es1)
    ->  E1 = '$locked'(sync(Es1))
    ;   E1 = sync(Es1)
    ),
    progress(Action, S, S1).
trans(interrupt(P, E), S, C, E1, S1) =>
    interrupts_running(C),
    once_if_ground(P, holds_in(P, S)),
    trans(E, S, C, E0, S1),
    sequence(E0, [interrupt(P, E)], E1).
trans(interrupt(V, P, E), S, C, E1, S1) =>
    interrupts_running(C),
    pick(V, if(P, E, ?(false)), ordered, S, E0),
    trans(E0, S, C, E2, S1),
    sequence(E2, [interrupt(V, P, E)], E1).
trans(prioritized_interrupts(Is), S, C, E1, S1) =>
    by_priority(Is, E),
    context_depth(C, N0),
    N is N0+1,
    trans('$interrupts'(N, E), S, C, E1, S1).
trans('$interrupts'(N, E), S, C0, E1, S1) =>
    interrupts_context(N, C0, C),
    trans(E, S, C, E0, S1),
    (   interrupts_stopped(N, S, S1)
    ->  stopped_interrupts(E0, E1)
    ;   around(E0, '$interrupts'(N, E0), E1)
    ).
trans('$stopped'(E), S, C0, E1, S1) =>
    stopped_context(C0, C),
    trans(E, S, C, E0, S1),
    stopped_interrupts(E0, E1).
trans(stop_interrupts, S, C, E1, S1) =>
    E1 = [],
    context_depth(C, N),
    stop_interrupts(N, S, S1).
trans(gexec(P, E), S, C, E1, S1) =>                 % as long as P holds
    once_if_ground(P, holds_in(P, S)),
    trans(E, S, C, E0, S1),
    around(E0, gexec(P, E0), E1).
trans(goal(Done, E, Failed, Recovery), S, C, E1, S1) =>
    \+ holds_in(Done, S),
    (   holds_in(Failed, S)
    ->  trans(Recovery, S, C, E1, S1)
    ;   trans(E, S, C, E0, S1),
        around(E0, goal(Done, E0, Failed, Recovery), E1)
    ).
trans(abort(P), S, _, E1, S1) =>
    E1 = [],
    progress(e(P, false), S, S1).
trans(atomic(E), S, C, E1, S1) =>                   % nothing comes between its steps
    trans(E, S, C, E0, S1),
    atomic_rest(E0, E1).
trans('$atomic'(E), S, C, E1, S1) =>
    (   trans(E, S, C, E0, S1),
        atomic_rest(E0, E1)
    ;   once_if_ground(E, final(E, S, C)),
        E1 = [],
        S1 = S
    ).
trans(time(E, Seconds), S, C, E1, S1) =>            % the first step in time
    within(Seconds, trans(E, S, C, E1, S1)).
trans(ttime(E, Seconds), S, C, E1, S1) =>           % every step in time
    within(Seconds, trans(E, S, C, E0, S1)),
    around(E0, ttime(E0, Seconds), E1).
trans(wait, S, _, E1, S1) =>
    E1 = [],
    progress(wait, S, S1).
trans(abort, S, _, E1, S1) =>
    E1 = [],
    progress(abort, S, S1).
trans(commit, S, _, E1, S1) =>
    E1 = [],
    S1 = S.
trans(search(E), S, C, E1, S1) =>
    search_step(E, [], S, C, E1, S1).
trans(search(E, How), S, C, E1, S1) =>
    (   announcement(How)
    ->  search_step(E, [], S, C, E1, S1)
    ;   search_step(E, How, S, C, E1, S1)
    ).
trans('$plan'(E, How, S0, Steps), S, C, E1, S1) =>
    plan_step(E, How, S0, Steps, S, C, E1, S1).
trans(searchc(E), S, C, E1, S1) =>
    monitored_plan(searchc(E), S, C, E1, S1).
trans(searchc(E, _), S, C, E1, S1) =>
    trans(searchc(E), S, C, E1, S1).
trans(achieve(P), S, C, E1, S1) =>
    trans(achieve(P, 10, []), S, C, E1, S1).
trans(achieve(P, Max), S, C, E1, S1) =>
    trans(achieve(P, Max, []), S, C, E1, S1).
trans(achieve(P, Max, Options), S, C, E1, S1) =>
    must_be(nonneg, Max),
    monitored_plan(achieve(P, Max, Options), S, C, E1, S1).
trans('$conditional'(Monitor, Plan), S, C, E1, S1) =>
    monitored_step(Monitor, Plan, S, C, E1, S1).
trans(case(A, Branches), S, _, E1, S1) =>
    S1 = S,
    chosen_branch(A, Branches, S, E1).
trans(branch(P), S, _, E1, S1) =>
    E1 = [],
    progress(branch(P), S, S1).
trans(sim(A), S, _, E1, S1) =>                      % an exogenous action, supposed
    E1 = [],
    evaluated_action(A, S, A1),
    supposed(A1, S),
    progress(sim(A1), S, S1).
trans(E, S, C, E1, S1) =>
    S = s(th(Module, _, _, _), _, _, _, _),
    (   Module:proc(E, Body)
    ->  enter(E, C, C1),
        trans(Body, S, C1, E1, S1)
    ;   E1 = [],
        act(E, S, S1)
    ).


                /* Helpers of single constructs */

atomic_rest(E0, E1) :-
    (   E0 == []
    ->  E1 = []
    ;   E1 = '$locked'('$atomic'(E0))
    ).

% locked(+E, ...): a step of the part of E that holds the lock.
locked(conc(E, F), S, C, E1, S1) =>
    (   E = '$locked'(_)
    ->  trans(E, S, C, E0, S1),
        concurrent(E0, F, E1)
    ;   trans(F, S, C, F0, S1),
        concurrent(E, F0, E1)
    ).
locked(pconc(E, F), S, C, E1, S1) =>
    (   E = '$locked'(_)
    ->  trans(E, S, C, E0, S1),
        prioritized(E0, F, E1)
    ;   trans(F, S, C, F0, S1),
        prioritized(E, F0, E1)
    ).
locked(rconc(Es), S, C, E1, S1) =>
    nth0(I, Es, '$locked'(E)),
    !,
    trans('$locked'(E), S, C, E0, S1),
    replaced(I, Es, E0, Es1),
    around(E0, rconc(Es1), E1).
locked(rrobin(Es), S, C, E1, S1) =>
    append(Before, ['$locked'(E)|After], Es),
    !,
    trans('$locked'(E), S, C, E0, S1),
    append(Before, [E0|After], Es1),
    around(E0, rrobin(Es1), E1).
locked(E, S, C, E1, S1) =>
    trans(E, S, C, E1, S1).

% The second argument of a published search/2 is what to say about it.
announcement(How) :-
    (   atomic(How)
    ->  How \== []
    ;   How = [First|_],
        atomic(First)
    ).



% sync: every program makes the same action at once.
together([], _, _, [], Action, Action).
together([E|Es], S, C, [E1|E1s], Action0, Action) :-
    until_action(E, S, C, E1, A),
    (   Action0 == none
    ->  true
    ;   A == Action0
    ),
    together(Es, S, C, E1s, A, Action).

until_action(E, S, C, E1, A) :-
    trans(E, S, C, E0, S0),
    (   situation_length(S0, N),
        situation_length(S, N)
    ->  until_action(E0, S, C, E1, A)
    ;   situation_history(S0, [A|_]),
        E1 = E0
    ).

numbered(Es, Numbered) :-
    findall(I-E, nth0(I, Es, E), Numbered0),
    same_variables(Numbered0, Es, Numbered).

% findall/3 copies; keep the programs' own variables.
same_variables([], [], []).
same_variables([I-_|Is], [E|Es], [I-E|Ns]) :-
    same_variables(Is, Es, Ns).

replaced(0, [_|Es], E, [E|Es]) :-
    !.
replaced(I, [X|Es], E, [X|Fs]) :-
    J is I-1,
    replaced(J, Es, E, Fs).
