:- module(indigolog_situation,
          [ initial_situation/1,      % -Situation
            initial_situation/2,      % +Theory, -Situation
            history_situation/2,      % +History, -Situation
            remember_situation/1,     % +Situation
            situation_history/2,      % +Situation, -History
            situation_length/2,       % +Situation, -Count
            situation_theory/2,       % +Situation, -Theory
            stop_interrupts/3,        % +Depth, +Situation, -NewSituation
            stopped_depth/2,          % +Situation, -Depth
            progress/3,               % +Action, +Situation, -NewSituation
            progress_plain/3,         % +Action, +Situation, -NewSituation
            fluent_status/3,          % +Fluent, +Situation, -Status
            fluent_instance/2,        % ?Fluent, +Situation
            fluent_value/3,           % ?Fluent, +Situation, -Value
            known_fluents/2,          % +Situation, -Pairs
            situation_key/2,          % +Situation, -Key
            sensing_action/1,         % +Action
            sensing_action/2          % +Theory, +Action
          ]).
:- use_module(library(assoc), [get_assoc/3]).
:- use_module(library(apply), [exclude/3]).
:- use_module(library(lists), [member/2]).
:- use_module(initial).
:- use_module(compiled, [plain_effect/3]).
:- use_module(theory).
:- use_module(values).
:- use_module(formula, [holds_in/2, evaluate/3]).
:- use_module(knowledge, [possible_effects/3]).

/** <module> Situations

A situation is a value: s(Theory, Changed, History, Length, Open).  Changed
maps each ground fluent that some action has set to its value; what is not in
it still has its initial value.  Doing an action makes a new situation that
shares nearly everything with the old one, so that a step costs what the axioms
of that action cost, and search may hold as many situations as it likes.

Open holds effects on infinitely many instances at once (an axiom that sets a
fluent with a free argument, where the declaration leaves it free too).  Those
cannot be progressed: they are kept with the situation they were done in, newest
first, and looked up there.
*/

%!  initial_situation(-Situation) is det.
%
%   The initial situation of the current theory.

initial_situation(Situation) :-
    current_theory(Theory),
    initial_situation(Theory, Situation).

%!  initial_situation(+Theory, -Situation) is det.

initial_situation(Theory, s(Theory, Empty, [], 0, [])) :-
    no_values(Empty).

situation_theory(s(Theory, _, _, _, _), Theory).

%!  situation_history(+Situation, -History) is det.
%
%   The actions done so far, newest first.

situation_history(s(_, _, History, _, _), History).

%!  situation_length(+Situation, -Count) is det.
%
%   The number of entries in the history.

situation_length(s(_, _, _, Count, _), Count).

%!  history_situation(+History, -Situation) is det.
%
%   The situation after History (a list, newest action first).  The last result
%   is remembered, so that stepping through a long history is not quadratic.

history_situation(History, Situation) :-
    current_theory(Theory),
    (   remembered(Theory, Known)
    ->  true
    ;   initial_situation(Theory, Known)
    ),
    reach(History, Known, Theory, Situation),
    remember_situation(Situation).

remembered(Theory, Situation) :-
    nb_current(indigolog_last_situation, Situation),
    Situation = s(Theory0, _, _, _, _),
    Theory0 == Theory.

remember_situation(Situation) :-
    b_setval(indigolog_last_situation, Situation).

reach(History, Known, Theory, Situation) :-
    (   situation_history(Known, Done),
        same_term(Done, History)
    ->  Situation = Known
    ;   History == []
    ->  initial_situation(Theory, Situation)
    ;   History = [A|Earlier]
    ->  reach(Earlier, Known, Theory, Before),
        progress(A, Before, Situation0),
        keep_list(Situation0, History, Situation)
    ;   throw(error(type_error(list, History), _))
    ).

% Keep the caller's own list as the history, so that same_term/2 finds it again.
keep_list(s(T, Map, _, N, Open), History, s(T, Map, History, N, Open)).


                /* Values */

%!  fluent_status(+Fluent, +Situation, -Status) is det.
%
%   Status of a ground Fluent: v(Value), any(Values) if it may have any of
%   several values, `unknown` or `undeclared`.

