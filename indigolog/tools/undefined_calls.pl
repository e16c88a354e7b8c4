:- module(indigolog_undefined_calls,
          [ undefined_call/3          % +Theory, -Indicator, -Reference
          ]).
/** <module> Predicates that a theory calls and nothing defines
*/

:- use_module(library(lists), [member/2]).
:- use_module(formula_parts, [goal_exists/2]).
:- use_module('../language/theory', [theory_module/2]).

%!  undefined_call(+Theory, -Indicator, -Reference) is nondet.
%
%   The body of the clause Reference of Theory is the first that calls Indicator, which is not defined.

undefined_call(Theory, Indicator, Reference) :-
    theory_module(Theory, Module),
    findall(Name/Arity-Clause,
            ( clause_of(Module, Body, Clause),
              called(Body, Goal),
              \+ goal_exists(Goal, Theory),
              functor(Goal, Name, Arity) ),
            Calls),
    sort(1, @<, Calls, Firsts),
    member(Indicator-Reference, Firsts).

clause_of(Module, Body, Reference) :-
    current_predicate(Module:Name/Arity),
    functor(Head, Name, Arity),
    \+ predicate_property(Module:Head, imported_from(_)),
    clause(Module:Head, Body, Reference),
    Body \== true,
    clause_property(Reference, file(_)).

% called(+Body, -Goal): Body calls Goal of the theory itself.
called(Body, Goal) :-
    nonvar(Body),
    (   member(Body-Parts, [(A, B)-[A, B], (A ; B)-[A, B], (A -> B)-[A, B], (A *-> B)-[A, B], (\+ A)-[A]])
    ->  member(Part, Parts),
        called(Part, Goal)
    ;   callable(Body),
        Body \= _:_,
        Goal = Body
    ).
