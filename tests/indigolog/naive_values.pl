:- module(naive_values,
          [ naive_theory/1,           % +Clauses
            naive_values/3,           % +Fluent, +History, -Values
            h/2,                      % +Formula, +History
            evaluated/3,              % +Action, +History, -Action1
            fluent/1,                 % ?Fluent
            senses_something/1,       % +Action
            picked/3,                 % +Variables, +Term, -Instance
            unrolled/4                % +Variable, +Domain, +Term, -Instances
          ]).
/** <module> Formulas and values straight from the axioms

Values by regression over the history, what is known by going through all worlds.
*/

:- use_module(library(apply), [maplist/3, exclude/3]).
:- use_module(library(lists), [member/2, memberchk/2]).

:- dynamic
    nt:fun_fluent/1, nt:rel_fluent/1, nt:prim_action/1, nt:exog_action/1, nt:poss/2, nt:causes_val/4,
    nt:causes_true/3, nt:causes_false/3, nt:senses/2, nt:senses/5, nt:settles/5, nt:rejects/5,
    nt:initially/2, nt:proc/2, nt:objs/1.

%!  naive_theory(+Clauses) is det.

naive_theory(Clauses) :-
    forall(member(P/N, [fun_fluent/1, rel_fluent/1, prim_action/1, exog_action/1, poss/2, causes_val/4,
                        causes_true/3, causes_false/3, senses/2, senses/5, settles/5, rejects/5,
                        initially/2, proc/2, objs/1]),
           ( functor(Head, P, N), retractall(nt:Head) )),
    forall(member(C, Clauses), assertz(nt:C)).

senses_something(A) :-
    (   nt:senses(A, _) ; nt:senses(A, _, _, _, _) ; nt:settles(A, _, _, _, _) ; nt:rejects(A, _, _, _, _) ), !.

picked(V0, E, E0) :- V0 == [], !, E0 = E.
picked(V0, E, E1) :- nonvar(V0), V0 = [V|Vs], !, picked(V, E, E0), picked(Vs, E0, E1).
picked(V, E, E1) :-
    (   nonvar(V), V = (W0, D)
    ->  ( nonvar(W0), W0 = r(W) -> true ; W = W0 )
    ;   W = V, D = objs
    ),
    element(X, D), put_for(W, X, E, E1).

unrolled(V, D, E, L) :-
    findall(X, element(X, D), Xs),
    unroll(Xs, V, E, L).

unroll([], _, _, []).
unroll([X|Xs], V, E, [E1|L]) :- put_for(V, X, E, E1), unroll(Xs, V, E, L).

element(X, D) :- ( D == objs -> nt:objs(L) ; L = D ), member(X, L).

put_for(V, X, T, T1) :-
    (   T == V -> T1 = X
    ;   var(T) -> T1 = T
    ;   binder(T, W, D, D1, T1), bound_in(V, W)            % bound again: another variable
    ->  put_for(V, X, D, D1)
    ;   T = if(P, E), nonvar(P) -> put_for(V, X, P, P1), put_for(V, X, E, E1), T1 = if(P1, E1)
    ;   compound(T) -> T =.. [N|As], all_put(As, V, X, Bs), T1 =.. [N|Bs]
    ;   T1 = T
    ).

% binder(T, W, D, D1, T1): T binds W; T1 is T with D1 for the domain D.
binder(pi((W, D), E), W, D, D1, pi((W, D1), E)).
binder(pi(W, D, E), W, D, D1, pi(W, D1, E)).
binder(pi(W, E), W, [], [], pi(W, E)).
binder(rpi((W, D), E), W, D, D1, rpi((W, D1), E)).
binder(rpi(W, D, E), W, D, D1, rpi(W, D1, E)).
binder(for(W, D, E), W, D, D1, for(W, D1, E)).
binder(some((W, D), E), W, D, D1, some((W, D1), E)).
binder(all((W, D), E), W, D, D1, all((W, D1), E)).
binder(some(W, E), W, [], [], some(W, E)).
binder(some(W, D, E), W, D, D1, some(W, D1, E)).
binder(all(W, D, E), W, D, D1, all(W, D1, E)).
binder(interrupt((W, D), P, E), W, D, D1, interrupt((W, D1), P, E)).
binder(interrupt(W, P, E), W, [], [], interrupt(W, P, E)).

bound_in(V, W) :- ( W == V -> true ; nonvar(W), W = r(V0), V0 == V ; is_list(W), member((V0, _), W), V0 == V ), !.

