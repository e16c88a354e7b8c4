:- module(test_device, []).
:- use_module(library(plunit)).
:- use_module('../../domain/reasoning/device').
:- use_module(fixtures).

:- begin_tests(device).

test(what_is_offered_is_in_range) :-
    testbed(Device),
    settings_in_range(Device, settings([0, 7, 3], 0.0166667, 4.0)).
test(what_is_not_offered_is_out_of_range,
     [ forall(member(S, [ settings([8, 0, 0], 0.0166667, 4.0), settings([-1, 0, 0], 0.0166667, 4.0),
                          settings([1, 0], 0.0166667, 4.0), settings([1.5, 0, 0], 0.0166667, 4.0),
                          settings([0, 0, 0], 0.02, 4.0), settings([0, 0, 0], 0.0166667, 7) ])),
       fail ]) :-
    testbed(Device),
    settings_in_range(Device, S).
test(an_exposure_rounded_in_writing_is_the_one_offered, Lit == settings([1, 2, 3], 0.0166667, 4.0)) :-
    testbed(Device),
    settings_in_range(Device, settings([1, 2, 3], 0.01667, 4)),
    lit_settings(Device, settings([1, 2, 3], 0.01667, 4), Lit).
test(further_off_than_the_device_allows, fail) :-
    testbed(Device),
    settings_in_range(Device, settings([1, 2, 3], 0.0167, 4.0)).
test(a_dead_light_may_have_any_level_and_gets_none, Lit == settings([0, 7, 7], 0.0166667, 4.0)) :-
    testbed(Device),
    without_light(Device, left, Darker),
    settings_in_range(Darker, settings([9, 7, 7], 0.0166667, 4.0)),
    lit_settings(Darker, settings([9, 7, 7], 0.0166667, 4.0), Lit).
test(reference_settings_are_offered) :-
    ring(Device),
    reference_settings(Device, Settings),
    settings_in_range(Device, Settings).
test(one_light_alone, Levels == [0, 7, 0]) :-
    testbed(Device),
    only_light(Device, 2, Levels).

:- end_tests(device).
