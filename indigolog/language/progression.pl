:- module(indigolog_progression,
          [ progress/3,               % +Action, +Situation, -NewSituation
            progress_plain/3,         % +Action, +Situation, -NewSituation
            effect_of/5,              % +Fluent, +Value, +Condition, +Situation, -Effect
            stop_interrupts/3,        % +Depth, +Situation, -NewSituation
            stopped_depth/2,          % +Situation, -Depth
            history_situation/2,      % +History, -Situation
            remember_situation/1      % +Situation
          ]).
/** <module> What actions do to situations */

:- use_module(library(apply), [exclude/3]).
:- use_module(library(error), [instantiation_error/1]).
:- use_module(library(lists), [list_to_set/2, member/2]).
:- use_module(formula, [evaluate/3, holds_in/2, true_in/2]).
:- use_module(initial, [declared_instance/3]).
:- use_module(knowledge, [in_some_worlds/3, possible_instance/3]).
:- use_module(sensing, [result_effect/4]).
:- use_module(situation).
:- use_module(theory).
:- use_module(values, [store/4, stored/3, stored_pairs/2, values_of_pairs/2]).

%!  progress(+Action, +Situation, -NewSituation) is det.
%
%   NewSituation = do(Action, Situation).  Of several axioms that would set the
%   same fluent the first one counts: causes_val/4, then causes_true/3, then
%   causes_false/3.
%
%   @error golog(effect_not_ground(Action, Fluent, Value)) if an axiom leaves a
%          value open

progress(Action, Situation, New) :-
    situation_theory(Situation, Theory),
    (   effects_certain(Action, Theory)
    ->  findall(Effect, effect(Action, Situation, Effect), Effects)
    ;   findall(Effect, possible_effect(Action, Situation, Effect), Effects)
    ),
    progressed(Effects, Action, Situation, New).

%!  progress_plain(+Action, +Situation, -NewSituation) is det.
%
%   As progress/3, for a plain action (compiled.pl).

progress_plain(Action, Situation, New) :-
    situation_module(Situation, Module),
    findall(Effect,
            (   Module:'$sets_value'(Action, Situation, Effect)
            ;   Module:'$sets_true'(Action, Situation, Effect)
            ;   Module:'$sets_false'(Action, Situation, Effect)
            ),
            Effects),
    progressed(Effects, Action, Situation, New).

progressed(Effects, Action, Situation, New) :-
    situation_values(Situation, Values0),
    situation_open(Situation, Open0),
    (   Effects = [F-V|Others],
        Others == [],
        ground(F-V)
    ->  store(Values0, F, V, Values),
        Open = Open0
    ;   apply_effects(Effects, [], Action, Situation, Values0, Values, Open0, Open)
    ),
    after_effects(Action, Situation, Values, Open, New).

effects_certain(_, Theory) :-
    theory_certain(Theory),
    !.
effects_certain(Action, Theory) :-
    assignment(Action, Theory),
    !.
effects_certain(e(F, _), Theory) :-
    fluent_template(Theory, F, _).

apply_effects([], _, _, _, Values, Values, Open, Open).
apply_effects([E|Es], Done, Action, Situation, Values0, Values, Open0, Open) :-
    (   E = open(_, _, _)
    ->  push_open(E, Situation, Values0, Values1, Open0, Open1),
        Done1 = Done
    ;   E = F-V,
        (   member(Earlier, Done),
            Earlier == F
        ->  Values1 = Values0
        ;   ground(F-V)
        ->  store(Values0, F, V, Values1)
        ;   throw(error(golog(effect_not_ground(Action, F, V)), _))
        ),
        Open1 = Open0,
        Done1 = [F|Done]
    ),
    apply_effects(Es, Done1, Action, Situation, Values1, Values, Open1, Open).

% What an effect on all instances overwrites must be looked up where it was done.
push_open(open(Pattern, Value, Condition), Situation, Values0, Values, Open,
          [open(Pattern, Value, Condition, Situation)|Open]) :-
    stored_pairs(Values0, Pairs0),
    exclude(matches(Pattern), Pairs0, Pairs),
    values_of_pairs(Pairs, Values).

matches(Pattern, Fluent-_) :-
    \+ Pattern \= Fluent.


                /* Effects */

% effect(+Action, +Situation, -Effect): Fluent-Value, or open(Fluent, Value, Condition)
% for infinitely many instances.

effect(e(Sensed, Result), S, Effect) =>
    sensing_effect(Sensed, Result, S, Effect).
effect(Action, S, Effect), situation_theory(S, Theory), assignment(Action, Theory) =>
    assigned(Action, Effect).
effect(sim(Action), S, Effect) =>
    effect(Action, S, Effect).
effect(Action, S, Effect) =>
    situation_module(S, Module),
    effect_axiom(Module, Action, F, V, Condition),
    effect_of(F, V, Condition, S, Effect).

assigned(set(F), F-true).
assigned(unset(F), F-false).

