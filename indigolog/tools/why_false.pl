:- module(indigolog_why_false,
          [ why_false/3,              % +Formula, +Situation, -Why
            whys_false/3,             % +Formulas, +Situation, -Whys
            is_true/2,                % +Formula, +Situation
            most/1                    % -Count
          ]).
/** <module> Why a formula is false */

:- use_module(library(lists), [member/2]).
:- use_module(library(occurs), [sub_term/2]).
:- use_module(library(solution_sequences), [limit/2]).
:- use_module('../language/action', [pick/5]).
:- use_module('../language/formula', [holds_in/2]).
:- use_module('../language/situation').
:- use_module('../language/theory').

%!  most(-Count) is det.
%
%   Most instances and alternatives that are told of: what one reads at a glance, chosen by hand.

most(5).

%!  why_false(+Formula, +Situation, -Why) is semidet.
%
%   Fails if Formula is true.

why_false(P, S, false(P, Parts)) :-
    \+ is_true(P, S),
    parts(P, S, Parts0),
    (   Parts0 = [value(P0, _)],           % a fluent alone: its value is said
        P0 == P
    ->  Parts = []
    ;   Parts = Parts0
    ).

is_true(P, S) :-
    catch(holds_in(P, S), error(_, _), fail),
    !.

whys_false(Ps, S, Whys) :-
    findall(Why, ( member(P, Ps), why_false(P, S, Why) ), Whys).

% parts(+Formula, +Situation, -Parts): why a formula is false that is false.

parts(P, _, Parts), var(P) =>
    Parts = [].
parts(and(P, Q), S, Parts) =>
    first_false([P, Q], S, Parts).
parts((P, Q), S, Parts) =>
    first_false([P, Q], S, Parts).
parts(and(Ps), S, Parts) =>
    first_false(Ps, S, Parts).
parts(or(P, Q), S, Parts) =>
    whys_false([P, Q], S, Parts).
parts(or(Ps), S, Parts) =>
    whys_false(Ps, S, Parts).
parts(neg(P), S, Parts) =>
    Parts = [true(P, Values)],
    once(true_instance(P, S, P1)),
    values(P1, S, Values).
parts(\+ P, S, Parts) =>
    parts(neg(P), S, Parts).
parts(impl(P, Q), S, Parts) =>
    holds_in(P, S),
    !,
    values(P, S, Values),
    why_false(Q, S, Why),
    Parts = [true(P, Values), Why].
parts(some(V, P), S, Parts) =>
    most(Most),
    findall(Why,
            limit(Most, ( pick(V, P, listed, S, P1), why_false(P1, S, Why) )),
            Parts0),
    (   Parts0 == []
    ->  values(P, S, Parts)
    ;   Parts = Parts0
    ).
parts(all(V, P), S, Parts) =>
    (   pick(V, P, listed, S, P1),
        why_false(P1, S, Why)
    ->  Parts = [Why]
    ;   values(P, S, Parts)
    ).
parts(P, S, Parts) =>
    situation_theory(S, Theory),
    theory_module(Theory, Module),
    (   Module:proc(P, Body)
    ->  parts(Body, S, Parts)
    ;   values(P, S, Parts)
    ).

% true_instance(+Formula, +Situation, -Instance): what makes Formula true, with values for what it says there are some of.
true_instance(P, S, P1), situation_module(S, Module), Module:proc(P, Body) =>
    true_instance(Body, S, P1).
true_instance(some(V, P), S, P1) =>
    pick(V, P, listed, S, P0),
    true_instance(P0, S, P1).
true_instance(P, S, P1) =>
    holds_in(P, S),
    P1 = P.

% Of a conjunction the first part that fails, after what the others bind.
first_false([P|Ps], S, Parts) :-
    (   Ps \== [],
        catch(holds_in(P, S), error(_, _), fail)
    ->  first_false(Ps, S, Parts)
    ;   why_false(P, S, Why)
    ->  Parts = [Why]
    ;   Parts = []
    ).

%   values(+Formula, +Situation, -Parts): the values of the fluents in Formula.

values(P, S, Values) :-
    situation_theory(S, Theory),
    findall(F, ( sub_term(F, P), callable(F), fluent_template(Theory, F, _) ), Fluents0),
    sort(Fluents0, Fluents),
    findall(Value, ( member(F, Fluents), value(F, S, Value) ), Values).

value(F, S, value(F, Value)) :-
    (   ground(F)
    ->  (   fluent_value(F, S, Value0)
        ->  Value = Value0
        ;   Value = unknown
        )
    ;   most(Most),
        limit(Most, fluent_value(F, S, Value))
    ).
