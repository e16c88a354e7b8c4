:- module(random_agents,
          [ random_theory/2,          % +Kind, -Clauses
            random_program/3,         % +Kind, +Depth, -Program
            random_plan/2,            % +Kind, -Program
            random_history/1,         % -History
            random_world/1,           % -World
            write_theory/2            % +File, +Clauses
          ]).
/** <module> Random theories and programs

Fluents: n, m(a), m(b) with small numbers; p(a), p(b), q true or false; in theories of
kind `knowing` u and w, which may have several possible values.  Actions: act(1..3),
tick(X), look (senses), peek (settles or rejects), and the exogenous ev.
*/

:- use_module(library(lists), [append/2, append/3, member/2]).
:- use_module(library(random), [random_between/3, random_member/2]).

%!  random_theory(+Kind, -Clauses) is det.
%
%   Kind is `plain`, where all fluents have values, `sensing`, where m(b) has none until it is
%   sensed, or `knowing`.

random_theory(Kind, Clauses) :-
    findall(C, declaration(C), Declarations),
    findall(C, initial(Kind, C), Initial),
    findall(C, ( member(A, [act(1), act(2), act(3), tick(_)]), precondition(A, C) ), Preconditions),
    findall(C, ( member(A, [act(1), act(2), act(3), tick(_), ev]), between(1, 3, _), effect(Kind, A, C) ), Effects),
    findall(C, knowledge(Kind, C), Knowledge),
    findall(C, procedure(Kind, C), Procedures),
    append([Declarations, Initial, Preconditions, Effects, Knowledge, Procedures], Clauses).

declaration(objs([a, b])).
declaration(fun_fluent(n)).
declaration((fun_fluent(m(X)) :- member(X, [a, b]))).
declaration((rel_fluent(p(X)) :- member(X, [a, b]))).
declaration(rel_fluent(q)).
declaration((prim_action(act(I)) :- member(I, [1, 2, 3]))).
declaration((prim_action(tick(X)) :- member(X, [a, b]))).
declaration(prim_action(look)).
declaration(prim_action(note(_))).
declaration(exog_action(ev)).
declaration(poss(look, true)).
declaration(poss(note(_), true)).
declaration(senses(look, m(b))).

initial(_, initially(n, V)) :- random_between(0, 3, V).
initial(_, initially(m(a), V)) :- random_between(0, 2, V).
initial(plain, initially(m(b), V)) :- random_between(0, 2, V).
initial(_, initially(p(X), V)) :- member(X, [a, b]), random_member(V, [true, false]).
initial(_, initially(q, V)) :- random_member(V, [true, false]).
initial(knowing, initially(u, V)) :- member(V, [0, 1, 2]).
initial(knowing, initially(w, V)) :- random_member(Vs, [[true, false], [true], [false, true]]), member(V, Vs).

precondition(A, poss(A, F)) :-
    random_between(1, 3, R),
    (   R < 3 -> F = true ; formula(plain, 1, F) ).

effect(Kind, A, C) :-
    random_between(1, 8, R),
    effect(R, Kind, A, C).

effect(1, _, A, causes_val(A, n, V, V is (n + K) mod 4)) :- random_between(1, 3, K).
effect(2, Kind, A, causes_val(A, n, V, and(F, V is (n + 1) mod 4))) :- formula(Kind, 0, F).
effect(3, Kind, A, causes_val(A, m(X), V, F)) :-
    argument_of(A, X), random_between(0, 2, V), formula(Kind, 0, F).
effect(4, Kind, A, causes_true(A, p(X), F)) :- argument_of(A, X), formula(Kind, 0, F).
effect(5, Kind, A, causes_false(A, p(X), F)) :- argument_of(A, X), formula(Kind, 0, F).
effect(6, _, A, causes_false(A, p(_), true)).
effect(7, Kind, A, C) :-
    formula(Kind, 0, F),
    random_member(C, [causes_true(A, q, F), causes_false(A, q, F), causes_true(A, q, neg(q))]).
