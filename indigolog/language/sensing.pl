:- module(indigolog_sensing,
          [ sensing_action/1,         % +Action
            sensing_action/2,         % +Theory, +Action
            check_sensing_result/3,   % +Theory, +Action, +Result
            result_effect/4,          % +Action, +Result, +Situation, -Effect
            sensing_results/3,        % +Action, +Situation, -Results
            answers/3                 % +Action, +Situation, -Results
          ]).
/** <module> What sensing actions tell, and may tell */

:- use_module(library(lists), [list_to_set/2, member/2, memberchk/2]).
:- use_module(library(apply), [exclude/3]).
:- use_module(formula, [holds_in/2]).
:- use_module(knowledge, [possible_instance/3]).
:- use_module(situation).
:- use_module(theory).

%!  sensing_action(+Action) is semidet.
%!  sensing_action(+Theory, +Action) is semidet.
%
%   Action has a sensing axiom in Theory, or in the current theory.

sensing_action(Action) :-
    current_theory(Theory),
    sensing_action(Theory, Action).

sensing_action(Theory, Action) :-
    theory_module(Theory, Module),
    (   Module:senses(Action, _)
    ;   result_axiom(_, Module, Action, _, _, _, _)
    ),
    !.

% result_axiom(?Kind, +Module, ?Action, ?Result, ?Fluent, ?Value, -Condition)
result_axiom(senses, Module, A, R, F, V, C) :-
    Module:senses(A, R, F, V, C).
result_axiom(settles, Module, A, R, F, V, C) :-
    Module:settles(A, R, F, V, C).
result_axiom(rejects, Module, A, R, F, V, C) :-
    Module:rejects(A, R, F, V, C).

%!  check_sensing_result(+Theory, +Action, +Result) is det.
%
%   @error golog(not_boolean_result(Action, Fluent, Result)) where it senses a relational fluent and told something else

check_sensing_result(Theory, Action, Result) :-
    theory_module(Theory, Module),
    (   Module:senses(Action, Fluent),
        fluent_template(Theory, Fluent, rel),
        \+ memberchk(Result, [true, false])
    ->  throw(error(golog(not_boolean_result(Action, Fluent, Result)), _))
    ;   true
    ).

%!  result_effect(+Action, +Result, +Situation, -Effect) is nondet.
%
%   Effect, Fluent-Value, of the Result of Action, where Value may stand for several
%   (possible_value/2).
%
%   @error golog(impossible_result(Action, Result, Fluent)) if it rejects every possible
%          value of Fluent

result_effect(A, R, S, F-V) :-
    situation_module(S, Module),
    findall(Sensed, sensed_fluent(Module, A, R, S, Sensed), Fs0),
    list_to_set(Fs0, Fs),
    member(F, Fs),
    sensed_value(F, A, R, Module, S, V).

sensed_fluent(Module, A, R, S, F) :-
    (   Module:senses(A, F)
    ;   result_axiom(_, Module, A, R, F, _, C),
        possible_instance(F, C, S)
    ).

sensed_value(F, A, R, Module, _, V) :-
    Module:senses(A, F),
    !,
    V = R.
sensed_value(F, A, R, Module, S, V) :-
    member(Kind, [senses, settles]),
    result_axiom(Kind, Module, A, R, F, V0, C),
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
    result_axiom(rejects, Module, A, R, F, V, C),
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
    situation_module(S, Module),
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
    result_axiom(_, Module, A, R, F, V, _),
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