fluent_status(Fluent, s(Theory, Map, _, _, Open), Status) :-
    (   ( Map = recent(_, _, _) -> stored(Map, Fluent, Value) ; get_assoc(Fluent, Map, Value) )
    ->  (   Value = '$any'(Values)
        ->  ( Values == [] -> Status = unknown ; Status = any(Values) )
        ;   Status = v(Value)
        )
    ;   Open == []
    ->  initial_status(Theory, Fluent, Status)
    ;   open_status(Open, Fluent, Theory, Status)
    ).

open_status([], Fluent, Theory, Status) :-
    initial_status(Theory, Fluent, Status).
open_status([Effect|Effects], Fluent, Theory, Status) :-
    copy_open(Effect, open(Pattern, Value, Condition, Before)),
    (   Pattern = Fluent
    ->  (   holds_in(Condition, Before)
        ->  Status = v(Value)
        ;   fluent_status(Fluent, Before, Status)
        )
    ;   open_status(Effects, Fluent, Theory, Status)
    ).

copy_open(open(P0, V0, C0, Before), open(P, V, C, Before)) :-
    copy_term(P0-V0-C0, P-V-C).

%!  fluent_instance(?Fluent, +Situation) is nondet.
%
%   Enumerate the instances of a partly bound fluent: the declared ones, in the
%   order of declaration, or, where the declaration leaves arguments free, those
%   that have a value.

fluent_instance(Fluent, Situation) :-
    Situation = s(Theory, Map, _, _, _),
    declared_instance(Theory, Fluent, Instances),
    (   Instances == ground
    ->  true
    ;   known_instance(Theory, Map, Fluent)
    ).

known_instance(_, Map, Fluent) :-
    stored_pair(Map, Fluent, _).
known_instance(Theory, Map, Fluent) :-
    theory_module(Theory, Module),
    Module:initially(Fluent, _),
    (   ground(Fluent)
    ->  \+ stored(Map, Fluent, _)
    ;   true
    ).

%!  fluent_value(?Fluent, +Situation, -Value) is nondet.
%
%   Fluent has Value.  Deterministic for a ground fluent; fails where the value
%   is not known.

fluent_value(Fluent, Situation, Value) :-
    (   ground(Fluent)
    ->  fluent_status(Fluent, Situation, v(Value))
    ;   fluent_instance(Fluent, Situation),
        (   ground(Fluent)
        ->  fluent_status(Fluent, Situation, v(Value))
        ;   situation_theory(Situation, Theory),
            theory_module(Theory, Module),
            Module:initially(Fluent, Value)
        )
    ).

%!  known_fluents(+Situation, -Pairs) is det.
%
%   Fluent-Value for every fluent instance that has a value and is either
%   declared ground, initially given, or has been set.

known_fluents(Situation, Pairs) :-
    Situation = s(Theory, _, _, _, _),
    theory_module(Theory, Module),
    findall(F-V,
            ( Module:'$fluent'(F, _),
              fluent_value(F, Situation, V) ),
            Pairs0),
    sort(1, @<, Pairs0, Pairs).

%!  situation_key(+Situation, -Key) is det.
%
%   A ground term that is the same for two situations of one theory in which
%   every fluent has the same value.

situation_key(s(Theory, Map, _, _, Open), Changed-Open) :-
    stored_pairs(Map, Pairs),
    exclude(initial_pair(Theory), Pairs, Changed).

initial_pair(Theory, Fluent-Value) :-
    initial_status(Theory, Fluent, v(Value0)),
    Value0 == Value.


                /* Progression */

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
    theory_module(Theory, Module),
    (   effects_certain(Action, Theory)
    ->  findall(Effect, effect(Action, Module, Situation, Effect), Effects)
    ;   possible_effects(Action, Situation, Effects)
    ),
    progressed(Effects, Action, Situation, New).

%!  progress_plain(+Action, +Situation, -NewSituation) is det.
%
%   As progress/3, for a plain action (compiled.pl).

progress_plain(Action, Situation, New) :-
    findall(Effect, plain_effect(Action, Situation, Effect), Effects),
    progressed(Effects, Action, Situation, New).