all_put([], _, _, []).
all_put([A|As], V, X, [B|Bs]) :- put_for(V, X, A, B), all_put(As, V, X, Bs).


                /* Formulas */

% h(P, H): P is true in every world of H.
h(P, H) :-
    expanded(P, Q),
    findall(F, asked(Q, F), Fs0), sort(Fs0, Fs),
    copy_term(Q, Q1),
    forall(world(Fs, H, W), \+ \+ true_in(Q1, W, H, lax)),
    (   ground(Q) -> true ; world(Fs, H, W), true_in(Q, W, H, lax) ).

known(P, H) :-
    expanded(P, Q),
    findall(F, asked(Q, F), Fs0), sort(Fs0, Fs),
    forall(world(Fs, H, W), catch(true_in(Q, W, H, strict), no_value, fail)).

world([], _, []).
world([F|Fs], H, [F-V|W]) :- naive_values(F, H, Vs), member(V, Vs), world(Fs, H, W).

% Quantifiers and abbreviations written out.
expanded(P, P) :- \+ compound(P), \+ ( atom(P), nt:proc(P, _) ), !.
expanded(some(z, P), Q) :- !, put_for(z, _, P, P1), expanded(once(P1), Q).
expanded(some(V, D, P), Q) :- !, expanded(some((V, D), P), Q).
expanded(all(V, D, P), Q) :- !, expanded(all((V, D), P), Q).
expanded(some(V, P), or(Qs)) :- !, findall(Q, ( picked(V, P, P1), expanded(P1, Q) ), Qs).
expanded(all(V, P), and(Qs)) :- !, findall(Q, ( picked(V, P, P1), expanded(P1, Q) ), Qs).
expanded(P, Q) :- nt:proc(P, B), !, expanded(B, Q).
expanded(P, Q) :- P =.. [N|As], maplist(expanded, As, Bs), Q =.. [N|Bs].

asked(P, _) :- var(P), !, fail.
asked(know(_), _) :- !, fail.
asked(kwhether(_), _) :- !, fail.
asked(done(_), _) :- !, fail.
asked(F, F) :- callable(F), fluent(F), !.
asked(P, F) :- compound(P), arg(_, P, A), asked(A, F).

fluent(F) :- ground(F), ( nt:fun_fluent(F) ; nt:rel_fluent(F) ), !.
fluent(F) :- var(F), ( nt:fun_fluent(F) ; nt:rel_fluent(F) ).

true_in(P, _, _, _) :- P == true, !.
true_in(P, _, _, _) :- P == false, !, fail.
true_in(and(P, Q), W, H, M) :- !, true_in(P, W, H, M), true_in(Q, W, H, M).
true_in(and(Ps), W, H, M) :- !, forall(member(P, Ps), true_in(P, W, H, M)).
true_in(or(P, Q), W, H, M) :- !, ( true_in(P, W, H, M) -> true ; true_in(Q, W, H, M) ).
true_in(or(Ps), W, H, M) :- !, once(( member(P, Ps), true_in(P, W, H, M) )).
true_in(neg(P), W, H, M) :- !, \+ true_in(P, W, H, M).
true_in((P, Q), W, H, M) :- !, true_in(P, W, H, M), true_in(Q, W, H, M).
true_in((P -> Q ; R), W, H, M) :- !, ( true_in(P, W, H, M) -> true_in(Q, W, H, M) ; true_in(R, W, H, M) ).
true_in((P ; Q), W, H, M) :- !, ( true_in(P, W, H, M) ; true_in(Q, W, H, M) ).
true_in(\+ P, W, H, M) :- !, \+ true_in(P, W, H, M).
true_in(once(P), W, H, M) :- !, once(true_in(P, W, H, M)).
true_in(forall(P, Q), W, H, M) :- !, forall(true_in(P, W, H, M), true_in(Q, W, H, M)).
true_in(impl(P, Q), W, H, M) :- !, ( true_in(P, W, H, M) -> true_in(Q, W, H, M) ; true ).
true_in(equiv(P, Q), W, H, M) :- !, ( true_in(P, W, H, M) -> true_in(Q, W, H, M) ; \+ true_in(Q, W, H, M) ).
true_in(know(F), _, H, _) :- callable(F), nt:fun_fluent(F), !, naive_values(F, H, [V]), V \== none.
true_in(kwhether(F), _, H, _) :- callable(F), nt:fun_fluent(F), !, naive_values(F, H, [V]), V \== none.
true_in(know(P), _, H, _) :- !, known(P, H).
true_in(kwhether(P), _, H, _) :- !, ( known(P, H) -> true ; known(neg(P), H) ).
true_in(done(A), _, H, _) :- !, memberchk(A, H).
true_in(X = Y, W, H, M) :- !, term_in(X, W, H, M, A), term_in(Y, W, H, M, A).
true_in(X < Y, W, H, M) :- !, term_in(X, W, H, M, A), term_in(Y, W, H, M, B), A < B.
true_in(X =< Y, W, H, M) :- !, term_in(X, W, H, M, A), term_in(Y, W, H, M, B), A =< B.
true_in(X >= Y, W, H, M) :- !, true_in(Y =< X, W, H, M).
true_in(X =:= Y, W, H, M) :- !, term_in(X, W, H, M, A), term_in(Y, W, H, M, B), A =:= B.
true_in(X =\= Y, W, H, M) :- !, \+ true_in(X =:= Y, W, H, M).
true_in(X is Y, W, H, M) :- !, term_in(Y, W, H, M, B), X is B.
true_in(member(X, L), W, H, M) :- !, term_in(X, W, H, M, A), memberchk(A, L).
true_in(F, W, H, M) :- term_in(F, W, H, M, V), V == true.

