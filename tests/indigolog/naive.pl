:- module(naive,
          [ naive_traces/3,           % +Program, +Bound, -Traces
            naive_final/2,            % +Program, +History
            naive_runs/4              % +Program, +World, +Bound, -Runs
          ]).
/** <module> The language straight from its axioms

Programs by sets of steps, formulas and values as in naive_values.pl; nothing is
remembered.  Slow and plain: the oracle of the differential tests.  Shares nothing
with the interpreter.
*/

:- use_module(library(apply), [maplist/3, exclude/3]).
:- use_module(library(lists), [append/3, member/2, memberchk/2, nth0/3, nth1/3, reverse/2, select/3]).
:- use_module(library(occurs), [sub_term/2]).
:- use_module(naive_values).

%!  naive_traces(+Program, +Bound, -Traces) is det.
%
%   All complete executions of at most Bound actions, oldest action first.

naive_traces(E, Bound, Traces) :-
    findall(T, ( run(E, [], [], Bound, H), reverse(H, T) ), Ts),
    sort(Ts, Traces).

% Seen: the programs met since the last action.
run(E, H, _, _, H) :-
    \+ \+ f(E, H).
run(E, H, Seen, Bound, H2) :-
    t(E, H, E0, H1),
    tidy(E0, E1),
    (   H1 == H
    ->  \+ ( member(X, [E|Seen]), X =@= E1 ),
        run(E1, H, [E|Seen], Bound, H2)
    ;   length(H1, N), N =< Bound,
        ( H1 = [abort|_] -> H2 = H1 ; run(E1, H1, [], Bound, H2) )
    ).

%!  naive_final(+Program, +History) is semidet.

naive_final(E, H) :-
    \+ \+ f(E, H).

% Without empty parts, so that a loop of tests is seen to repeat.
tidy(E, E) :- \+ compound(E), !.
tidy([E|L], T) :-
    !,
    tidy(E, E1),
    tidy(L, L1),
    (   E1 == [] -> T = L1
    ;   L1 == [] -> T = E1
    ;   L1 = [_|_] -> T = [E1|L1]
    ;   T = [E1, L1]
    ).
tidy(conc(E, F), T) :- !, tidy(E, E1), tidy(F, F1), ( E1 == [] -> T = F1 ; F1 == [] -> T = E1 ; T = conc(E1, F1) ).
tidy(pconc(E, F), T) :- !, tidy(E, E1), tidy(F, F1), ( E1 == [] -> T = F1 ; F1 == [] -> T = E1 ; T = pconc(E1, F1) ).
tidy(lock([]), []) :- !.
tidy(plan([]), []) :- !.
tidy(E, E).


                /* Trans */

t(E, H, E1, H1) :-
    compound(E), E = [F|L], !,
    (   t(F, H, F1, H1), E1 = [F1|L]
    ;   f(F, H), t(L, H, E1, H1)
    ).
t(E, _, _, _) :- E == [], !, fail.
t(?(P), H, [], H) :- !, h(P, H).
t(??(P), H, [], [test(P)|H]) :- !, h(P, H).
t(ndet(E, F), H, E1, H1) :- !, ( t(E, H, E1, H1) ; t(F, H, E1, H1) ).
t(rndet(E, F), H, E1, H1) :- !, t(ndet(E, F), H, E1, H1).
t(wndet(E, F), H, E1, H1) :- !, ( t(E, H, _, _) -> t(E, H, E1, H1) ; t(F, H, E1, H1) ).
t(if(P, E), H, E1, H1) :- !, t(if(P, E, []), H, E1, H1).
t(if(P, E, F), H, E1, H1) :- !, ( h(P, H) -> t(E, H, E1, H1) ; t(F, H, E1, H1) ).
t(while(P, E), H, [E1, while(P, E)], H1) :- !, h(P, H), t(E, H, E1, H1).
t(star(E), H, [E1, star(E)], H1) :- !, t(E, H, E1, H1).
t(star(E, N), H, [E1, star(E, M)], H1) :- !, N > 0, M is N-1, t(E, H, E1, H1).
t(pi(V, E), H, E1, H1) :- !, picked(V, E, E0), t(E0, H, E1, H1).
t(pi(V, D, E), H, E1, H1) :- !, picked((V, D), E, E0), t(E0, H, E1, H1).
t(rpi(V, E), H, E1, H1) :- !, picked(V, E, E0), t(E0, H, E1, H1).
t(rpi(V, D, E), H, E1, H1) :- !, picked((V, D), E, E0), t(E0, H, E1, H1).
t(for(V, D, E), H, E1, H1) :- !, unrolled(V, D, E, L), t(L, H, E1, H1).
t(conc(E, F), H, conc(E1, F1), H1) :- !,
    (   \+ busy(F), t(E, H, E1, H1), F1 = F
    ;   \+ busy(E), t(F, H, F1, H1), E1 = E
    ).
