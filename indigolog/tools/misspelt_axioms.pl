:- module(indigolog_misspelt_axioms,
          [ misspelt_axiom/3          % +Module, -Indicator, -Meant
          ]).
/** <module> Clauses that were meant to be axioms */

:- use_module(library(occurs), [sub_term/2]).
:- use_module('../language/theory', [theory_predicate/1]).

%!  misspelt_axiom(+Module, -Indicator, -Meant) is nondet.
%
%   The theory in Module defines Indicator, which it uses nowhere and which is named nearly as Meant,
%   something that a theory may define.

misspelt_axiom(Module, Name/Arity, Meant/Arity) :-
    current_predicate(Module:Name/Arity),
    \+ theory_predicate(Name/_),
    functor(Head, Name, Arity),
    \+ predicate_property(Module:Head, imported_from(_)),
    theory_predicate(Meant/Arity),
    ( named_elsewhere(Name, Meant) -> true ; dwim_match(Meant, Name) ),
    \+ used(Module, Name/Arity).

% Other Golog interpreters (Levesque et al. 1997, Reiter 2001) read axioms by these names.
named_elsewhere(primitive_action, prim_action).

% Some clause, but for those of Name/Arity itself, speaks of it.
used(Module, Name/Arity) :-
    current_predicate(Module:OtherName/OtherArity),
    OtherName/OtherArity \== Name/Arity,
    functor(Head, OtherName, OtherArity),
    \+ predicate_property(Module:Head, imported_from(_)),
    clause(Module:Head, Body),
    sub_term(T, Head-Body),
    compound(T),
    functor(T, Name, Arity),
    !.
