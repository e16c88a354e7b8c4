:- module(indigolog_knowledge,
          [ known/2,                  % +Formula, +Situation
            known_whether/2,          % +Formula, +Situation
            in_all_worlds/2,          % :Goal, +World
            in_some_worlds/3,         % :Goal, +World, -Results
            possible_instance/3       % ?Fluent, +Condition, +Situation
          ]).
/** <module> Knowledge as possible values

A fluent that settles/5 or rejects/5 speaks of has several possible values: all
its initial ones, until a sensing result settles it or rejects some.  A world
gives one of them to each such fluent; what is known is what is true in all
worlds (Vassos and Levesque 2005; Scherl and Levesque 2003).  The possible values
after an action are those that the action leads to from some world: which values
occur together is not remembered.

Worlds are made where they are needed: a formula is first evaluated as if every
fluent had one value, and the fluent that has not is then given each of its
values in turn.
*/

:- use_module(library(lists), [append/3, list_to_set/2, member/2]).
:- use_module(formula, [true_in/2]).
:- use_module(initial, [declared_instance/3]).
:- use_module(situation).
:- use_module(theory).

:- meta_predicate
    in_all_worlds(1, +),
    in_some_worlds(2, +, -).

%!  known(+Formula, +Situation) is nondet.
%
%   Formula is true whatever the values of the fluents are that are not known.  A
%   functional fluent stands for: its value is known.

known(F, S) :-
    functional(F, S),
    !,
    fluent_status(F, S, v(_)).
known(P, S) :-
    knowledge_world(S, W),
    catch(in_all_worlds(true_in(P), W), no_value(_), fail).

functional(F, S) :-
    ground(F),
    callable(F),
    situation_theory(S, Theory),
    fluent_template(Theory, F, fun).

%!  known_whether(+Formula, +Situation) is semidet.
%
%   Formula is known to be true, or known to be false.

known_whether(P, S) :-
    (   known(P, S)
    ;   \+ functional(P, S),
        known(neg(P), S)
    ),
    !.

%!  in_all_worlds(:Goal, +World) is nondet.
%
%   call(Goal, W) is true, with the same bindings, in each world W that gives one
%   of its values to every fluent that Goal depends on.

in_all_worlds(Goal, W) :-
    catch(( call(Goal, W),
            Split = none ),
          several_values(F, Vs),
          Split = split(F, Vs)),
    (   Split = split(F, Vs)
    ->  in_each(Vs, F, Goal, W)
    ;   true
    ).

in_each([], _, _, _).
in_each([V|Vs], F, Goal, W) :-
    assumed(F, V, W, W1),
    in_all_worlds(Goal, W1),
    in_each(Vs, F, Goal, W).

%!  in_some_worlds(:Goal, +World, -Results) is det.
%
%   What call(Goal, W, Result) gives first, for each world W.

in_some_worlds(Goal, W, Results) :-
    catch(( call(Goal, W, Result)
          ->  Outcome = [Result]
          ;   Outcome = []
          ),
          several_values(F, Vs),
          Outcome = split(F, Vs)),
    (   Outcome = split(F, Vs)
    ->  results_of_each(Vs, F, Goal, W, Results0),
        list_to_set(Results0, Results)
    ;   Results = Outcome
    ).

results_of_each([], _, _, _, []).
results_of_each([V|Vs], F, Goal, W, Results) :-
    assumed(F, V, W, W1),
    in_some_worlds(Goal, W1, Here),
    append(Here, More, Results),
    results_of_each(Vs, F, Goal, W, More).

%!  possible_instance(?Fluent, +Condition, +Situation) is nondet.
%
%   Fluent is ground: with open arguments it stands for all its declared instances, or,
%   where there is no end to those, for those that Condition names in some world.

possible_instance(F, _, _) :-
    ground(F),
    !.
possible_instance(F, C, S) :-
    situation_theory(S, Theory),
    (   \+ \+ declared_instance(Theory, F, open)
    ->  in_some_worlds(named_instances(F, C), S, Lists),
        member(Instances, Lists),
        member(F, Instances)
    ;   declared_instance(Theory, F, ground)
    ).

named_instances(F, C, W, Instances) :-
    findall(F, ( true_in(C, W), ground(F) ), Instances).