progressed(Effects, Action, Situation, New) :-
    Situation = s(Theory, Map, History, N, Open),
    N1 is N+1,
    (   Effects = [F-V|Others],
        Others == [],
        ground(F-V)
    ->  store(Map, F, V, Map1),
        New = s(Theory, Map1, [Action|History], N1, Open)
    ;   apply_effects(Effects, [], Action, Situation, Map, Map1, Open, Open1),
        New = s(Theory, Map1, [Action|History], N1, Open1)
    ).

effects_certain(_, th(_, _, _, certain)) :- !.
effects_certain(set(_), _).
effects_certain(unset(_), _).
effects_certain(e(F, _), Theory) :-
    fluent_template(Theory, F, _).

apply_effects([], _, _, _, Map, Map, Open, Open).
apply_effects([E|Es], Done, Action, Situation, Map0, Map, Open0, Open) :-
    (   E = open(_, _, _)
    ->  push_open(E, Situation, Map0, Map1, Open0, Open1),
        Done1 = Done
    ;   E = F-V,
        (   member(Earlier, Done),
            Earlier == F
        ->  Map1 = Map0
        ;   ground(F-V)
        ->  store(Map0, F, V, Map1)
        ;   throw(error(golog(effect_not_ground(Action, F, V)), _))
        ),
        Open1 = Open0,
        Done1 = [F|Done]
    ),
    apply_effects(Es, Done1, Action, Situation, Map1, Map, Open1, Open).

% What an effect on all instances overwrites must be looked up where it was done.
push_open(open(Pattern, Value, Condition), Situation, Map0, Map, Open,
          [open(Pattern, Value, Condition, Situation)|Open]) :-
    stored_pairs(Map0, Pairs0),
    exclude(matches(Pattern), Pairs0, Pairs),
    values_of_pairs(Pairs, Map).

matches(Pattern, Fluent-_) :-
    \+ Pattern \= Fluent.

%!  stop_interrupts(+Depth, +Situation, -NewSituation) is det.
%
%   NewSituation = do(stop_interrupts, Situation), which remembers how deep in
%   prioritized_interrupts/1 it was done.

stop_interrupts(Depth, s(Theory, Map, H, N, Open),
                s(Theory, Map1, [stop_interrupts|H], N1, Open)) :-
    N1 is N+1,
    store(Map, '$stopped_depth', Depth, Map1).

stopped_depth(s(_, Map, _, _, _), Depth) :-
    stored(Map, '$stopped_depth', Depth).

% effect(+Action, +Module, +Situation, -Effect): Fluent-Value, or
% open(Fluent, Value, Condition) for infinitely many instances.

effect(e(Sensed, Result), Module, S, Effect) =>
    sensing_effect(Sensed, Result, Module, S, Effect).
effect(set(F), _, _, Effect) =>
    Effect = F-true.
effect(unset(F), _, _, Effect) =>
    Effect = F-false.
effect(sim(Action), Module, S, Effect) =>
    effect(Action, Module, S, Effect).
effect(Action, Module, S, Effect) =>
    (   Module:causes_val(Action, F, V, Condition)
    ;   Module:causes_true(Action, F, Condition), V = true
    ;   Module:causes_false(Action, F, Condition), V = false
    ),
    effect_of(F, V, Condition, S, Effect).

sensing_effect(F, V, _, S, Effect) :-
    situation_theory(S, Theory),
    fluent_template(Theory, F, _),
    !,
    Effect = F-V.
sensing_effect(A, Result, Module, S, Effect) :-
    (   Module:senses(A, F),
        Effect = F-Result
    ;   Module:senses(A, Result, F, V, Condition),
        effect_of(F, V, Condition, S, Effect)
    ).

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

%!  sensing_action(+Action) is semidet.
%
%   Action has a sensing axiom in the current theory.

sensing_action(Action) :-
    current_theory(Theory),
    sensing_action(Theory, Action).

sensing_action(Theory, Action) :-
    theory_module(Theory, Module),
    (   Module:senses(Action, _)
    ;   Module:senses(Action, _, _, _, _)
    ;   Module:settles(Action, _, _, _, _)
    ;   Module:rejects(Action, _, _, _, _)
    ),
    !.
