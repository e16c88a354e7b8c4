:- module(naive,
          [ naive_traces/3            % +Program, +Bound, -Traces
          ]).
:- use_module(library(lists), [append/3, member/2, nth0/3, reverse/2, select/3]).

/** <module> The language straight from its axioms

Regression over the history, sets of steps, nothing remembered.  Slow and plain:
the oracle of the differential tests.  Shares nothing with the interpreter.
*/

:- include(theories/lights).

%!  naive_traces(+Program, +Bound, -Traces) is det.
%
%   All complete executions of at most Bound actions, oldest action first.

naive_traces(E, Bound, Traces) :-
    findall(T, ( run(E, [], [], Bound, H), reverse(H, T) ), Ts),
    sort(Ts, Traces).

% Seen: the configurations since the last action.
run(E, H, _, _, H) :-
    f(E, H).
run(E, H, Seen, Bound, H2) :-
    t(E, H, E0, H1),
    tidy(E0, E1),
    (   H1 == H
    ->  \+ ( member(X, [E|Seen]), X =@= E1 ),
        run(E1, H, [E|Seen], Bound, H2)
    ;   length(H1, N), N =< Bound,
        run(E1, H1, [], Bound, H2)
    ).

% Without empty parts of sequences, so that a loop of tests is seen to repeat.
tidy([E|L], T) :-
    !,
    tidy(E, E1),
    tidy(L, L1),
    (   E1 == [] -> T = L1
    ;   L1 == [] -> T = E1
    ;   L1 = [_|_] -> T = [E1|L1]
    ;   T = [E1, L1]
    ).
tidy(E, E).

% Trans
t([E|L], H, E1, H1) :-
    (   t(E, H, E0, H1), E1 = [E0|L]
    ;   f(E, H), t(L, H, E1, H1)
    ).
t(?(P), H, [], H) :- h(P, H).
t(ndet(E, F), H, E1, H1) :- t(E, H, E1, H1) ; t(F, H, E1, H1).
t(rndet(E, F), H, E1, H1) :- t(ndet(E, F), H, E1, H1).
t(wndet(E, F), H, E1, H1) :-
    ( t(E, H, _, _) -> t(E, H, E1, H1) ; t(F, H, E1, H1) ).
t(if(P, E, F), H, E1, H1) :-
    ( h(P, H), t(E, H, E1, H1) ; \+ h(P, H), t(F, H, E1, H1) ).
t(while(P, E), H, [E1, while(P, E)], H1) :- h(P, H), t(E, H, E1, H1).
t(star(E, N), H, [E1, star(E, M)], H1) :- N > 0, M is N-1, t(E, H, E1, H1).
t(pi((V, D), E), H, E1, H1) :- element(X, D), put_for(V, X, E, E0), t(E0, H, E1, H1).
t(for(V, D, E), H, E1, H1) :- unrolled(V, D, E, L), t(L, H, E1, H1).
t(conc(E, F), H, conc(E1, F), H1) :- t(E, H, E1, H1).
t(conc(E, F), H, conc(E, F1), H1) :- t(F, H, F1, H1).
t(pconc(E, F), H, G, H1) :-
    (   t(E, H, _, _)
    ->  t(E, H, E1, H1), G = pconc(E1, F)
    ;   t(F, H, F1, H1), G = pconc(E, F1)
    ).
t(rconc(Es), H, rconc(Fs), H1) :-
    nth0(I, Es, E, Rest), t(E, H, E1, H1), nth0(I, Fs, E1, Rest).
t(rrobin(Es), H, rrobin(Fs), H1) :-
    select(E, Es, Rest), t(E, H, E1, H1), append(Rest, [E1], Fs).
t(gexec(P, E), H, gexec(P, E1), H1) :- h(P, H), t(E, H, E1, H1).
t(goal(P, E, Q, R), H, E1, H1) :-
    \+ h(P, H),
    (   h(Q, H), t(R, H, E1, H1)
    ;   \+ h(Q, H), t(E, H, E0, H1), E1 = goal(P, E0, Q, R)
    ).
t(prioritized_interrupts(Is), H, E1, H1) :- chain(Is, E), t(E, H, E1, H1).
t(interrupt(P, E), H, [E1, interrupt(P, E)], H1) :-
    \+ member(stop_interrupts, H), h(P, H), t(E, H, E1, H1).