effect_axiom(Module, A, F, V, Condition) :-
    (   Module:causes_val(A, F, V, Condition)
    ;   Module:causes_true(A, F, Condition), V = true
    ;   Module:causes_false(A, F, Condition), V = false
    ).

sensing_effect(F, V, S, Effect) :-
    situation_theory(S, Theory),
    fluent_template(Theory, F, _),
    !,
    Effect = F-V.
sensing_effect(A, Result, S, Effect) :-
    situation_module(S, Module),
    (   Module:senses(A, F),
        Effect = F-Result
    ;   Module:senses(A, Result, F, V, Condition),
        effect_of(F, V, Condition, S, Effect)
    ).

%!  effect_of(+Fluent, +Value, +Condition, +Situation, -Effect) is nondet.
%
%   Effect of an axiom that sets Fluent to Value if Condition holds.

effect_of(F, V, Condition, S, Effect) :-
    (   ground(F)
    ->  (   Condition == true
        ->  true
        ;   holds_in(Condition, S)
        ->  true
        ),
        Effect = F-V
    ;   bind_equalities(Condition, S),
        instance_effect(F, V, Condition, S, Effect)
    ).

instance_effect(F, V, Condition, S, Effect) :-
    (   ground(F)
    ->  once(holds_in(Condition, S)),
        Effect = F-V
    ;   situation_theory(S, Theory),
        declared_instance(Theory, F, Instances),
        (   Instances == ground
        ->  once(holds_in(Condition, S)),
            Effect = F-V
        ;   Effect = open(F, V, Condition)
        )
    ).

% A condition that begins with Variable = Value says which instance is meant.
bind_equalities(Condition, S) :-
    (   Condition = and(First, _)
    ->  true
    ;   First = Condition
    ),
    (   nonvar(First),
        First = (X = Y),
        (   var(X), ground(Y)
        ->  evaluate(Y, S, X)
        ;   var(Y), ground(X)
        ->  evaluate(X, S, Y)
        )
    ->  true
    ;   true
    ).

% possible_effect(+Action, +Situation, -Effect): Fluent-Value, where Value may stand for
% several (possible_value/2): what the action leads to from some world.

possible_effect(e(A, R), S, Effect) =>
    result_effect(A, R, S, Effect).
possible_effect(sim(A), S, Effect) =>
    possible_effect(A, S, Effect).
possible_effect(A, S, Effect) =>
    situation_module(S, Module),
    findall(F, ( effect_axiom(Module, A, F, _, C), possible_instance(F, C, S) ), Fs0),
    list_to_set(Fs0, Fs),
    Effect = F-V,
    member(F, Fs),
    in_some_worlds(value_after(F, A), S, Vs),
    possible_value(Vs, V).

value_after(F, A, W, V) :-
    situation_module(W, Module),
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


                /* Interrupts that stop */

%!  stop_interrupts(+Depth, +Situation, -NewSituation) is det.
%
%   NewSituation = do(stop_interrupts, Situation), which remembers how deep in
%   prioritized_interrupts/1 it was done.

stop_interrupts(Depth, Situation, New) :-
    situation_values(Situation, Values0),
    situation_open(Situation, Open),
    store(Values0, '$stopped_depth', Depth, Values),
    after_effects(stop_interrupts, Situation, Values, Open, New).

stopped_depth(Situation, Depth) :-
    situation_values(Situation, Values),
    stored(Values, '$stopped_depth', Depth).


                /* Histories */

%!  history_situation(+History, -Situation) is det.
%
%   The situation after History (a list, newest action first).  The last result
%   is remembered, so that stepping through a long history is not quadratic.
%
%   @error golog(unknown_entry(Action)), golog(open_action(Action)) if one of them is not
%          an action of the theory, or has variables in it

history_situation(History, Situation) :-
    current_theory(Theory),
    (   nb_current(indigolog_last_situation, Known0),
        situation_theory(Known0, Theory0),
        Theory0 == Theory
    ->  Known = Known0
    ;   initial_situation(Theory, Known)
    ),
    reach(History, Known, Theory, Situation),
    remember_situation(Situation).

remember_situation(Situation) :-
    b_setval(indigolog_last_situation, Situation).

% The caller's own list is kept as the history, so that same_term/2 finds it again.
reach(History, Known, Theory, Situation) :-
    (   situation_history(Known, Done),
        same_term(Done, History)
    ->  Situation = Known
    ;   var(History)
    ->  instantiation_error(History)
    ;   History == []
    ->  initial_situation(Theory, Situation)
    ;   History = [A|Earlier]
    ->  known_entry(A, Theory),
        reach(Earlier, Known, Theory, Before),
        progress(A, Before, Situation0),
        with_history(History, Situation0, Situation)
    ;   throw(error(type_error(list, History), _))
    ).

known_entry(A, Theory) :-
    (   nonvar(A),
        ( history_mark(A) ; A == wait ; A == abort ; assignment(A, Theory) )
    ->  true
    ;   callable(A),
        action_template(Theory, A, _)
    ->  ( ground(A) -> true ; throw(error(golog(open_action(A)), _)) )
    ;   throw(error(golog(unknown_entry(A)), _))
    ).
