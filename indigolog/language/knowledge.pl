:- module(indigolog_knowledge,
          [ known/2,                  % +Formula, +Situation
            known_whether/2,          % +Formula, +Situation
            in_all_worlds/2,          % :Goal, +World
            possible_effects/3,       % +Action, +Situation, -Effects
            sensing_results/3,        % +Action, +Situation, -Results
            answers/3                 % +Action, +Situation, -Results
          ]).
:- use_module(library(lists), [append/3, list_to_set/2, member/2]).
:- use_module(library(apply), [exclude/3]).
:- use_module(formula, [holds_in/2, true_in/2]).
:- use_module(situation).
:- use_module(world).
:- use_module(initial).
:- use_module(theory).

:- meta_predicate in_all_worlds(1, +).

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

%!  known(+Formula, +Situation) is nondet.
%
%   Formula is true whatever the values of the fluents are that are not known.  A
%   functional fluent stands for: its value is known.

known(F, S) :-
    fluent_known(F, S, Known),
    !,
    Known == true.
known(P, S) :-
    knowledge_world(S, W),
    catch(in_all_worlds(true_in(P), W), no_value(_), fail).

fluent_known(F, S, Known) :-
    ground(F),
    callable(F),
    situation_theory(S, Theory),
    fluent_template(Theory, F, fun),
    (   fluent_status(F, S, v(_))
    ->  Known = true
    ;   Known = false
    ).

%!  known_whether(+Formula, +Situation) is semidet.
%
%   Formula is known to be true, or known to be false.

known_whether(P, S) :-
    fluent_known(P, S, Known),
    !,
    Known == true.
