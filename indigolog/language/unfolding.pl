:- module(indigolog_unfolding,
          [ unfolded/2                % :Goal, -Unifications
          ]).
/** <module> Calls of accessors, unfolded: what takes a record apart costs no call */

:- meta_predicate unfolded(0, -).

%!  unfolded(:Goal, -Unifications) is semidet.
%
%   Goal calls a predicate of one fact; it is true where Unifications is.

unfolded(Module:Goal, Unifications) :-
    functor(Goal, Name, Arity),
    functor(Fact, Name, Arity),
    predicate_property(Module:Fact, number_of_clauses(1)),
    clause(Module:Fact, true),
    Goal =.. [_|Args],
    Fact =.. [_|Patterns],
    unifications(Args, Patterns, true, Unifications).

unifications([], [], Goal, Goal).
unifications([Arg|Args], [Pattern|Patterns], Goal0, Goal) :-
    (   var(Pattern)
    ->  Arg = Pattern,
        Goal1 = Goal0
    ;   Goal0 == true
    ->  Goal1 = (Arg = Pattern)
    ;   Goal1 = (Goal0, Arg = Pattern)
    ),
    unifications(Args, Patterns, Goal1, Goal).