t(pconc(E, F), H, pconc(E1, F1), H1) :- !,
    (   busy(F) -> E1 = E, t(F, H, F1, H1)
    ;   busy(E) -> t(E, H, E1, H1), F1 = F
    ;   t(E, H, _, _) -> t(E, H, E1, H1), F1 = F
    ;   t(F, H, F1, H1), E1 = E
    ).
t(iconc(E), H, conc(E1, iconc(E)), H1) :- !, t(E, H, E1, H1).
t(rconc(E, F), H, E1, H1) :- !, t(rconc([E, F]), H, E1, H1).
t(rconc(Es), H, rconc(Fs), H1) :- !,
    nth0(I, Es, E, Rest), \+ busy(Rest), t(E, H, E1, H1), nth0(I, Fs, E1, Rest).
t(rrobin(Es), H, rrobin(Fs), H1) :- !,
    (   busy(Es)
    ->  nth0(I, Es, E, Rest), busy(E), t(E, H, E1, H1), nth0(I, Fs, E1, Rest)
    ;   select(E, Es, Rest), t(E, H, E1, H1), append(Rest, [E1], Fs)
    ).
t(sync(Es), H, sync(Fs), [A|H]) :- !, Es = [_|_], all_do(Es, H, A, Fs).
t(gexec(P, E), H, gexec(P, E1), H1) :- !, h(P, H), t(E, H, E1, H1).
t(goal(P, E, Q, R), H, E1, H1) :- !,
    \+ h(P, H),
    (   h(Q, H) -> t(R, H, E1, H1)
    ;   t(E, H, E0, H1), E1 = goal(P, E0, Q, R)
    ).
t(prioritized_interrupts(Is), H, E1, H1) :- !, chain(Is, Flag, E), t(ints(Flag, E), H, E1, H1).
t(ints(Flag, E), H, ints(Flag, E1), H1) :- !, t(E, H, E1, H1).
t(int(Flag, P, E), H, [E1, int(Flag, P, E)], H1) :- !, Flag \== stopped, h(P, H), t(E, H, E1, H1).
t(int(Flag, V, P, E), H, [E1, int(Flag, V, P, E)], H1) :- !,
    Flag \== stopped, picked(V, if(P, E, ?(false)), E0), t(E0, H, E1, H1).
t(stop(Flag), H, [], [stop_interrupts|H]) :- !, Flag = stopped.
t(abort, H, [], [abort|H]) :- !.
t(abort(F), H, [], [e(F, false)|H]) :- !.
t(atomic(E), H, E1, H1) :- !, t(E, H, E0, H1), holding(E0, E1).
t(lock(E), H, E1, H1) :- !, ( t(E, H, E0, H1), holding(E0, E1) ; f(E, H), E1 = [], H1 = H ).
t(time(E, _), H, E1, H1) :- !, t(E, H, E1, H1).
t(ttime(E, T), H, ttime(E1, T), H1) :- !, t(E, H, E1, H1).
t(set(F), H, [], [set(F)|H]) :- !.
t(unset(F), H, [], [unset(F)|H]) :- !.
t(sim(A), H, [], [sim(A)|H]) :- !.
t(wait, H, [], [wait|H]) :- !.
t(search(E), H, plan(E1), H1) :- !, t(E, H, E1, H1), completes(E1, H1, []).
t(plan(E), H, E1, H1) :- !, ( t(search(E), H, E1, H1) ; f(E, H), E1 = [], H1 = H ).     % a plan ends where E may
t(search(E, _), H, E1, H1) :- !, t(search(E), H, E1, H1).
t(searchc(E), H, mon(searchc(E), H, [], H, Plan), H) :- !, planned(searchc(E), H, Plan).
t(branch(P), H, [], [branch(P)|H]) :- !.
t(case(A, Bs), H, E, H) :- !, once(member(e(A, R), H)), memberchk(if(R, E), Bs).
t(achieve(P, N, [actions(As)]), H, mon(achieve(P, N, As), H, [], H, Plan), H) :- !, planned(achieve(P, N, As), H, Plan).
t(mon(G, H0, Own, Hx, P), H, E1, H1) :- !, watched(G, H0, Own, Hx, P, H, E1, H1).
t(E, H, E1, H1) :- nt:proc(E, B), !, t(B, H, E1, H1).
t(A, H, [], [B|H]) :-
    callable(A), evaluated(A, H, B), once(nt:prim_action(B)), nt:poss(B, P), h(P, H).

