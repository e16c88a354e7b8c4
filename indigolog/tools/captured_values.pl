:- module(indigolog_captured_values,
          [ captured_value/3,         % +Theory, -Reference, -Name
            captured_value/4          % +Theory, +Program, -Where, -Name
          ]).
/** <module> Values that have the name of a variable

Variables are atoms that are replaced where they stand, as published: pi(b, [c], put(N, b)) with
b for N does put(c, c).
*/

:- use_module(library(lists), [append/3, member/2, memberchk/2]).
:- use_module(library(solution_sequences), [limit/2]).
:- use_module('../language/binding', [bound_names/2, names_bound_around/2]).
:- use_module('../language/theory').
:- use_module(formula_parts, [condition/3]).

% Clauses of a helper predicate that are looked through: the facts of a large table are alike.
most_clauses(1000).

%!  captured_value(+Theory, -Reference, -Name) is nondet.
%
%   The clause Reference of Theory has a construct that binds Name, and Name is a value in Theory.

captured_value(Theory, Reference, Name) :-
    theory_module(Theory, Module),
    findall(Ref-Names, binding_clause(Module, _, Ref, Names), Binding),
    names_of(Binding, All),
    theory_values(Theory, All, Values),
    member(Reference-Names, Binding),
    member(Name, Names),
    memberchk(Name, Values).

%!  captured_value(+Theory, +Program, -Where, -Name) is nondet.
%
%   Program binds Name (Where is `program`), or a procedure of Theory does (Where is its head),
%   and the other, or Program itself, has Name as a value.

captured_value(Theory, Program, program, Name) :-
    bound_names(Program, Names0),
    sort(Names0, Names),
    Names \== [],
    values_in(f(Program), Theory, Names, Own),
    theory_values(Theory, Names, Others),
    member(Name, Names),
    ( memberchk(Name, Own) -> true ; memberchk(Name, Others) ).
captured_value(Theory, Program, Head, Name) :-
    theory_module(Theory, Module),
    findall(Head0-Names, binding_clause(Module, proc(Head0, _), _, Names), Binding),
    names_of(Binding, All),
    values_in(f(Program), Theory, All, Own),
    Own \== [],
    theory_values(Theory, Own, Told),     % of the theory
    member(Head-Names, Binding),
    member(Name, Names),
    memberchk(Name, Own),
    \+ memberchk(Name, Told).

binding_clause(Module, Head, Reference, Names) :-
    ( condition(Head, _, Body) ; Head = proc(_, Body) ),
    clause(Module:Head, _, Reference),
    bound_names(Body, Names0),
    sort(Names0, Names),
    Names \== [].

names_of(Binding, All) :-
    findall(Name, ( member(_-Names, Binding), member(Name, Names) ), Names0),
    sort(Names0, All).

% theory_values(+Theory, +Names, -Values): those of Names that Theory has as values.
theory_values(_, [], Values) =>
    Values = [].
theory_values(Theory, Names, Values) =>
    theory_module(Theory, Module),
    findall(Head-Body, clause_of(Module, Head, Body), Clauses),
    values_in(Clauses, Theory, Names, Values).

clause_of(Module, Head, Body) :-
    current_predicate(Module:Name/Arity),
    \+ sub_atom(Name, 0, _, _, $),
    functor(Head, Name, Arity),
    \+ predicate_property(Module:Head, imported_from(_)),
    most_clauses(Most),
    limit(Most, clause(Module:Head, Body)).

% values_in(+Term, +Theory, +Names, -Values): those of Names that are arguments somewhere in Term, outside of what
% binds them, and are no fluents and no programs.
values_in(Term, Theory, Names, Values) :-
    findall(Name, free_argument(Term, [], Names, Name), Found),
    sort(Found, Free),
    findall(Name, ( member(Name, Free), no_other(Theory, Name) ), Values).

no_other(Theory, Name) :-
    \+ fluent_template(Theory, Name, _),
    \+ action_template(Theory, Name, _),
    \+ called_procedure(Theory, Name).

free_argument(Term, Bound0, Names, Name) :-
    compound(Term),
    names_bound_around([Term], Here),
    append(Here, Bound0, Bound),
    arg(_, Term, Argument),
    (   atom(Argument)
    ->  memberchk(Argument, Names),
        \+ memberchk(Argument, Bound),
        Name = Argument
    ;   free_argument(Argument, Bound, Names, Name)
    ).
