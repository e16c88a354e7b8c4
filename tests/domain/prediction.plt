:- module(test_prediction, []).
:- use_module(library(plunit)).
:- use_module('../../domain/reasoning/candidates').
:- use_module('../../domain/reasoning/device').
:- use_module('../../domain/reasoning/prediction').
:- use_module(fixtures).

% A world with known light and blur, seen through the device.
reading(Device, Settings, reading(Settings, statistics(P50, P95, 0.0, Saturated, Blur))) :-
    Settings = settings(Levels, Shutter, Aperture),
    level_fractions(Device, Levels, [L, R, T]),
    exposure_stops(Device, Settings, Stops),
    Bright is 2 ** Stops * (0.05 + 0.4 * L + 0.1 * R + 0.2 * T),
    P50 is min(1.0, 0.5 * Bright),
    P95 is min(1.0, Bright),
    ( Bright > 1 -> Saturated = 0.3 ; Saturated = 0.0 ),
    Blur is sqrt(1 + 9 * (2.8 / Aperture) ** 2 + 4 * (60 * Shutter) ** 2).

readings(Device, List, Readings) :-
    findall(Reading, ( member(S, List), reading(Device, S, Reading) ), Readings).

:- begin_tests(prediction).

test(learns_each_light) :-
    testbed(Device),
    readings(Device,
             [ settings([7, 0, 0], 0.0166667, 4.0), settings([0, 7, 0], 0.0166667, 4.0),
               settings([0, 0, 7], 0.0333333, 5.6), settings([0, 0, 0], 0.0666667, 4.0) ], Readings),
    Unseen = settings([7, 2, 4], 0.0083333, 4.0),
    predict(Device, Readings, Unseen, prediction(_, Highlight, _, _)),
    reading(Device, Unseen, reading(_, statistics(_, True, _, _, _))),
    abs(Highlight / True - 1) < 0.1.
test(what_a_light_gave_before_it_died_is_not_the_sun_s, Before =:= After) :-
    testbed(Device),
    without_light(Device, left, Darker),
    readings(Device, [settings([7, 0, 2], 0.0166667, 4.0), settings([7, 0, 0], 0.0166667, 4.0)], Readings),
    Without = settings([0, 7, 7], 0.0166667, 4.0),
    predict(Device, Readings, Without, prediction(Before, _, _, _)),
    predict(Darker, Readings, Without, prediction(After, _, _, _)).
test(one_reading_sets_the_scale) :-
    testbed(Device),
    readings(Device, [settings([7, 7, 7], 0.0041667, 5.6)], Readings),
    predict(Device, Readings, settings([7, 7, 7], 0.0083333, 5.6), prediction(_, Highlight, _, _)),
    reading(Device, settings([7, 7, 7], 0.0083333, 5.6), reading(_, statistics(_, True, _, _, _))),
    abs(Highlight / True - 1) < 0.2.
% In weak light and no sun the median is noise, whatever is lit: of a session that took an image without any light.
test(without_light_nothing_is_expected_in_the_dark) :-
    testbed(Device),
    findall(reading(settings(Levels, Shutter, Aperture), statistics(Middle, Highlight, 0.6, 0.0, 5.0)),
            member(seen(Levels, Shutter, Aperture, Middle, Highlight),
                   [ seen([2, 2, 2], 0.0666667, 2.8, 0.0078, 0.125), seen([7, 0, 0], 0.0666667, 2.8, 0.0078, 0.133),
                     seen([0, 7, 7], 0.0666667, 4.0, 0.0039, 0.157), seen([0, 0, 7], 0.0666667, 2.8, 0.0078, 0.2),
                     seen([0, 7, 0], 0.0666667, 2.8, 0.0078, 0.129), seen([7, 7, 7], 0.0333333, 2.8, 0.0078, 0.223),
                     seen([7, 0, 7], 0.0666667, 2.8, 0.0078, 0.329), seen([7, 7, 7], 0.0666667, 2.8, 0.0118, 0.447),
                     seen([7, 3, 7], 0.0166667, 2.8, 0.0039, 0.094) ]),
            Readings),
    predict(Device, Readings, settings([0, 0, 0], 0.0666667, 2.8), prediction(Dark, Highlight, _, _)),
    Dark =< Highlight.
