:- module(test_qualitative, []).
:- use_module(library(plunit)).
:- use_module('../../domain/reasoning/qualitative').
:- use_module(fixtures).

:- begin_tests(qualitative).

state(Levels, Shutter, Aperture, State) :-
    testbed(Device),
    qualitative_state(Device, settings(Levels, Shutter, Aperture), State).

test(off, State == state(off, none, 0)) :-
    state([0, 0, 0], 0.0166667, 4.0, State).
test(one_light_alone, State == state(dim, from(left), 0)) :-
    state([7, 0, 0], 0.0166667, 4.0, State).
test(all_lights, State == state(bright, even, 0)) :-
    state([7, 7, 7], 0.0166667, 4.0, State).
test(two_lights_are_even, State == state(medium, even, 0)) :-
    state([7, 7, 0], 0.0166667, 4.0, State).
test(stops_count_shutter_and_aperture, E-F == 3-(-3)) :-
    state([7, 7, 7], 0.0666667, 2.8, state(_, _, E)),
    state([7, 7, 7], 0.0041667, 5.6, state(_, _, F)).
test(many_lights, State == state(dim, even, 0)) :-
    ring(Device),
    Levels = [0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0],
    qualitative_state(Device, settings(Levels, 0.01, 8.0), State).
test(a_lamp_that_cannot_be_dimmed, State == state(dim, from(lamp), 0)) :-
    ring(Device),
    Levels = [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0],
    qualitative_state(Device, settings(Levels, 0.01, 8.0), State).

test(same_is_one, S =:= 1) :-
    similarity(state(dim, from(top), 2), state(dim, from(top), 2), S).
test(symmetric, A =:= B) :-
    similarity(state(dim, from(top), 2), state(bright, even, 0), A),
    similarity(state(bright, even, 0), state(dim, from(top), 2), B).
test(graded) :-
    X = state(medium, from(left), 0),
    similarity(X, state(medium, from(left), 1), Near),
    similarity(X, state(medium, from(right), 1), Far),
    similarity(X, state(medium, from(right), 3), Farther),
    1 > Near, Near > Far, Far > Farther, Farther > 0.
test(greatest_of_none, S =:= 0) :-
    greatest_similarity(state(dim, even, 0), [], S).
test(greatest, S =:= 1) :-
    greatest_similarity(state(dim, even, 0), [state(off, none, 0), state(dim, even, 0)], S).

test(words, Text == "bright from left, +1 stop") :-
    state_words(state(bright, from(left), 1), Text).
test(words_off, Text == "off, -2 stops") :-
    state_words(state(off, none, -2), Text).
test(settings_in_words, Text == "left 3 right 0 top 7, 1/60 s, f/4") :-
    testbed(Device),
    settings_words(Device, settings([3, 0, 7], 0.0166667, 4.0), Text).

test(settings_of_a_device_without_lights, Text == "1/60 s, f/4") :-
    settings_words(device([], [0.0166667], [4.0], none, exposure(0.0166667, 4.0), 0.01), settings([], 0.0166667, 4.0), Text).

test(of_many_lights_a_line_tells_how_many_are_lit, Text == "2 of 24 lights, 1/60 s, f/4") :-
    findall(light(lamp, 8), between(1, 24, _), Lights),
    Device = device(Lights, [0.0166667], [4.0], none, exposure(0.0166667, 4.0), 0.01),
    findall(Level, ( between(1, 24, N), ( N > 22 -> Level = 7 ; Level = 0 ) ), Levels),
    brief_settings_words(Device, settings(Levels, 0.0166667, 4.0), Text).
test(shutters_in_words, [forall(member(Seconds-Words, [ 0.0041667-"1/240 s", 0.033-"1/30 s", 0.333-"1/3 s", 0.4-"0.4 s",
                                                      0.28-"0.28 s", 0.5-"0.5 s", 2.0-"2 s" ])),
                         true(Text == Words)]) :-
    shutter_words(Seconds, Text).

test(dark, Quality == dark) :-
    image_quality(statistics(0.01, 0.02, 0.95, 0.0, unknown), Quality).
test(glare, Quality == glare) :-
    image_quality(statistics(0.9, 1.0, 0.0, 0.5, 2.0), Quality).
test(good, Quality == good) :-
    image_quality(statistics(0.3, 0.7, 0.1, 0.01, 1.2), Quality).

:- end_tests(qualitative).
