:- module(indigolog_substitution,
          [ substitute/4              % +Variable, +Value, +Term, -NewTerm
          ]).
/** <module> Substitution in programs and formulas

Published theories write the variables of `pi` and `some` as lower-case atoms;
programs written for this interpreter may use Prolog variables.  Both are
replaced the same way.
*/

:- use_module(library(lists), [member/2]).

%!  substitute(+Variable, +Value, +Term, -NewTerm) is det.
%
%   NewTerm is Term with the free occurrences of Variable (an atom or a Prolog
%   variable) replaced by Value.  A construct inside Term that binds the same
%   variable again hides it.

substitute(X, Y, T, R) :-
    (   T == X
    ->  R = Y
    ;   \+ compound(T)
    ->  R = T
    ;   T = [H|L]
    ->  R = [H1|L1],
        substitute(X, Y, H, H1),
        substitute(X, Y, L, L1)
    ;   hides(T, X, Domain, R, Domain1)
    ->  substitute(X, Y, Domain, Domain1)
    ;   compound_name_arguments(T, Name, Args),
        substitute_arguments(Args, X, Y, Args1),
        compound_name_arguments(R, Name, Args1)
    ).

substitute_arguments([], _, _, []).
substitute_arguments([A|As], X, Y, [B|Bs]) :-
    substitute(X, Y, A, B),
    substitute_arguments(As, X, Y, Bs).

% hides(T, X, D, T1, D1): T binds X; T1 is T with its domain D replaced by D1.

hides(pi(V, E),           X, D, pi(W, E), D1)           :- binds(V, X, D, W, D1).
hides(pi(V, D, E),        X, D, pi(V, D1, E), D1)       :- binds(V, X).
hides(rpi(V, E),          X, D, rpi(W, E), D1)          :- binds(V, X, D, W, D1).
hides(rpi(V, D, E),       X, D, rpi(V, D1, E), D1)      :- binds(V, X).
hides(some(V, P),         X, D, some(W, P), D1)         :- binds(V, X, D, W, D1).
hides(all(V, P),          X, D, all(W, P), D1)          :- binds(V, X, D, W, D1).
hides(some(V, D, P),      X, D, some(V, D1, P), D1)     :- binds(V, X).
hides(all(V, D, P),       X, D, all(V, D1, P), D1)      :- binds(V, X).
hides(for(V, D, E),       X, D, for(V, D1, E), D1)      :- binds(V, X).
hides(interrupt(V, P, E), X, D, interrupt(W, P, E), D1) :- binds(V, X, D, W, D1).

binds(V, X, D, W, D1) :-
    binds(V, X),
    domains(V, D, W, D1).

binds(V, X) :-
    (   V == X
    ->  true
    ;   nonvar(V), ( V = r(V0) ; V = (V0, _) )
    ->  binds(V0, X)
    ;   is_list(V)
    ->  member(V0, V), binds(V0, X)
    ).

% domains(+Variables, -D, -W, ?D1): D are the domains in Variables, W is Variables with D1 for them.
domains(V, D, W, D1) :-
    (   nonvar(V), V = [V0|Vs]
    ->  D = [D0|Ds], W = [W0|Ws], D1 = [D2|Ds1],
        domains(V0, D0, W0, D2),
        domains(Vs, Ds, Ws, Ds1)
    ;   nonvar(V), V = (V0, D)
    ->  W = (V0, D1)
    ;   D = [], D1 = [], W = V
    ).
