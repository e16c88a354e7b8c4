:- module(indigolog_world,
          [ possible_value/2,         % +Values, -Stored
            values_certain/1,         % +Situation
            knowledge_world/2,        % +Situation, -World
            only_knowledge/1,         % +World
            assumed/4,                % +Fluent, +Value, +World, -World1
            actual_situation/2        % +World, -Situation
          ]).
:- use_module(library(lists), [memberchk/2]).
:- use_module(values, [store/4, stored/3]).

/** <module> Situations with several possible values, and the worlds in them

A situation keeps `'$any'(Values)` for a fluent that may have any of several values.
A world is a situation in which some of these fluents were given one; it remembers
the situation that it is a world of.
*/

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

%!  values_certain(+Situation) is semidet.
%
%   The theory leaves no fluent several possible values.

values_certain(s(th(_, _, _, certain), _, _, _, _)).

%!  knowledge_world(+Situation, -World) is det.
%
%   World is Situation, where asking for a fluent without a value throws
%   no_value(Fluent).

knowledge_world(S, W) :-
    assumed('$only_knowledge', true, S, W).

only_knowledge(s(_, Map, _, _, _)) :-
    stored(Map, '$only_knowledge', _).

%!  assumed(+Fluent, +Value, +World, -World1) is det.
%
%   World1 is World, except that Fluent has Value there.

assumed(F, V, W, s(Theory, Map, H, N, Open)) :-
    W = s(Theory, Map0, H, N, Open),
    (   stored(Map0, '$actual', _)
    ->  Map1 = Map0
    ;   store(Map0, '$actual', W, Map1)
    ),
    store(Map1, F, V, Map).

%!  actual_situation(+World, -Situation) is det.
%
%   The situation in which World is one of the possible worlds.

actual_situation(W, S) :-
    W = s(_, Map, _, _, _),
    (   stored(Map, '$actual', S0)
    ->  S = S0
    ;   S = W
    ).