known_whether(P, S) :-
    (   known(P, S)
    ;   known(neg(P), S)
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

% in_some_worlds(:Goal, +World, -Results): what call(Goal, W, Result) gives first,
% for each world W.
:- meta_predicate in_some_worlds(2, +, -).

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


                /* Effects */

%!  possible_effects(+Action, +Situation, -Effects) is det.
%
%   Effects is a list of Fluent-Value, where Value may stand for several
%   (possible_value/2).
%
%   @error golog(impossible_result(Action, Result, Fluent)) if Action is a sensing
%          result that rejects every possible value of Fluent

possible_effects(e(A, R), S, Effects) =>
    situation_theory(S, Theory),
    theory_module(Theory, Module),
    findall(F, settled_fluent(Module, A, R, S, F), Fs0),
    list_to_set(Fs0, Fs),
    findall(F-V,
            ( member(F, Fs),
              sensed_value(F, A, R, Module, S, V) ),
            Effects).
possible_effects(sim(A), S, Effects) =>
    possible_effects(A, S, Effects).
possible_effects(A, S, Effects) =>
    situation_theory(S, Theory),
    theory_module(Theory, Module),
    findall(F, changed_fluent(Module, A, S, F), Fs0),
    list_to_set(Fs0, Fs),
    findall(F-V,
            ( member(F, Fs),
              in_some_worlds(value_after(F, A, Module), S, Vs),
              possible_value(Vs, V) ),
            Effects).

changed_fluent(Module, A, S, F) :-
    effect_axiom(Module, A, F, _, C),
    ground_instance(F, C, S).

effect_axiom(Module, A, F, V, C) :-
    (   Module:causes_val(A, F, V, C)
    ;   Module:causes_true(A, F, C), V = true
    ;   Module:causes_false(A, F, C), V = false
    ).

% A fluent with open arguments stands for all its declared instances, or, where
% there is no end to those, for those that the condition names.
ground_instance(F, _, _) :-
    ground(F),
    !.
ground_instance(F, C, S) :-
    situation_theory(S, Theory),
    (   \+ \+ declared_instance(Theory, F, open)
    ->  in_some_worlds(named_instances(F, C), S, Lists),
        member(Instances, Lists),
        member(F, Instances)
    ;   declared_instance(Theory, F, ground)
    ).

named_instances(F, C, W, Instances) :-
    findall(F, ( true_in(C, W), ground(F) ), Instances).

value_after(F, A, Module, W, V) :-
    (   effect_axiom(Module, A, F, V0, C),
        true_in(C, W)
    ->  (   ground(V0)
        ->  V = V0
        ;   throw(error(golog(effect_not_ground(A, F, V0)), _))
        )
    ;   value_before(F, W, V)
    ).

value_before(F, W, V) :-
    fluent_status(F, W, Status),
    (   Status = any(Vs)
    ->  throw(several_values(F, Vs))
    ;   Status = v(V)
    ->  true
    ;   V = '$none'
    ).


                /* Sensing */

settled_fluent(Module, A, R, S, F) :-
    (   Module:senses(A, F)
    ;   ( Module:senses(A, R, F, _, C)
        ; Module:settles(A, R, F, _, C)
        ; Module:rejects(A, R, F, _, C)
        ),
        ground_instance(F, C, S)
    ).

sensed_value(F, A, R, Module, _, V) :-
    Module:senses(A, F),
    !,
    V = R.
sensed_value(F, A, R, Module, S, V) :-
    (   Module:senses(A, R, F, V0, C)
    ;   Module:settles(A, R, F, V0, C)
    ),
    holds_in(C, S),
    !,
    V = V0.
sensed_value(F, A, R, Module, S, V) :-
    fluent_status(F, S, Status),
    values_of(Status, Vs0),
    exclude(rejected(F, A, R, Module, S), Vs0, Vs),
    Vs \== Vs0,
    (   Vs == []
    ->  throw(error(golog(impossible_result(A, R, F)), _))
    ;   possible_value(Vs, V)
    ).

rejected(F, A, R, Module, S, V) :-
    Module:rejects(A, R, F, V, C),
    holds_in(C, S),
    !.

values_of(v(V), [V]).
values_of(any(Vs), Vs).

%!  sensing_results(+Action, +Situation, -Results) is semidet.
%
%   The results that Action may have: as sensing/2 lists them, or the values that
%   its axioms name and those that the sensed fluent may have.  Fails if there
%   is no telling.

sensing_results(A, S, Results) :-
    results(A, S, known, Results).

%!  answers(+Action, +Situation, -Results) is semidet.
%
%   The results that may be given for Action, whatever is known: the world may be
%   otherwise.  Fails if there is no telling.

answers(A, S, Results) :-
    results(A, S, any, Results).

results(A, S, How, Results) :-
    situation_theory(S, Theory),
    theory_module(Theory, Module),
    (   Module:sensing(A, Results0)
    ->  true
    ;   findall(Rs, axiom_results(How, Module, A, S, Rs), Lists),
        Lists \== [],
        \+ member(open, Lists),
        findall(R, ( member(Rs, Lists), member(R, Rs) ), Results0)
    ),
    list_to_set(Results0, Results).

axiom_results(How, Module, A, S, Rs) :-
    Module:senses(A, F),
    ground(F),
    values_to_sense(How, F, S, Rs).
axiom_results(How, Module, A, S, Rs) :-
    (   Module:senses(A, R, F, V, _)
    ;   Module:settles(A, R, F, V, _)
    ;   Module:rejects(A, R, F, V, _)
    ),
    (   ground(R)
    ->  Rs = [R]
    ;   R == V, ground(F)
    ->  values_to_sense(How, F, S, Rs)
    ;   Rs = open
    ).

values_to_sense(How, F, S, Rs) :-
    fluent_status(F, S, Status),
    situation_theory(S, Theory),
    (   Status = v(V),
        How == known
    ->  Rs = [V]
    ;   Status = any(Vs)
    ->  Rs = Vs
    ;   fluent_template(Theory, F, rel)
    ->  Rs = [true, false]
    ;   Rs = open
    ).