% Of which nothing is left holds no lock.
holding(E, L) :- tidy(E, T), ( T == [] -> L = [] ; L = lock(E) ).

% A program that has begun something atomic.
busy(E) :- sub_term(X, E), compound(X), X = lock(_), !.

chain([], Flag, stop(Flag)).
chain([I|Is], Flag, pconc(J, E)) :-
    (   I = interrupt(P, B) -> J = int(Flag, P, B)
    ;   I = interrupt(V, P, B) -> J = int(Flag, V, P, B)
    ;   J = I
    ),
    chain(Is, Flag, E).

all_do([], _, _, []).
all_do([E|Es], H, A, [F|Fs]) :- by_action(E, H, [], A, F), all_do(Es, H, A, Fs).

by_action(E, H, Seen, A, F) :-
    t(E, H, E0, H1), tidy(E0, E1),
    (   H1 == H
    ->  \+ ( member(X, [E|Seen]), X =@= E1 ), by_action(E1, H, [E|Seen], A, F)
    ;   H1 = [A|_], F = E1
    ).

ends(E, H, _) :- f(E, H), !.
ends(E, H, Seen) :-
    t(E, H, E0, H1), H1 == H, tidy(E0, E1),
    \+ ( member(X, [E|Seen]), X =@= E1 ),
    ends(E1, H, [E|Seen]), !.

completes(E, H, _) :- f(E, H), !.
completes(E, H, Seen) :-
    t(E, H, E0, H1), tidy(E0, E1),
    (   H1 == H
    ->  \+ ( member(X, [E|Seen]), X =@= E1 ), completes(E1, H, [E|Seen])
    ;   completes(E1, H1, [])
    ), !.

                /* Final */

f(E, H) :- compound(E), E = [F|L], !, f(F, H), f(L, H).
f(E, _) :- E == [], !.
f(ndet(E, F), H) :- !, once(( f(E, H) ; f(F, H) )).
f(rndet(E, F), H) :- !, f(ndet(E, F), H).
f(wndet(E, F), H) :- !, f(E, H), f(F, H).
f(if(P, E), H) :- !, f(if(P, E, []), H).
f(if(P, E, F), H) :- !, ( h(P, H) -> f(E, H) ; f(F, H) ).
f(while(P, E), H) :- !, ( \+ h(P, H) -> true ; f(E, H) ).
f(star(_), _) :- !.
f(star(_, _), _) :- !.
f(pi(V, E), H) :- !, once(( picked(V, E, E0), f(E0, H) )).
f(pi(V, D, E), H) :- !, f(pi((V, D), E), H).
f(rpi(V, E), H) :- !, f(pi(V, E), H).
f(rpi(V, D, E), H) :- !, f(pi((V, D), E), H).
f(for(V, D, E), H) :- !, unrolled(V, D, E, L), f(L, H).
f(conc(E, F), H) :- !, f(E, H), f(F, H).
f(pconc(E, F), H) :- !, f(E, H), f(F, H).
f(iconc(_), _) :- !.
f(rconc(E, F), H) :- !, f([E, F], H).
f(rconc(Es), H) :- !, f(Es, H).
f(rrobin(Es), H) :- !, f(Es, H).
f(sync(Es), H) :- !, \+ ( member(E, Es), \+ ends(E, H, []) ).
f(gexec(P, E), H) :- !, ( \+ h(P, H) -> true ; f(E, H) ).
f(goal(P, E, _, _), H) :- !, ( h(P, H) -> true ; f(E, H) ).
f(ints(Flag, E), H) :- !, Flag == stopped, f(E, H).
f(int(Flag, _, _), _) :- !, Flag == stopped.
f(int(Flag, _, _, _), _) :- !, Flag == stopped.
f(atomic(E), H) :- !, f(E, H).
f(lock(E), H) :- !, f(E, H).
f(time(E, _), H) :- !, f(E, H).
f(ttime(E, _), H) :- !, f(E, H).
f(search(E), H) :- !, f(E, H).
f(plan(E), H) :- !, f(E, H).
f(search(E, _), H) :- !, f(E, H).
f(searchc(E), H) :- !, f(E, H).
f(mon(_, _, _, H, _), H) :- !, fail.
f(mon(G, H0, Own, _, _), H) :- !, undone(G, H0, Own, H, G1), reached(G1, H).
f(E, H) :- callable(E), nt:proc(E, B), !, f(B, H).


                /* Conditional plans */

