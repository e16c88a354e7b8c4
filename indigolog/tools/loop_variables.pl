:- module(indigolog_loop_variables,
          [ kept_variable/3           % +Body, +Clause, -Part
          ]).
/** <module> Variables that a loop binds once for all its rounds

A Prolog variable that only the body of a loop has, and that no construct there binds, keeps
in every round the value of the first.
*/

:- use_module(library(lists), [member/2]).
:- use_module(library(occurs), [occurrences_of_var/3, sub_term/2]).
:- use_module('../language/binding', [binder/3]).

%!  kept_variable(+Body, +Clause, -Part) is nondet.
%
%   Part is the smallest part of a loop of the program Body that binds such a variable;
%   Clause is all that the variables of Body occur in.

kept_variable(Body, Clause, Part) :-
    sub_term(Loop, Body),
    nonvar(Loop),
    loop(Loop),
    binding_parts(Loop, Pairs),
    member(V-Part, Pairs),
    occurrences_of_var(V, Clause, N),
    occurrences_of_var(V, Loop, N),
    \+ ( sub_term(T, Loop), T \== V, nonvar(T), binds(T, V) ).

loop(while(_, _)).
loop(star(_)).
loop(star(_, _)).
loop(iconc(_)).
loop(for(_, _, _)).
loop(interrupt(_, _)).

binds(T, V) :-
    (   binder(T, Vs, _)
    ;   T = some(Vs, _, _)
    ;   T = all(Vs, _, _)
    ;   T = for(Vs, _, _)
    ;   T = interrupt(Vs, _, _)
    ),
    among(V, Vs).

% among(+Variable, +Variables): Variables as they stand in a construct, some with a domain or r(Variable).
among(V, Vs) :-
    (   V == Vs
    ->  true
    ;   nonvar(Vs),
        ( Vs = (V0, _) ; Vs = r(V0) ; Vs = [V0|_] ; Vs = [_|V0] ),
        among(V, V0)
    ->  true
    ).

% binding_parts(+Loop, -Pairs): Variable-Part for each place where Loop may bind a
% variable, Part being the smallest term around it.
binding_parts(Loop, Pairs) :-
    parts(Loop, Loop, Pairs, []).

parts(T, Part, Pairs0, Pairs) :-
    (   var(T)
    ->  Pairs0 = [T-Part|Pairs]
    ;   \+ compound(T)
    ->  Pairs0 = Pairs
    ;   result(T, Result)
    ->  parts(Result, T, Pairs0, Pairs)
    ;   compound_name_arguments(T, _, Args),
        parts_of_each(Args, T, Pairs0, Pairs)
    ).

parts_of_each([], _, Pairs, Pairs).
parts_of_each([A|As], T, Pairs0, Pairs) :-
    parts(A, T, Pairs0, Pairs1),
    parts_of_each(As, T, Pairs1, Pairs).

% result(+Term, -Result): of the arguments of Term only Result binds anything.
result(neg(_), []).
result(\+ _, []).
result(all(_, _), []).
result(all(_, _, _), []).
result(impl(_, _), []).
result(equiv(_, _), []).
result(forall(_, _), []).
result(_^_, []).
result(findall(_, _, L), L).
result(aggregate_all(_, _, R), R).
result(search(E, _), E).
result(Lambda >> _, Free) :-              % of library(yall): it is copied for each call, but for what is Free
    ( nonvar(Lambda), Lambda = Free0/_ -> Free = Free0 ; Free = [] ).