effect(8, Kind, A, C) :-
    (   Kind == knowing
    ->  random_member(C, [causes_val(A, u, V, V is (u + 1) mod 3), causes_val(A, u, 0, q),
                          causes_true(A, w, u = 1), causes_true(A, p(a), w),
                          causes_val(A, m(a), V1, V1 is (u * 2) mod 3), causes_val(A, u, n1, false)])
    ;   C = causes_false(A, q, true)
    ).

argument_of(A, X) :-
    (   A = tick(X) -> true ; random_member(X, [a, b]) ).

knowledge(knowing, C) :-
    random_member(Cs,
                  [ [settles(peek, yes, u, V1, V1 = n), rejects(peek, no, u, V2, V2 = n)],
                    [settles(peek, yes, u, 1, true), rejects(peek, no, u, 1, true)],
                    [settles(peek, yes, w, true, q), settles(peek, no, w, false, q),
                     settles(peek, yes, u, 2, neg(q)), rejects(peek, no, u, 2, neg(q))],
                    [rejects(peek, yes, u, 0, p(a)), settles(peek, yes, w, true, true), rejects(peek, no, w, true, true)] ]),
    member(C, [fun_fluent(u), rel_fluent(w), prim_action(peek), poss(peek, true)|Cs]).
knowledge(sensing, C) :-
    member(C, [prim_action(peek), poss(peek, true), senses(peek, R, n, V, V is R mod 2)]).

procedure(Kind, proc(abbr, F)) :- formula(Kind, 1, F).
procedure(_, proc(about(X), or(p(X), m(X) = 1))).
procedure(_, proc(twice(X), [tick(X), tick(X)])).
procedure(_, proc(rec(0), [])).
procedure(_, (proc(rec(N), [act(1), rec(M)]) :- integer(N), N > 0, M is N - 1)).
procedure(_, proc(again, ndet(twice(b), act(2)))).
procedure(_, proc(either(P, Q), or(P, Q))).
procedure(_, proc(cond(P, E, F), if(P, E, F))).
procedure(_, proc(both(E, F), conc(E, F))).
procedure(_, proc(times(0, _), [])).
procedure(_, (proc(times(N, E), [E, times(M, E)]) :- integer(N), N > 0, M is N - 1)).

% formula(+Kind, +Depth, -Formula)
formula(Kind, 0, F) :-
    !,
    random_between(0, 3, K),
    random_member(X, [a, b]),
    own_formulas(Kind, K, Own),
    append([true, n = K, n < K, m(X) = K, p(X), q, m(a) < n + 1, n = m(a)], Own, Fs),
    random_member(F, Fs).
formula(Kind, _, F) :-
    formula(Kind, 0, P),
    formula(Kind, 0, Q),
    formula(Kind, 0, R),
    random_between(0, 2, K),
    random_member(F, [P, Q, neg(P), and(P, Q), or(P, Q), and([P, Q, R]), or([P, neg(Q), R]), impl(P, Q), equiv(P, Q),
                      some((x, [a, b]), and(p(x), P)), all((x, objs), or(p(x), Q)), some((x, objs), all((x, [b]), m(x) = K)),
                      neg(some([(x, objs), (y, objs)], and(p(x), neg(p(y))))),
                      (P -> Q ; R), (P ; Q), \+ P, forall(P, Q), once(or(P, Q)),
                      some(x, [a, b], and(p(x), P)), all(x, objs, or(p(x), Q)), either(P, Q)]).

own_formulas(plain, K, [p(a), n >= K, m(a) =< K, n =:= m(b), n + m(a) =\= K, f(n, m(a)) = f(K, K), [n, p(a)] = [K, true],
                        p(a) = p(b), some(z, and(z is n + K, m(a) = z))]).
own_formulas(sensing, K, [kwhether(m(b)), know(m(b) = K), m(b) = K, know(m(b))]).
own_formulas(knowing, K, [u = K, w, u < n, know(w), kwhether(u = K), know(u), know(or(u = K, w)), neg(know(neg(w)))]).

