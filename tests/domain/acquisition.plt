:- module(test_acquisition, []).
:- use_module(library(plunit)).
:- use_module('../../indigolog/indigolog').
:- use_module(fixtures).

/** <module> What a controller knows and can do, run on a bench that only senses */

load :-
    module_property(test_acquisition, file(Here)),
    file_directory_name(Here, Folder),
    atom_concat(Folder, '/../../domain/acquisition.pl', File),
    load_theory(File).

:- dynamic happening/1.                 % events that come next

bench:can_execute(_).
bench:execute(Action, Result) :-
    (   Action == connect
    ->  testbed(Device),
        Result = session(Device, 1.0, 9)
    ;   Result = none,
        ( Action == avoid(nothing) -> assertz(test_acquisition:happening(light_fault(left))) ; true )
    ).
bench:exogenous(Events) :-
    findall(Event, retract(test_acquisition:happening(Event)), Events).

outcome(Program, Outcome) :-
    retractall(happening(_)),
    indigolog(Program, [device(bench), outcome(Outcome)]).

:- begin_tests(acquisition, [setup(load)]).

test(settings_thought_of_before_a_light_died_are_chosen_without_it, Outcome == final) :-
    outcome([ connect,
              pi([s, l],
                 [ ?(reference_settings(device, s)),
                   avoid(nothing),
                   ?(done(light_fault(left))),
                   choose(s),
                   ?(and([lit_settings(device, s, l), neg(l = s), settings = l])) ]) ], Outcome).

:- end_tests(acquisition).