plan(E, H, _, []) :- f(E, H).
plan(E, H, Seen, Plan) :-
    t(E, H, E0, H1), tidy(E0, E1),
    (   H1 == H
    ->  \+ ( member(X, [E|Seen]), X =@= E1 ), plan(E1, H, [E|Seen], Plan)
    ;   H1 = [branch(P)|_]
    ->  (   ( h(know(P), H) ; h(know(neg(P)), H) )
        ->  plan(E1, H, [], Plan)
        ;   Plan = [if(P, P1, P2)], plan(E1, [e(P, true)|H], [], P1), plan(E1, [e(P, false)|H], [], P2)
        )
    ;   H1 = [A|_],
        Plan = [A|Rest],
        after(A, H1, plan(E1), Rest)
    ).

% Next: a closure of History, Seen and Plan.
after(A, H, Next, Rest) :-
    (   senses_something(A), outcomes(A, H, Rs)
    ->  Rest = [case(A, Bs)],
        exclude(absurd(A, H), Rs, Rs1),
        Rs1 \== [],
        maplist(branch_for(A, H, Next), Rs1, Bs)
    ;   call(Next, H, [], Rest)
    ).

branch_for(A, H, Next, R, if(R, Plan)) :- call(Next, [e(A, R)|H], [], Plan).

absurd(A, H, R) :- fluent(F), naive_values(F, [e(A, R)|H], []), !.

reach(P, N, As, H, Plan) :- reach_(P, N, As, H, [], Plan).

reach_(P, N, As, H, _, Plan) :-
    (   h(P, H)
    ->  Plan = []
    ;   N > 0, M is N-1,
        nt:prim_action(A), \+ \+ member(A, As), nt:poss(A, Q), h(Q, H),
        Plan = [A|Rest],
        after(A, [A|H], reach_(P, M, As), Rest)
    ).

planned(searchc(E), H, Plan) :- plan(E, H, [], Plan).
planned(achieve(P, N, As), H, Plan) :- reach(P, N, As, H, Plan).

reached(searchc(E), H) :- f(E, H).
reached(achieve(P, _, _), H) :- \+ \+ h(P, H).

% A plan for G, made after H0, its own actions done where the history had the lengths Own,
% expects to go on after Hx; it is made again after anything but a result it has a branch for.
watched(G, H0, Own, Hx, P, H, E1, H1) :-
    (   H == Hx, P == []
    ->  E1 = [], H1 = H                   % what E does after its last action, in one step
    ;   ( H == Hx ; P = [case(A, Bs)|_], H = [e(A, R)|Hx], memberchk(if(R, _), Bs) )
    ->  t(P, H, P0, H1), tidy(P0, P1),
        ( H1 == H -> Own1 = Own ; length(H1, N), Own1 = [N|Own] ),
        E1 = mon(G, H0, Own1, H1, P1)
    ;   undone(G, H0, Own, H, G1),
        planned(G1, H, P1),
        H1 = H, E1 = mon(G1, H, [], H, P1)
    ).