test(saturation_means_at_least) :-
    testbed(Device),
    readings(Device, [settings([7, 7, 7], 0.0666667, 2.8)], Readings),
    predict(Device, Readings, settings([7, 7, 7], 0.0666667, 2.8), prediction(_, Highlight, _, _)),
    Highlight > 1.2.
test(learns_blur) :-
    testbed(Device),
    readings(Device,
             [ settings([1, 0, 0], 0.0166667, 2.8), settings([1, 0, 0], 0.0166667, 5.6),
               settings([1, 0, 0], 0.0666667, 5.6) ], Readings),
    Unseen = settings([1, 0, 0], 0.0333333, 4.0),
    predict(Device, Readings, Unseen, prediction(_, _, Blur, _)),
    reading(Device, Unseen, reading(_, statistics(_, _, _, _, True))),
    abs(Blur / True - 1) < 0.15.
test(blur_that_nothing_tells_apart_is_rather_of_the_aperture) :-
    testbed(Device),
    Level = [7, 7, 7],
    Sharper = reading(settings(Level, 0.0041667, 5.6), statistics(0.1, 0.2, 0, 0, 1.4)),
    Wider = reading(settings(Level, 0.0083333, 4.0), statistics(0.3, 0.6, 0, 0, 2.3)),
    predict(Device, [Wider, Sharper], settings(Level, 0.0166667, 5.6), prediction(_, _, Longer, _)),
    predict(Device, [Wider, Sharper], settings(Level, 0.0041667, 2.8), prediction(_, _, Open, _)),
    Longer < Open.
test(dark_glare_and_blur_cost) :-
    testbed(Device),
    readings(Device,
             [ settings([7, 0, 0], 0.0166667, 4.0), settings([0, 7, 0], 0.0166667, 4.0),
               settings([0, 0, 7], 0.0166667, 2.8), settings([7, 7, 7], 0.0083333, 5.6) ], Readings),
    predict(Device, Readings, settings([7, 7, 7], 0.0166667, 4.0), prediction(_, _, _, Good)),
    predict(Device, Readings, settings([0, 1, 0], 0.0041667, 5.6), prediction(_, _, _, Dark)),
    predict(Device, Readings, settings([7, 7, 7], 0.0666667, 2.8), prediction(_, _, _, Glare)),
    Good < Dark,
    Good < Glare.
test(a_tone_curve_makes_steps_finer_in_the_dark_and_coarser_in_the_light) :-
    testbed(Linear),
    Linear = device(Lights, Shutters, Apertures, sensor(Gain, _, _, 1.0), Exposure, Tolerance),
    Clean = device(Lights, Shutters, Apertures, sensor(Gain, 0.0, 1.0e9, 1.0), Exposure, Tolerance),
    Curved = device(Lights, Shutters, Apertures, sensor(Gain, 0.0, 1.0e9, 2.2), Exposure, Tolerance),
    readings(Linear, [ settings([7, 7, 7], 0.0166667, 4.0) ], Readings),
    forall(member(Settings-Order, [ settings([7, 7, 7], 0.0166667, 4.0)-(>), settings([0, 1, 0], 0.0041667, 5.6)-(<) ]),
           ( predict(Clean, Readings, Settings, prediction(_, _, _, Even)),
             predict(Curved, Readings, Settings, prediction(_, _, _, Uneven)),
             compare(Order, Uneven, Even) )).

:- end_tests(prediction).

:- begin_tests(candidates).

%   Inferences that a ranking takes.
effort(Device, Readings, Ranked, Inferences) :-
    call_inferences(ranking(Device, experience(Readings, [], []), Ranked), Inferences).