term_in(T, _, _, _, T) :- var(T), !.
term_in(T, W, _, M, V) :- member(T0-V0, W), T0 == T, !,
    (   V0 \== none -> V = V0 ; M == strict -> throw(no_value) ; fail ).
term_in(T, W, H, M, V) :- compound(T), !, T =.. [N|As], terms_in(As, W, H, M, Bs), V =.. [N|Bs].
term_in(T, _, _, _, T).

terms_in([], _, _, _, []).
terms_in([A|As], W, H, M, [B|Bs]) :- term_in(A, W, H, M, B), terms_in(As, W, H, M, Bs).

evaluated(A, H, B) :-
    (   compound(A)
    ->  A =.. [N|As], maplist(argument(H), As, Bs), B =.. [N|Bs]
    ;   B = A
    ).

argument(H, A, B) :- ( callable(A), fluent(A) -> naive_values(A, H, [B]), B \== none ; B = A ).


                /* Values, by regression */

%!  naive_values(+Fluent, +History, -Values) is det.
%
%   The values Fluent may have; [none] if it has none, [] if there can be none.

naive_values(F, [], Vs) :- !,
    findall(V, nt:initially(F, V), Vs0),
    (   ( nt:settles(_, _, F, _, _) ; nt:rejects(_, _, F, _, _) ), Vs0 \== []
    ->  sort(Vs0, Vs)
    ;   Vs0 = [V|_] -> Vs = [V]
    ;   Vs = [none]
    ).
naive_values(F, [A|H], Vs) :-
    (   A = set(F) -> Vs = [true]
    ;   A = unset(F) -> Vs = [false]
    ;   A = e(F, V) -> Vs = [V]
    ;   A = e(B, R), senses_something(B) -> after_result(F, B, R, H, Vs)
    ;   ( A = sim(B) -> true ; B = A ),
        findall(C, effect(B, F, _, C), Cs),
        (   Cs == []
        ->  naive_values(F, H, Vs)
        ;   findall(G, ( member(C, Cs), expanded(C, C1), asked(C1, G) ), Gs0),
            sort([F|Gs0], Gs),
            findall(V, ( world(Gs, H, W), after_effect(F, B, W, H, V) ), Vs0),
            (   memberchk(none, Vs0) -> Vs = [none] ; sort(Vs0, Vs) )
        )
    ).

after_effect(F, A, W, H, V) :-
    (   effect(A, F, V0, C), expanded(C, C1), true_in(C1, W, H, lax)
    ->  V = V0
    ;   member(F0-V, W), F0 == F -> true
    ).

effect(A, F, V, C) :- nt:causes_val(A, F, V, C).
effect(A, F, true, C) :- nt:causes_true(A, F, C).
effect(A, F, false, C) :- nt:causes_false(A, F, C).

after_result(F, A, R, _, [R]) :- nt:senses(A, F), !.
after_result(F, A, R, H, [V]) :- ( nt:senses(A, R, F, V, C) ; nt:settles(A, R, F, V, C) ), h(C, H), !.
after_result(F, A, R, H, Vs) :-
    naive_values(F, H, Vs0),
    exclude(taken_away(F, A, R, H), Vs0, Vs).

taken_away(F, A, R, H, V) :- nt:rejects(A, R, F, V, C), h(C, H), !.
