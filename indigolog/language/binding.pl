:- module(indigolog_binding,
          [ binder/3,                 % ?Construct, -Variables, -Body
            bound_names/2,            % +Term, -Names
            names_bound_around/2,     % +Constructs, -Names
            bound_variables/2         % +Variables, -List
          ]).
/** <module> Which variables the constructs of programs and formulas bind */

:- use_module(library(lists), [member/2]).
:- use_module(library(occurs), [sub_term/2]).

%!  binder(?Construct, -Variables, -Body) is nondet.
%
%   Construct binds Variables in Body.

binder(pi(V, E), V, E).
binder(pi(V, _, E), V, E).
binder(rpi(V, E), V, E).
binder(rpi(V, _, E), V, E).
binder(interrupt(V, P, E), V, P-E).
binder(some(V, P), V, P).
binder(all(V, P), V, P).

bound_name(V, _) :-
    var(V),
    !,
    fail.
bound_name([V|Vs], Name) :-
    !,
    (   bound_name(V, Name)
    ;   bound_name(Vs, Name)
    ).
bound_name((V, _), Name) :-
    !,
    bound_name(V, Name).
bound_name(r(V), Name) :-
    !,
    bound_name(V, Name).
bound_name(V, V) :-
    V \== [].

%!  bound_variables(+Variables, -List) is det.
%
%   The variables that the first argument of a construct such as pi/2 binds.

bound_variables(V, Vs) :-
    findall(Name, bound_name(V, Name), Vs).

%!  bound_names(+Term, -Names) is det.
%
%   The atoms that some construct in Term binds.

bound_names(Term, Names) :-
    findall(Name, ( sub_term(T, Term), nonvar(T), binds_name(T, Name) ), Names).

%!  names_bound_around(+Constructs, -Names) is det.
%
%   The atoms that Constructs bind in their parts.

names_bound_around(Constructs, Names) :-
    findall(Name, ( member(T, Constructs), binds_name(T, Name) ), Names).

binds_name(T, Name) :-
    binds(T, V),
    bound_name(V, Name).

binds(T, V) :-
    binder(T, V, _).
binds(for(V, _, _), V).
binds(some(V, _, _), V).
binds(all(V, _, _), V).
