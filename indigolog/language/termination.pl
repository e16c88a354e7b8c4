:- module(indigolog_termination,
          [ final/3,                  % +Program, +Situation, +Context
            never_final/1             % +Program
          ]).
:- use_module(library(lists), [member/2]).
:- use_module(theory).
:- use_module(situation).
:- use_module(formula, [holds_in/2, evaluate/3]).
:- use_module(substitution).
:- use_module(context).
:- use_module('../search/monitor').
:- use_module('../search/search').
:- use_module(transition, [trans/5]).

/** <module> Final: where a program may end

final(E, S, C): program E may legally end in situation S.
*/

%!  never_final(+Program) is semidet.
%
%   Program has no final situation whatever the theory says: it must make a
%   step first.  Lets a sequence go on without a choice point.

never_final(E), var(E) => fail.
never_final(?(_)) => true.
never_final(??(_)) => true.
never_final([E|L]) =>
    (   never_final(E)
    ->  true
    ;   L \== [],
        never_final(L)
    ).
never_final(if(_, E, F)) => never_final(E), never_final(F).
never_final(ndet(E, F)) => never_final(E), never_final(F).
never_final(pi(_, E)) => never_final(E).
never_final(pi(_, _, E)) => never_final(E).
never_final(conc(E, F)) => ( never_final(E) -> true ; never_final(F) ).
never_final(pconc(E, F)) => ( never_final(E) -> true ; never_final(F) ).
never_final('$interrupts'(_, _)) => true.
never_final(prioritized_interrupts(_)) => true.
never_final(stop_interrupts) => true.
never_final(wait) => true.
never_final(_) => fail.

%!  final(+Program, +Situation, +Context) is nondet.
%
%   Nondeterministic only for programs with free variables.

final(E, _, _), var(E) =>
    throw(error(golog(open_program), _)).
final([], _, _) =>
    true.
final([E|L], S, C) =>
    final(E, S, C),
    final(L, S, C).
final(?(_), _, _) =>
    fail.
final(??(_), _, _) =>
    fail.
final(ndet(E, F), S, C) =>
    either(E, F, S, C).
final(rndet(E, F), S, C) =>
    either(E, F, S, C).
final(wndet(E, F), S, C) =>
    final(E, S, C),
    final(F, S, C).
final(if(P, E), S, C) =>
    final(if(P, E, []), S, C).
final(if(P, E, F), S, C) =>
    (   holds_in(P, S)
    ->  final(E, S, C)
    ;   final(F, S, C)
    ).
final(while(P, E), S, C) =>
    (   holds_in(P, S)
    ->  final(E, S, C)
    ;   true
    ).
final(star(_), _, _) =>
    true.
final(star(_, _), _, _) =>
    true.
final(pi(V, E), S, C) =>
    some_final(V, E, S, C).
final(pi(V, D, E), S, C) =>
    some_final((V, D), E, S, C).
final(rpi(V, E), S, C) =>
    some_final(V, E, S, C).
final(rpi(V, D, E), S, C) =>
    some_final((V, D), E, S, C).
final(for(V, D, E), S, C) =>
    for_sequence(V, D, E, S, Es),
    final(Es, S, C).
final(conc(E, F), S, C) =>
    final(E, S, C),
    final(F, S, C).
final(pconc(E, F), S, C) =>
    final(E, S, C),
    final(F, S, C).
final(iconc(_), _, _) =>
    true.
final(rconc(E, F), S, C) =>
    final([E, F], S, C).
final(rconc(Es), S, C) =>
    final(Es, S, C).
final(rrobin(Es), S, C) =>
    final(Es, S, C).
final(sync(Es), S, C) =>                            % perhaps after steps without an action
    all_end(Es, S, C).
final(interrupt(_, E), S, C) =>
    ended_interrupt(E, S, C).
final(interrupt(_, _, E), S, C) =>
    ended_interrupt(E, S, C).
final(prioritized_interrupts(_), _, _) =>
    fail.
final('$interrupts'(_, _), _, _) =>
    fail.
final('$stopped'(E), S, C0) =>
    stopped_context(C0, C),
    final(E, S, C).
final(gexec(P, E), S, C) =>
    (   \+ holds_in(P, S)
    ->  true
    ;   final(E, S, C)
    ).
final(goal(Done, E, _, _), S, C) =>
    (   holds_in(Done, S)
    ->  true
    ;   final(E, S, C)
    ).
final(atomic(E), S, C) =>
    final(E, S, C).
final('$atomic'(E), S, C) =>
    final(E, S, C).
final('$locked'(E), S, C) =>
    final(E, S, C).
final(time(E, Seconds), S, C) =>
    within(Seconds, final(E, S, C)).
final(ttime(E, Seconds), S, C) =>
    within(Seconds, final(E, S, C)).
final(search(E), S, C) =>
    final(E, S, C).
final(search(E, _), S, C) =>
    final(E, S, C).
final(searchc(E), S, C) =>
    final(E, S, C).
final(searchc(E, _), S, C) =>
    final(E, S, C).
final('$plan'(E, _, S0, Steps), S, C) =>
    (   Steps == [],
        plan_expects(S0, S)
    ->  true
    ;   final(E, S, C)
    ).
final('$conditional'(Monitor, Plan), S, C) =>
    monitored_final(Monitor, Plan, S, C).
final(E, S, C) =>
    S = s(th(Module, _, _, _), _, _, _, _),
    Module:proc(E, Body),
    !,
    \+ never_final(Body),
    enter(E, C, C1),
    final(Body, S, C1).

either(E, F, S, C) :-
    (   ground(E-F)
    ->  (   final(E, S, C)
        ->  true
        ;   final(F, S, C)
        )
    ;   (   final(E, S, C)
        ;   final(F, S, C)
        )
    ).

% An interrupt ends only when the interrupts around it have been stopped.
ended_interrupt(_, _, C) :-
    \+ interrupts_running(C).

all_end([], _, _).
all_end([E|Es], S, C) :-
    ends(E, S, C, []),
    all_end(Es, S, C).

ends(E, S, C, _) :-
    final(E, S, C).
ends(E, S, C, Seen) :-
    trans(E, S, C, E1, S1),
    situation_length(S, N),
    situation_length(S1, N),
    \+ ( member(E0, [E|Seen]), E0 =@= E1 ),
    ends(E1, S1, C, [E|Seen]).

some_final(V, E, S, C) :-
    (   is_list(V)
    ->  (   V = [V1|Vs]
        ->  some_final(V1, pi(Vs, E), S, C)
        ;   final(E, S, C)
        )
    ;   nonvar(V), V = (V0, D)
    ->  ( nonvar(V0), V0 = r(V1) -> true ; V1 = V0 ),
        evaluate(D, S, D1),
        situation_theory(S, Theory),
        domain_list(Theory, D1, Values),
        member(X, Values),
        substitute(V1, X, E, E1),
        final(E1, S, C),
        !
    ;   substitute(V, _, E, E1),
        final(E1, S, C),
        !
    ).
