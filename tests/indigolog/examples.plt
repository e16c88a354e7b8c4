:- module(test_indigolog_examples, []).
:- use_module(library(plunit)).
:- use_module(library(lists), [reverse/2, append/3, last/2]).
:- use_module('../../indigolog/indigolog').

/** <module> The agents under examples/ do what they say */

example(Name, File) :-
    module_property(test_indigolog_examples, file(Here)),
    file_directory_name(Here, Folder),
    atomic_list_concat([Folder, '/../../examples/', Name, '.pl'], File).

trace(Name, Program, Trace) :-
    example(Name, File),
    load_theory(File),
    once(do(Program, [], History)),
    reverse(History, Trace).

:- begin_tests(examples).

test(blocks_world,
     Trace == [move(b1, ground), move(b2, b1), move(b3, b2), move(b4, b3), move(b5, b4), move(b6, b5)]) :-
    trace(blocks_world, control, Trace).

test(elevator_takes_the_shortest_way, Length == 13) :-
    trace(elevator, control, Trace),
    length(Trace, Length).

test(delivery, Trace == [try(corridor, office), try(corridor, lab), go(corridor, lab), pick_up, try(lab, corridor),
                         go(lab, corridor), go(corridor, office), hand_over]) :-
    trace(delivery, control, Trace).

% The door between corridor and lab is shut: there is a way round.
test(delivery_plans_again, Last == hand_over) :-
    example(delivery, File),
    load_theory(File),
    indigolog(control, [device(shut_door), history(History)]),
    reverse(History, Trace),
    last(Trace, Last),
    \+ append(_, [go(corridor, lab)|_], Trace).

shut_door:can_execute(_).
shut_door:execute(try(X, Y), Passage) :-
    !,
    (   msort([X, Y], [corridor, lab])
    ->  Passage = shut
    ;   Passage = open
    ).
shut_door:execute(_, none).

:- end_tests(examples).