call_inferences(Goal, Inferences) :-
    statistics(inferences, Before),
    once(Goal),
    statistics(inferences, After),
    Inferences is After - Before.

test(all_can_be_set) :-
    testbed(Device),
    forall(candidate(Device, Settings), settings_in_range(Device, Settings)).
test(few_for_three_lights) :-
    testbed(Device),
    aggregate_all(count, candidate(Device, _), Count),
    Count =< 200.
test(few_for_many_lights) :-
    ring(Device),
    aggregate_all(count, candidate(Device, _), Count),
    Count =< 60.
test(darkness_calls_for_light) :-
    testbed(Device),
    Dark = reading(settings([0, 1, 0], 0.0041667, 5.6), statistics(0.001, 0.004, 1.0, 0.0, unknown)),
    most_promising(Device, experience([Dark], [], []), Settings, _),
    predict(Device, [Dark], Settings, prediction(_, Highlight, _, _)),
    Highlight > 0.1.
test(glare_calls_for_less) :-
    testbed(Device),
    Glare = reading(settings([7, 7, 7], 0.0666667, 2.8), statistics(1.0, 1.0, 0.0, 0.9, unknown)),
    most_promising(Device, experience([Glare], [], []), Settings, _),
    exposure_stops(Device, Settings, Stops),
    Stops < 2.
test(what_was_ranked_last_is_not_ranked_again) :-
    testbed(Device),
    readings(Device, [settings([7, 7, 7], 0.0083333, 4.0), settings([0, 3, 0], 0.0166667, 4.0)], Readings),
    Readings = [_|Fewer],
    effort(Device, Fewer, Ranked, First),
    effort(Device, Fewer, Again, Second),
    Ranked == Again,
    Second * 100 < First,
    effort(Device, Readings, Other, Third),
    Other \== Ranked,
    Third > First.
test(not_the_same_again) :-
    testbed(Device),
    readings(Device, [settings([7, 7, 7], 0.0083333, 4.0)], Readings),
    most_promising(Device, experience(Readings, [], []), First, why(State, _, _)),
    most_promising(Device, experience(Readings, [State], []), Second, _),
    First \== Second.
test(unfavourable_is_avoided) :-
    testbed(Device),
    readings(Device, [settings([7, 7, 7], 0.0083333, 4.0)], Readings),
    most_promising(Device, experience(Readings, [], []), _, why(State, _, _)),
    most_promising(Device, experience(Readings, [], [State]), _, why(Other, _, _)),
    domain_qualitative:similarity(State, Other, S),
    S =< 0.7.
test(what_is_safest_is_lit_and_short, Settings == settings([7, 7, 7], 0.0166667, 5.6)) :-
    testbed(Device),
    safest(Device, Settings).
test(what_is_safest_shows_something_in_weak_and_strong_light, [forall(member(Times, [1/16, 1, 4]))]) :-
    testbed(Device),
    safest(Device, Settings),
    fit(Device, [], response(_, Highlight, Blur)),
    maplist([X, Y]>>(Y is Times * X), Highlight, Brighter),
    predict_with(Device, response(Brighter, Brighter, Blur), Settings, prediction(_, Seen, _, _)),
    assertion(( Seen > 0.002, Seen < 2.0 )).
test(what_is_safest_of_one_setting_is_that) :-
    ring(Device),
    safest(Device, settings(_, 0.01, 8.0)).
test(exposure_program) :-
    testbed(Device),
    readings(Device, [settings([7, 7, 7], 0.0041667, 5.6), settings([7, 7, 7], 0.0166667, 4.0)], Readings),
    best_exposure(Device, Readings, [7, 7, 7], Settings),
    reading(Device, Settings, reading(_, statistics(_, P95, _, _, _))),
    P95 > 0.5,
    P95 =< 1.0.

:- end_tests(candidates).
