:- module(indigolog_captured_values,
          [ captured_value/4,         % +Theory, -Reference, -Name, -Value
            captured_value/5          % +Theory, +Program, -Where, -Name, -Value
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

%!  captured_value(+Theory, -Reference, -Name, -Value) is nondet.
%
%   The clause Reference of Theory has a construct that binds Name, and Name is a value in its clause Value.

captured_value(Theory, Reference, Name, Value) :-
    theory_module(Theory, Module),
    findall(Ref-Names, binding_clause(Module, _, Ref, Names), Binding),
    names_of(Binding, All),
    theory_values(Theory, All, Values),
    member(Reference-Names, Binding),
    member(Name, Names),
    memberchk(Name-Value, Values).

%!  captured_value(+Theory, +Program, -Where, -Name, -Value) is nondet.
%
%   Program binds Name (Where is `program`), or a procedure of Theory does (Where is its head),
%   and the other, or Program itself, has Name as a value: Value is a clause of Theory, or `program`.

captured_value(Theory, Program, program, Name, Value) :-
    bound_names(Program, Names0),
    sort(Names0, Names),
    Names \== [],
    values_in([program-f(Program)], Theory, Names, Own),
    theory_values(Theory, Names, Others),
    member(Name, Names),
    ( memberchk(Name-Value, Own) -> true ; memberchk(Name-Value, Others) ).
captured_value(Theory, Program, Head, Name, program) :-
    theory_module(Theory, Module),
    findall(Head0-Names, binding_clause(Module, proc(Head0, _), _, Names), Binding),
    names_of(Binding, All),
    values_in([program-f(Program)], Theory, All, Own),
    findall(OwnName, member(OwnName-_, Own), OwnNames),
    theory_values(Theory, OwnNames, Told),
    member(Head-Names, Binding),
    member(Name, Names),
    memberchk(Name, OwnNames),
    \+ memberchk(Name-_, Told).

binding_clause(Module, Head, Reference, Names) :-
    ( condition(Head, _, Body) ; Head = proc(_, Body) ),
    clause(Module:Head, _, Reference),
    bound_names(Body, Names0),
    sort(Names0, Names),
    Names \== [].

names_of(Binding, All) :-
    findall(Name, ( member(_-Names, Binding), member(Name, Names) ), Names0),
    sort(Names0, All).

% theory_values(+Theory, +Names, -Values): those of Names that Theory has as values, Name-Reference with the first clause.
theory_values(_, [], Values) =>
    Values = [].
theory_values(Theory, Names, Values) =>
    theory_module(Theory, Module),
    findall(Reference-(Head-Body), clause_of(Module, Head, Body, Reference), Clauses),
    values_in(Clauses, Theory, Names, Values).

clause_of(Module, Head, Body, Reference) :-
    current_predicate(Module:Name/Arity),
    \+ sub_atom(Name, 0, _, _, $),
    functor(Head, Name, Arity),
    \+ predicate_property(Module:Head, imported_from(_)),
    most_clauses(Most),
    limit(Most, clause(Module:Head, Body, Reference)).

% values_in(+Terms, +Theory, +Names, -Values): Name-Place for those of Names that are arguments somewhere in a Term of the
% Place-Term of Terms, outside of what binds them, and are no fluents and no programs.
values_in(Terms, Theory, Names, Values) :-
    findall(Name-Place, ( member(Place-Term, Terms), free_argument(Term, [], Names, Name) ), Found),
    sort(1, @<, Found, Free),             % of each name the first
    findall(Name-Place, ( member(Name-Place, Free), no_other(Theory, Name) ), Values).

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