t(stop, H, [], [stop_interrupts|H]).
t(search(E), H, E1, H1) :- t(E, H, E1, H1).      % only asked for whole executions
t(E, H, E1, H1) :- once(proc(E, B)), t(B, H, E1, H1).
t(A, H, [], [B|H]) :-
    callable(A), \+ A = [_|_],
    evaluated(A, H, B), once(prim_action(B)), once(( poss(B, P), h(P, H) )).

% Final
f([], _).
f([E|L], H) :- f(E, H), f(L, H).
f(ndet(E, F), H) :- once(( f(E, H) ; f(F, H) )).
f(rndet(E, F), H) :- f(ndet(E, F), H).
f(wndet(E, F), H) :- f(E, H), f(F, H).
f(if(P, E, F), H) :- ( h(P, H) -> f(E, H) ; f(F, H) ).
f(while(P, E), H) :- ( \+ h(P, H) -> true ; f(E, H) ).
f(star(_, _), _).
f(pi((V, D), E), H) :- once(( element(X, D), put_for(V, X, E, E0), f(E0, H) )).
f(for(V, D, E), H) :- unrolled(V, D, E, L), f(L, H).
f(conc(E, F), H) :- f(E, H), f(F, H).
f(pconc(E, F), H) :- f(E, H), f(F, H).
f(rconc(Es), H) :- f(Es, H).
f(rrobin(Es), H) :- f(Es, H).
f(gexec(P, E), H) :- ( \+ h(P, H) -> true ; f(E, H) ).
f(goal(P, E, _, _), H) :- ( h(P, H) -> true ; f(E, H) ).
f(interrupt(_, _), H) :- memberchk(stop_interrupts, H).
f(search(E), H) :- f(E, H).
f(E, H) :- once(proc(E, B)), f(B, H).

chain([], stop).
chain([I|Is], pconc(I, E)) :- chain(Is, E).

unrolled(V, D, E, L) :-
    findall(E1, ( element(X, D), put_for(V, X, E, E1) ), L).

element(X, D) :- ( D == lamps -> lamps(L) ; L = D ), member(X, L).

put_for(V, X, T, T1) :-
    (   T == V -> T1 = X
    ;   T = pi((W, _), _), W == V -> T1 = T          % bound again: another variable
    ;   T = for(W, _, _), W == V -> T1 = T
    ;   nonvar(T), ( T = some((W, _), _) ; T = all((W, _), _) ), W == V -> T1 = T
    ;   compound(T) -> T =.. [N|As], all_put(As, V, X, Bs), T1 =.. [N|Bs]
    ;   T1 = T
    ).

all_put([], _, _, []).
all_put([A|As], V, X, [B|Bs]) :- put_for(V, X, A, B), all_put(As, V, X, Bs).

% Formulas
h(true, _).
h(and(P, Q), H) :- h(P, H), h(Q, H).
h(or(P, Q), H) :- once(( h(P, H) ; h(Q, H) )).
h(neg(P), H) :- \+ h(P, H).
h(some((V, D), P), H) :- once(( element(X, D), put_for(V, X, P, Q), h(Q, H) )).
h(all((V, D), P), H) :- \+ ( element(X, D), put_for(V, X, P, Q), \+ h(Q, H) ).
h(some(l, P), H) :- once(( lamp(X), put_for(l, X, P, Q), h(Q, H) )).
h(lit(L), H) :- value(lit(L), true, H).
h(counter < N, H) :- value(counter, V, H), V < N.
h(counter = N, H) :- value(counter, N, H).
h(N is counter + K, H) :- value(counter, V, H), N is V+K.
h(all_lit, H) :- proc(all_lit, P), h(P, H).

evaluated(put(K, counter), H, put(K, V)) :- !, value(counter, V, H).
evaluated(A, _, A).

% The value of a fluent, by regression.
value(F, V, H) :- v(F, H, V0), !, V = V0.

v(F, [A|H], V) :- sets(A, F, V, H), !.
v(F, [_|H], V) :- v(F, H, V).
v(F, [], V) :- initially(F, V), !.

sets(A, F, V, H) :- causes_val(A, F, V, P), h(P, H).
sets(A, F, true, H) :- causes_true(A, F, P), h(P, H).
sets(A, F, false, H) :- causes_false(A, F, P), h(P, H).
