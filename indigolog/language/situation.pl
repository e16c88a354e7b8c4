:- module(indigolog_situation,
          [ initial_situation/1,      % -Situation
            initial_situation/2,      % +Theory, -Situation
            after_effects/5,          % +Action, +Situation, +Values, +Open, -Situation1
            with_history/3,           % +History, +Situation, -Situation1
            fluent_status/3,          % +Fluent, +Situation, -Status
            fluent_instance/3,        % ?Fluent, +Situation, -Status
            fluent_value/3,           % ?Fluent, +Situation, -Value
            value_before/3,           % +Fluent, +World, -Value
            known_fluents/2,          % +Situation, -Pairs
            situation_key/2,          % +Situation, -Key
            possible_value/2,         % +Values, -Stored
            knowledge_world/2,        % +Situation, -World
            only_knowledge/1,         % +World
            assumed/4,                % +Fluent, +Value, +World, -World1
            actual_situation/2        % +World, -Situation
          ]).
/** <module> Situations, and the values of fluents in them

A situation is a value (representation.pl): of a theory, values, a history, its length, and
open effects.  Its values (values.pl) map
each ground fluent that some action has set to its value; what is not in it still has its
initial value.  Doing an action makes a new situation that shares nearly everything with
the old one, so that a step costs what the axioms of that action cost, and search may hold
as many situations as it likes.

Open holds effects on infinitely many instances at once (an axiom that sets a
fluent with a free argument, where the declaration leaves it free too).  Those
cannot be progressed: of each action they are kept as open(Effects, Situation), in the order
of their axioms, each open(Fluent, Value, Condition), with the situation that the action was
done in, newest first, and looked up there.

For a fluent that may have any of several values a situation keeps `'$any'(Values)`.  A
world is a situation in which some of these fluents were given one; it remembers the
situation that it is a world of.
*/

:- use_module(representation).
:- reexport(representation,
            [ situation_theory/2, situation_module/2, situation_values/2, situation_history/2,
              situation_length/2, situation_open/2, values_certain/1, same_situation/2, last_action/2 ]).
:- use_module(library(apply), [exclude/3]).
:- use_module(library(lists), [append/3, member/2, memberchk/2]).
:- use_module(formula, [holds_in/2, true_in/2]).
:- use_module(initial).
:- use_module(knowledge, [in_some_worlds/3]).
:- use_module(theory).
:- use_module(values).

%!  initial_situation(-Situation) is det.
%!  initial_situation(+Theory, -Situation) is det.
%
%   The initial situation of Theory, or of the current theory.

initial_situation(Situation) :-
    current_theory(Theory),
    initial_situation(Theory, Situation).

initial_situation(Theory, Situation) :-
    no_values(Empty),
    make_situation(Theory, Empty, [], 0, [], Situation).

%!  after_effects(+Action, +Situation, +Values, +Open, -Situation1) is det.
%
%   Situation1 is do(Action, Situation), given its Values and open effects.

after_effects(Action, S, Values, Open, S1) :-
    make_situation(Theory, _, History, N, _, S),
    N1 is N+1,
    make_situation(Theory, Values, [Action|History], N1, Open, S1).

%!  with_history(+History, +Situation, -Situation1) is det.
%
%   Situation1 is Situation, with an equal list as its history.

with_history(History, S, S1) :-
    make_situation(Theory, Values, _, N, Open, S),
    make_situation(Theory, Values, History, N, Open, S1).


                /* Values */

%!  fluent_status(+Fluent, +Situation, -Status) is det.
%
%   Status of a ground Fluent: v(Value), any(Values) if it may have any of
%   several values, `unknown` or `undeclared`.

fluent_status(Fluent, S, Status) :-
    make_situation(Theory, Values, _, _, Open, S),
    (   stored(Values, Fluent, Value)
    ->  stored_status(Value, Status)
    ;   Open == []
    ->  initial_status(Theory, Fluent, Status)
    ;   open_status(Open, Fluent, Theory, Status)
    ).

stored_status(Value, Status) :-
    (   Value = '$any'(Possible)
    ->  ( Possible == [] -> Status = unknown ; Status = any(Possible) )
    ;   Status = v(Value)
    ).

open_status([], Fluent, Theory, Status) :-
    initial_status(Theory, Fluent, Status).
open_status([open(Effects0, Before)|Older], Fluent, Theory, Status) :-
    copy_term(Effects0, Effects),
    (   \+ member(open(Fluent, _, _), Effects)
    ->  open_status(Older, Fluent, Theory, Status)
    ;   theory_certain(Theory)
    ->  (   member(open(Fluent, Value, Condition), Effects),
            holds_in(Condition, Before)
        ->  Status = v(Value)
        ;   fluent_status(Fluent, Before, Status)
        )
    ;   in_some_worlds(value_set(Effects, Fluent), Before, Values),
        possible_value(Values, Stored),
        stored_status(Stored, Status)
    ).

value_set(Effects, Fluent, World, Value) :-
    (   member(open(Fluent, Value0, Condition), Effects),
        true_in(Condition, World)
    ->  Value = Value0
    ;   value_before(Fluent, World, Value)
    ).