test_formula(Kind, F) :-
    formula(Kind, 1, P),
    random_member(F, [P, P, P, abbr, about(a), and(abbr, P), neg(about(b)), done(act(1)), member(n, [0, 2])]).

%!  random_program(+Kind, +Depth, -Program) is det.
%
%   Kind is that of the theory, or online(Kind).

random_program(Kind0, D, P) :-
    (   Kind0 = online(Kind) -> Mode = online ; Kind = Kind0, Mode = offline ),
    random_between(1, 8, R),
    (   R =:= 1
    ->  interrupts(k(Kind, Mode, conc), 2, P)
    ;   program(k(Kind, Mode, alone), D, P)
    ).

%!  random_plan(+Kind, -Program) is det.
%
%   Without loops.

random_plan(Kind, P) :-
    finite(k(Kind, offline, alone), 2, P).

% k(Kind, Mode, Beside): Beside is `conc` where something else may run beside the program.
program(K, 0, P) :-
    !,
    K = k(Kind, _, _),
    random_between(0, 2, N),
    random_member(X, [a, b]),
    (   Kind == plain
    ->  Own = [act(2)]
    ;   Own = [look, peek]
    ),
    append([act(1), act(1), act(2), act(3), tick(X), tick(X), note(n), [], rec(N), twice(X), set(q), unset(p(X)), sim(ev),
            again], Own, Ps),
    random_member(P, Ps).
program(K, D, P) :-
    D1 is D-1,
    K = k(Kind, Mode, Beside),
    (   Beside == alone
    ->  Looking = [search, searching, achieve]
    ;   Looking = []
    ),
    (   Mode == online,
        Kind \== plain
    ->  Sensing = [searchc, case, sense, sense]
    ;   Sensing = []
    ),
    append([ [leaf, seq, seq, seq, test, test, mark, ndet, wndet, rndet, if, if2, while, star, stars, pi, pi2, pi3, pi4, rpi, for,
              conc, conc, pconc, pconc, iconc, rconc2, rconc, rrobin, sync, gexec, goal, abort, atomic, atomic, time, ttime,
              wait, nested, branch, call, call, hiding], Looking, Sensing], Kinds),
    random_member(Construct, Kinds),
    (   construct(Construct, K, D1, P) -> true ; program(K, D1, P) ).

beside(k(Kind, Mode, _), k(Kind, Mode, conc)).

acting(K, D, P) :-                              % begins with an action, so that loops cannot spin
    random_member(A, [act(1), act(2), tick(a), tick(b)]),
    random_between(0, 2, R),
    (   R =:= 0 -> P = A ; program(K, D, Q), P = [A, Q] ).

% finite(+K, +D, -P): without loops, for search.
finite(_, 0, P) :-
    !,
    random_member(P, [act(1), act(2), act(3), tick(a), tick(b), [], again]).
finite(K, D, P) :-
    D1 is D-1,
    K = k(Kind, _, _),
    finite(K, D1, Q), finite(K, D1, R), test_formula(Kind, F),
    random_member(P, [[Q, R], [?(F), Q], [Q, ?(F)], ndet(Q, R), if(F, Q, R), pi((x, objs), [tick(x), Q]), wndet(Q, R), star(Q, 2),
                      conc(Q, R), pconc(Q, R)]).

