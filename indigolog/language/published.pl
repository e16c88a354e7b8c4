:- module(indigolog_published,
          [ domain/2,                 % ?Value, :Domain
            rdomain/2,                % ?Value, :Domain
            getdomain/2,              % :Domain, -Values
            shuffle/2                 % +List, -Shuffled
          ]).
/** <module> What published theories take for granted

Predicates of the published interpreter that the helper predicates of a theory may call,
and older names of axioms.  A theory inherits them: its own definitions come first.
*/

:- use_module(library(lists), [member/2]).
:- use_module(chance, [shuffled/2]).
:- use_module(theory, [domain_values/3]).

:- meta_predicate
    domain(?, :),
    rdomain(?, :),
    getdomain(:, -).

%!  domain(?Value, :Domain) is nondet.
%!  rdomain(?Value, :Domain) is nondet.
%
%   Value is an element of Domain (theory.pl); rdomain/2 goes through it in random order.

domain(V, D) :-
    getdomain(D, Values),
    member(V, Values).

rdomain(V, D) :-
    getdomain(D, Values),
    shuffled(Values, Shuffled),
    member(V, Shuffled).

%!  getdomain(:Domain, -Values) is det.

getdomain(Module:Domain, Values) :-
    domain_values(Module, Domain, Values).

%!  shuffle(+List, -Shuffled) is det.

shuffle(List, Shuffled) :-
    shuffled(List, Shuffled).
