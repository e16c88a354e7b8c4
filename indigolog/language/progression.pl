:- module(indigolog_progression,
          [ progress/3,               % +Action, +Situation, -NewSituation
            progress_plain/3,         % +Action, +Situation, -NewSituation
            effect_of/5,              % +Fluent, +Value, +Condition, +Situation, -Effect
            stop_interrupts/3,        % +Depth, +Situation, -NewSituation
            stopped_depth/2           % +Situation, -Depth
          ]).
/** <module> What actions do to situations */

:- use_module(library(apply), [exclude/3, foldl/4]).
:- use_module(library(lists), [list_to_set/2, member/2, nth1/3, same_length/2]).
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
    ;   apply_effects(Effects, Action, Situation, Values0, Values, Open0, Open)
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

% apply_effects(+Effects, +Action, +Situation, +Values0, -Values, +Open0, -Open): of the effects on an
% instance, in the order of their axioms, the first counts. What those on all instances overwrite is
% looked up in Situation.

apply_effects(Effects, Action, Situation, Values0, Values, Open0, Open) :-
    uncovered_effects(Effects, [], Action, Situation, Pairs, Opens),
    first_of_each(Pairs, Firsts),
    (   Opens == []
    ->  Open = Open0,
        Values1 = Values0
    ;   Open = [open(Opens, Situation)|Open0],
        stored_pairs(Values0, Pairs0),
        exclude(covered(Opens), Pairs0, Kept),
        values_of_pairs(Kept, Values1)
    ),
    foldl(store_pair, Firsts, Values1, Values).

% uncovered_effects(+Effects, +Before, +Action, +Situation, -Pairs, -Opens): Before are those on all instances that come
% before Effects.
uncovered_effects([], _, _, _, [], []).
uncovered_effects([E|Es], Before, Action, Situation, Pairs, Opens) :-
    (   E = open(_, _, _)
    ->  Opens = [E|Opens1],
        uncovered_effects(Es, [E|Before], Action, Situation, Pairs, Opens1)
    ;   E = F-V,
        ( ground(F-V) -> true ; throw(error(golog(effect_not_ground(Action, F, V)), _)) ),
        (   member(Open, Before),
            sets(Open, F, Situation)
        ->  Pairs = Pairs1
        ;   Pairs = [E|Pairs1]
        ),
        uncovered_effects(Es, Before, Action, Situation, Pairs1, Opens)
    ).

sets(open(Pattern, _, Condition), F, Situation) :-
    \+ \+ ( Pattern = F, holds_in(Condition, Situation) ).

% first_of_each(+Pairs, -Firsts): of those with one key the first, in the order of Pairs.
first_of_each(Pairs, Firsts) :-
    sort(1, @<, Pairs, Sorted),
    (   same_length(Sorted, Pairs)
    ->  Firsts = Pairs
    ;   findall(t(F, N, V), nth1(N, Pairs, F-V), Numbered),
        sort(1, @<, Numbered, Unique),
        sort(2, @<, Unique, Ordered),
        findall(F-V, member(t(F, _, V), Ordered), Firsts)
    ).

covered(Opens, Fluent-_) :-
    member(open(Pattern, _, _), Opens),
    \+ Pattern \= Fluent,
    !.

store_pair(F-V, Values0, Values) :-
    store(Values0, F, V, Values).


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
%   Effect of an axiom that sets Fluent to Value if Condition holds: Fluent-Value for each instance that
%   the declarations, or a list in Condition, name, or one on all instances.

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
        ;   listed(F, Condition, S)
        ->  holds_in(Condition, S),
            Effect = F-V
        ;   Effect = open(F, V, Condition)
        )
    ).

% Condition begins with member(Element, List), whose elements say which instances are meant.
listed(F, Condition, S) :-
    first_part(Condition, First),
    nonvar(First),
    First = member(Element, List),
    term_variables(F, Vs),
    term_variables(Element, Named),
    \+ ( member(V, Vs), \+ ( member(N, Named), N == V ) ),
    \+ \+ ( evaluate(List, S, Elements), ground(Elements), is_list(Elements) ).

first_part(Condition, First) :-
    (   Condition = and(First, _)
    ->  true
    ;   Condition = and([First|_])
    ->  true
    ;   First = Condition
    ).

% A condition that begins with Variable = Value says which instance is meant.
bind_equalities(Condition, S) :-
    first_part(Condition, First),
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
    (   result_effect(A, R, S, Effect)
    ;   Effect = open(F, V, know(C)),
        situation_module(S, Module),
        Module:senses(A, R, F, V, C),
        \+ ground(F),
        effect_of(F, V, C, S, open(_, _, _))
    ).
possible_effect(sim(A), S, Effect) =>
    possible_effect(A, S, Effect).
possible_effect(A, S, Effect) =>
    situation_module(S, Module),
    findall(F, ( effect_axiom(Module, A, F, _, C), possible_instance(F, C, S) ), Fs0),
    list_to_set(Fs0, Fs),
    (   Effect = F-V,
        member(F, Fs),
        in_some_worlds(value_after(F, A), S, Vs),
        possible_value(Vs, V)
    ;   Effect = open(_, _, _),
        effect_axiom(Module, A, F, V, C),
        \+ ground(F),
        effect_of(F, V, C, S, Effect)
    ).

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