construct(leaf, K, _, P) :- program(K, 0, P).
construct(seq, K, D, [P, Q]) :- program(K, D, P), program(K, D, Q).
construct(test, k(Kind, M, B), D, [?(F), P]) :- test_formula(Kind, F), program(k(Kind, M, B), D, P).
construct(mark, k(Kind, _, _), _, ??(F)) :- test_formula(Kind, F).
construct(ndet, K, D, ndet(P, Q)) :- program(K, D, P), program(K, D, Q).
construct(wndet, K, D, wndet(P, Q)) :- program(K, D, P), program(K, D, Q).
construct(rndet, K, D, rndet(P, Q)) :- program(K, D, P), program(K, D, Q).
construct(if, K, D, if(F, P, Q)) :- K = k(Kind, _, _), test_formula(Kind, F), program(K, D, P), program(K, D, Q).
construct(if2, K, D, if(F, P)) :- K = k(Kind, _, _), test_formula(Kind, F), program(K, D, P).
construct(while, K, D, while(F, P)) :- K = k(Kind, _, _), test_formula(Kind, F), acting(K, D, P).
construct(star, K, D, star(P, N)) :- random_between(0, 2, N), program(K, D, P).
construct(stars, K, D, star(P)) :- acting(K, D, P).
construct(pi, K, D, pi((x, objs), [tick(x), P])) :- program(K, D, P).
construct(pi2, K, D, pi((r(y), [a, b]), [?(about(y)), P, tick(y)])) :- program(K, D, P).
construct(pi3, K, D, P) :-
    program(K, D, Q),
    random_member(P, [pi(x, objs, [tick(x), Q]), pi([(x, objs), (y, [b, a])], [tick(x), Q, tick(y)]),
                      pi(x, [?(p(x)), tick(x), Q]), pi((x, [a]), pi((x, [b]), [tick(x), Q]))]).
construct(pi4, K, D, pi(X, [?(p(X)), tick(X), P])) :- K = k(Kind, _, _), Kind \== knowing, program(K, D, P).
construct(call, K0, D, P) :-                   % of what is given a program or a formula
    beside(K0, K), program(K, D, Q), program(K, D, R), K = k(Kind, _, _), test_formula(Kind, F),
    random_member(P, [cond(F, Q, R), both(Q, R), times(2, Q), pi((e, [act(1), [act(2), tick(a)], ndet(act(1), [])]), [e, Q, e])]).
construct(hiding, K, D, pi((x, objs), [pi([(y, [a]), (x, [b, a])], [tick(x), Q, tick(y)]), tick(x)])) :- program(K, D, Q).
construct(rpi, K, D, P) :- program(K, D, Q), random_member(P, [rpi((x, objs), [tick(x), Q]), rpi(x, [a, b], [Q, tick(x)])]).
construct(for, K, D, for(x, [a, b], P)) :- program(K, D, Q), random_member(P, [tick(x), if(p(x), tick(x), Q)]).
construct(conc, K0, D, conc(P, Q)) :- beside(K0, K), program(K, D, P), program(K, D, Q).
construct(pconc, K0, D, pconc(P, Q)) :- beside(K0, K), program(K, D, P), program(K, D, Q).
construct(iconc, K0, D, iconc(P)) :- beside(K0, K), acting(K, D, P).
construct(rconc2, K0, D, rconc(P, Q)) :- beside(K0, K), program(K, D, P), program(K, D, Q).
construct(rconc, K0, D, rconc([P, Q, R])) :- beside(K0, K), program(K, D, P), program(K, D, Q), program(K, 0, R).
construct(rrobin, K0, D, rrobin([P, Q])) :- beside(K0, K), program(K, D, P), program(K, D, Q).
construct(sync, K0, D, P) :-
    beside(K0, K), program(K, D, Q), program(K, 0, R), K = k(Kind, _, _), test_formula(Kind, F),
    random_member(P, [sync([Q, Q]), sync([[R, Q], [?(F), R, Q]]), sync([ndet(R, Q), [R, ?(F)]]), ndet(sync([]), Q)]).
construct(gexec, K, D, gexec(F, P)) :- K = k(Kind, _, _), test_formula(Kind, F), program(K, D, P).
construct(goal, K, D, goal(F, P, G, Q)) :-
    K = k(Kind, _, _), test_formula(Kind, F), test_formula(Kind, G), program(K, D, P), program(K, D, Q).
construct(abort, k(_, Mode, _), _, P) :-
    ( Mode == offline -> Ps = [abort] ; Ps = [] ),
    random_member(P, [abort(q), abort(p(a))|Ps]).