%!  value_before(+Fluent, +World, -Value) is det.
%
%   Value of Fluent, '$none' where it has none.
%
%   @throws several_values(Fluent, Values) if it has several in World

value_before(F, W, V) :-
    fluent_status(F, W, Status),
    (   Status = any(Vs)
    ->  throw(several_values(F, Vs))
    ;   Status = v(V)
    ->  true
    ;   V = '$none'
    ).

%!  fluent_instance(?Fluent, +Situation, -Status) is nondet.
%
%   Enumerate the instances of a partly bound fluent, each with its status: the declared ones,
%   in the order of declaration, or, where the declaration leaves arguments free, those that have a value.

fluent_instance(Fluent, S, Status) :-
    situation_theory(S, Theory),
    declared_instance(Theory, Fluent, Instances),
    (   Instances == ground
    ->  fluent_status(Fluent, S, Status)
    ;   situation_values(S, Values),
        stored_pair(Values, Fluent, _),
        fluent_status(Fluent, S, Status)
    ;   situation_open(S, Open),
        unstored_instance(Open, Fluent, S, Status)
    ).

unstored_instance([], Fluent, S, Status) :-
    situation_theory(S, Theory),
    theory_module(Theory, Module),
    Module:initially(Fluent, Value),
    (   ground(Fluent)
    ->  not_stored(Fluent, S),
        fluent_status(Fluent, S, Status)
    ;   Status = v(Value)
    ).
unstored_instance([open(Effects, Before)|_], Fluent, S, Status) :-
    findall(Fluent-Status0,
            (   effect_instance(Effects, Before, Fluent, Status0)
            ;   fluent_instance(Fluent, Before, Status0)
            ),
            Instances),
    append(Newer, [Fluent-Status1|_], Instances),
    \+ ( member(Newer0-_, Newer), subsumes_term(Newer0, Fluent) ),
    (   ground(Fluent)
    ->  not_stored(Fluent, S),
        fluent_status(Fluent, S, Status)
    ;   Status = Status1
    ).

% What an effect on all instances gives a value, where its condition can tell without being given one.
effect_instance(Effects0, Before, Fluent, v(Value)) :-
    copy_term(Effects0, Effects),
    member(open(Fluent, Value, Condition), Effects),
    catch(holds_in(Condition, Before), error(instantiation_error, _), fail).

not_stored(Fluent, S) :-
    situation_values(S, Values),
    \+ stored(Values, Fluent, _).

%!  fluent_value(?Fluent, +Situation, -Value) is nondet.
%
%   Fluent has Value.  Deterministic for a ground fluent; fails where the value
%   is not known.

fluent_value(Fluent, Situation, Value) :-
    (   ground(Fluent)
    ->  fluent_status(Fluent, Situation, v(Value))
    ;   fluent_instance(Fluent, Situation, v(Value))
    ).

%!  known_fluents(+Situation, -Pairs) is det.
%
%   Fluent-Value for every fluent instance that has a value and is either
%   declared ground, initially given, or has been set.

known_fluents(Situation, Pairs) :-
    situation_theory(Situation, Theory),
    findall(F-V,
            ( fluent_template(Theory, F),
              fluent_value(F, Situation, V) ),
            Pairs0),
    sort(1, @<, Pairs0, Pairs).

%!  situation_key(+Situation, -Key) is det.
%
%   A ground term that is the same for two situations of one theory in which
%   every fluent has the same value.

situation_key(S, Changed-Open) :-
    make_situation(Theory, Values, _, _, Open, S),
    stored_pairs(Values, Pairs),
    exclude(initial_pair(Theory), Pairs, Changed).

initial_pair(Theory, Fluent-Value) :-
    initial_status(Theory, Fluent, v(Value0)),
    Value0 == Value.


                /* Several possible values, and worlds */

%!  possible_value(+Values, -Stored) is det.
%
%   Stored is what a situation keeps for a fluent that may have any of Values.  One
%   that may have no value, '$none', has none that is known.

possible_value(Values, Stored) :-
    (   memberchk('$none', Values)
    ->  Stored = '$any'([])
    ;   Values = [Value]
    ->  Stored = Value
    ;   Stored = '$any'(Values)
    ).

%!  knowledge_world(+Situation, -World) is det.
%
%   World is Situation, where asking for a fluent without a value throws
%   no_value(Fluent).

knowledge_world(S, W) :-
    assumed('$only_knowledge', true, S, W).

only_knowledge(W) :-
    situation_values(W, Values),
    stored(Values, '$only_knowledge', _).

%!  assumed(+Fluent, +Value, +World, -World1) is det.
%
%   World1 is World, except that Fluent has Value there.

assumed(F, V, W, W1) :-
    make_situation(Theory, Values0, History, N, Open, W),
    (   stored(Values0, '$actual', _)
    ->  Values1 = Values0
    ;   store(Values0, '$actual', W, Values1)
    ),
    store(Values1, F, V, Values),
    make_situation(Theory, Values, History, N, Open, W1).

%!  actual_situation(+World, -Situation) is det.
%
%   The situation in which World is one of the possible worlds.

actual_situation(W, S) :-
    situation_values(W, Values),
    (   stored(Values, '$actual', S0)
    ->  S = S0
    ;   S = W
    ).
