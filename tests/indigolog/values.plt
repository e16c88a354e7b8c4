:- module(test_indigolog_values, []).
:- use_module(library(plunit)).
:- use_module(library(assoc), [assoc_to_list/2, empty_assoc/1, get_assoc/3, put_assoc/4]).
:- use_module(library(random), [random_between/3]).
:- use_module('../../indigolog/language/values').

/** <module> The values of a situation are those of a plain map, however many there are */

% both(+N, +Fluents, -Values, -Map): N random settings of some of Fluents fluents.
both(N, Fluents, Values, Map) :-
    no_values(Values0),
    empty_assoc(Map0),
    both(N, Fluents, Values0, Values, Map0, Map).

both(0, _, Values, Values, Map, Map) :- !.
both(N, Fluents, Values0, Values, Map0, Map) :-
    random_between(1, Fluents, I),
    store(Values0, cell(I), N, Values1),
    put_assoc(cell(I), Map0, N, Map1),
    N1 is N-1,
    both(N1, Fluents, Values1, Values, Map1, Map).

some(5, 3).
some(100, 8).
some(500, 40).
some(2000, 300).

:- begin_tests(values, [setup(set_random(seed(4)))]).

test(pairs, [forall(some(N, Fluents)), Pairs == Expected]) :-
    both(N, Fluents, Values, Map),
    stored_pairs(Values, Pairs),
    assoc_to_list(Map, Expected).

test(each, [forall(some(N, Fluents)), true(Wrong == [])]) :-
    both(N, Fluents, Values, Map),
    findall(I, ( between(1, Fluents, I),
                 findall(V, stored(Values, cell(I), V), Ours),
                 findall(V, get_assoc(cell(I), Map, V), Theirs),
                 Ours \== Theirs ), Wrong).

test(enumerated, [forall(some(N, Fluents)), Sorted == Expected]) :-
    both(N, Fluents, Values, Map),
    findall(F-V, stored_pair(Values, F, V), Pairs),
    msort(Pairs, Sorted),
    assoc_to_list(Map, Expected).

% Setting one value leaves the others, and the map before it, as they were.
test(a_value, [true(Old-New == Expected-[cell(1)-new|Rest])]) :-
    both(500, 40, Values, Map),
    store(Values, cell(1), new, Values1),
    stored_pairs(Values, Old),
    stored_pairs(Values1, New),
    assoc_to_list(Map, Expected),
    Expected = [cell(1)-_|Rest].

:- end_tests(values).
