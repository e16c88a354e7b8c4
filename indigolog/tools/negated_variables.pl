:- module(indigolog_negated_variables,
          [ negated_variable/3        % +Term, -Variable, -Negation
          ]).
/** <module> Variables that a negation meets before anything has bound them

Negation is by failure: neg(lit(l)), where l has no value yet, asks whether lit(l) is true of no l at all, and
not for an l of which it is false.
*/

:- use_module(library(lists), [member/2]).
:- use_module(library(occurs), [sub_term/2]).
:- use_module('../language/binding', [binder/3, bound_variables/2]).

%!  negated_variable(+Term, -Variable, -Negation) is nondet.
%
%   A construct in Term, a program or a formula, picks a value for Variable, an atom that it gives no domain, and what
%   meets it first is Negation.

negated_variable(Term, V, Negation) :-
    sub_term(T, Term),
    nonvar(T),
    picks(T, Vs, Body),
    member(V, Vs),
    first_use(Body, V, neg(Negation)).

picks(T, Vs, Body) :-
    binder(T, V, Body),
    \+ T = all(_, _),
    \+ ( T = pi(_, _, _) ; T = rpi(_, _, _) ),
    without_domain(V, Vs0),
    bound_variables(Vs0, Vs).

without_domain(V, Vs) :-
    (   is_list(V)
    ->  findall(V0, ( member(V0, V), \+ with_domain(V0) ), Vs)
    ;   with_domain(V)
    ->  Vs = []
    ;   Vs = V
    ).

with_domain(V) :-
    nonvar(V),
    V = (_, _).

% first_use(+Term, +V, -Use): what comes first, from left to right: neg(Negation), or `other` where V is bound, or asked
% of in a way that is not looked into. One for each branch of a choice. Fails where V does not occur.

first_use(T, V, Use), T == V =>
    Use = other.
first_use(T, V, _), \+ ( sub_term(S, T), S == V ) =>
    fail.
first_use(neg(P), _, Use) =>
    Use = neg(neg(P)).
first_use(\+ P, _, Use) =>
    Use = neg(\+ P).
first_use(T, V, Use), branches(T, First, Branches) =>
    (   first_use(First, V, Use0)
    ->  Use = Use0
    ;   member(Branch, Branches),
        first_use(Branch, V, Use)
    ).
first_use(T, V, Use), opaque(T, V) =>
    Use = other.
first_use(T, V, Use) =>
    T =.. [_|Parts],
    member(Part, Parts),
    first_use(Part, V, Use0),
    !,
    Use = Use0.

branches(or(P, Q), [], [P, Q]).
branches(or(Ps), [], Ps) :- is_list(Ps).
branches((P ; Q), [], [P, Q]).
branches(ndet(E, F), [], [E, F]).
branches(wndet(E, F), [], [E, F]).
branches(rndet(E, F), [], [E, F]).
branches(if(P, E, F), P, [E, F]).

% What binds V anew, or asks for all of its values.
opaque(T, V) :-
    binder(T, Vs, _),
    bound_variables(Vs, Names),
    member(Name, Names),
    Name == V.
opaque(forall(_, _), _).
opaque(impl(_, _), _).
opaque(equiv(_, _), _).
opaque(findall(_, _, _), _).
opaque(aggregate_all(_, _, _), _).