undone(achieve(P, N, As), _, _, _, achieve(P, N, As)).
undone(searchc(E), H0, Own, H, searchc(E1)) :- undone_(E, H0, Own, H, E1).

undone_(E, H0, _, H, E) :- H == H0, !.
undone_(E, H0, Own, [A|H], E1) :-
    undone_(E, H0, Own, H, E2),
    length([A|H], N),
    ( memberchk(N, Own) -> after_silence(E2, H, [], A, E1) ; E1 = E2 ).

after_silence(E, H, Seen, A, E2) :-
    t(E, H, E0, H1), tidy(E0, E1),
    (   H1 == H
    ->  \+ ( member(X, [E|Seen]), X =@= E1 ), after_silence(E1, H, [E|Seen], A, E2)
    ;   H1 = [A|_], E2 = E1
    ;   H1 = [M|_], ( M = test(_) ; M = branch(_) ), after_silence(E1, H, [], A, E2)
    ).

outcomes(A, H, Rs) :-
    findall(L, some_outcomes(A, H, L), Ls),
    \+ member(open, Ls),
    findall(R, ( member(L, Ls), member(R, L) ), Rs0),
    sort(Rs0, Rs), Rs \== [].

some_outcomes(A, H, L) :- nt:senses(A, F), values_to_see(F, H, L).
some_outcomes(A, H, L) :-
    (   nt:senses(A, R, F, V, _) ; nt:settles(A, R, F, V, _) ; nt:rejects(A, R, F, V, _) ),
    (   ground(R) -> L = [R] ; R == V -> values_to_see(F, H, L) ; L = open ).

values_to_see(F, H, L) :-
    naive_values(F, H, Vs),
    (   Vs \== [none] -> L = Vs ; nt:rel_fluent(F) -> L = [true, false] ; L = open ).


                /* Online */

%!  naive_runs(+Program, +World, +Bound, -Runs) is det.
%
%   Runs are all History-Outcome of Program online.  World is
%   world(Results, Events): the result of each sensing action in turn, and
%   event(N, Action) for what happens after N executed actions.  Outcome is `final`,
%   `failed`, `limit` after Bound actions, or `contradiction`.

naive_runs(E, World, Bound, Runs) :-
    findall(H-O, online(E, [], 0, 0-0, World, Bound, H, O), Runs0),
    sort(Runs0, Runs).

% C counts the entries that the program made, N those that the world executed, K sensings.
online(E, H0, C, N-K, world(Rs, Es0), Bound, H, O) :-
    due(Es0, N, H0, H1, Es),
    (   t(E, H1, _, _)
    ->  t(E, H1, E1, H2),
        (   H2 == H1
        ->  online(E1, H2, C, N-K, world(Rs, Es), Bound, H, O)
        ;   C >= Bound
        ->  H = H1, O = limit
        ;   H2 = [A|_],
            C1 is C+1,
            ( nt:prim_action(A) -> N1 is N+1 ; N1 = N ),
            (   senses_something(A)
            ->  K1 is K+1, nth1(K1, Rs, R0),
                result_for(A, R0, R),
                (   absurd(A, H2, R)
                ->  H = H2, O = contradiction
                ;   online(E1, [e(A, R)|H2], C1, N1-K1, world(Rs, Es), Bound, H, O)
                )
            ;   online(E1, H2, C1, N1-K, world(Rs, Es), Bound, H, O)
            )
        )
    ;   H = H1,
        ( f(E, H1) -> O = final ; O = failed )
    ).

due([event(M, A)|Es], N, H0, H, Rest) :- M =< N, !, due(Es, N, [A|H0], H, Rest).
due(Es, _, H, H, Es).

% The results of a world are numbers; settling actions answer yes or no.
result_for(A, R0, R) :-
    (   nt:settles(A, yes, _, _, _) -> ( R0 > 1 -> R = yes ; R = no )
    ;   nt:senses(A, F), nt:rel_fluent(F) -> ( R0 > 1 -> R = true ; R = false )
    ;   R = R0
    ).