construct(atomic, K, D, P) :-
    program(K, D, Q), program(K, 0, R),
    random_member(P, [atomic(Q), conc(atomic([R, Q]), act(1)), pconc([tick(a), tick(b)], atomic([R, Q])),
                      rrobin([atomic([Q, R]), tick(a)])]),
    \+ ( K = k(_, _, alone), \+ P = atomic(_), has_search(Q) ).
construct(time, K, D, time(P, 100)) :- program(K, D, P).
construct(ttime, K, D, ttime(P, 100)) :- program(K, D, P).
construct(wait, k(_, offline, _), _, wait).
construct(nested, k(Kind, M, _), D, [P, Q]) :-
    interrupts(k(Kind, M, conc), 1, P), program(k(Kind, M, conc), D, Q).
construct(branch, k(_, offline, _), _, branch(q)).
construct(search, K, D, search(P)) :- D2 is min(D, 2), finite(K, D2, P).
construct(searching, K, _, search([P, ?(F)], "for something")) :- K = k(Kind, _, _), finite(K, 2, P), test_formula(Kind, F).
construct(achieve, k(Kind, Mode, _), _, achieve(F, 2, [actions(As)])) :-
    formula(Kind, 1, F),
    ( Mode == online, Kind \== plain -> As = [act(1), tick(_), look, peek] ; As = [act(1), act(2), tick(_)] ).
construct(searchc, k(Kind, _, alone), _, searchc([A, P, Q])) :-
    random_member(A, [look, peek]),
    finite(k(Kind, online, alone), 1, P),
    finite(k(Kind, online, alone), 1, R), test_formula(Kind, F),
    random_member(Q, [R, if(F, R, act(1)), [branch(q), if(q, R, [])], [peek, R]]).
construct(case, K, D, [peek, case(peek, [if(B, P), if(C, Q)])]) :-
    K = k(Kind, _, _),
    ( Kind == sensing -> B = 0, C = 2 ; B = yes, C = no ),
    program(K, D, P), program(K, D, Q).
construct(sense, K, D, [A, if(F, P, Q)]) :-
    K = k(Kind, _, _), random_member(A, [look, peek]), test_formula(Kind, F), program(K, D, P), program(K, D, Q).

has_search(P) :-
    ( P = search(_) ; P = search(_, _) ; P = searchc(_) ; P = achieve(_, _, _) ), !.
has_search(P) :-
    compound(P), arg(_, P, A), nonvar(A), has_search(A), !.

interrupts(K, D, prioritized_interrupts(Is)) :-
    random_between(1, 3, N),
    findall(I, ( between(1, N, _), interrupt(K, D, I) ), Is).

interrupt(K, D, I) :-
    K = k(Kind, _, _),
    test_formula(Kind, F),
    D1 is max(0, D-1),
    acting(K, D1, P),
    random_member(I, [interrupt(F, P), interrupt(F, P), interrupt((x, objs), and(F, p(x)), [tick(x), P]),
                      interrupt(F, [act(1), prioritized_interrupts([interrupt(q, [unset(q), P])]), P])]).

%!  random_history(-History) is det.

random_history(H) :-
    random_between(0, 4, N),
    findall(A, ( between(1, N, _), random_member(A, [act(1), act(2), act(3), tick(a), tick(b), ev]) ), H).

%!  random_world(-World) is det.

random_world(world(Results, Events)) :-
    findall(R, ( between(1, 12, _), random_between(0, 2, R) ), Results),
    random_between(0, 2, N),
    findall(T, ( between(1, N, _), random_between(0, 4, T) ), Ts0),
    msort(Ts0, Ts),
    findall(event(T, ev), member(T, Ts), Events).

%!  write_theory(+File, +Clauses) is det.

write_theory(File, Clauses) :-
    setup_call_cleanup(
        open(File, write, Out),
        forall(member(C, Clauses), portray_clause(Out, C)),
        close(Out)).
