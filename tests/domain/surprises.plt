:- module(test_surprises, []).
:- use_module(library(plunit)).
:- use_module(library(lists)).
:- use_module('../../domain/reasoning/surprises').
:- use_module('../../domain/testing/simulated_world').
:- use_module('../../indigolog/indigolog').

/** <module> Images that are not as foreseen, and the test images that tell why */

never(threshold(1.0e-6)).

taken_after(Events, Images, Settings, Situation) :-
    never(Never),
    in_world([Never, images(Images)|Events], informed, session, final, Situation),
    settings_taken(Situation, Settings).

:- begin_tests(surprises).

test(a_light_that_is_found_dead_is_not_lit_again, Later == [0, 0, 0]) :-
    taken_after([happens(surprise(i2, light_dead(left)), i2)], 5, [_, settings([7|_], _, _)|Settings], Situation),
    findall(Left, member(settings([Left|_], _, _), Settings), Later),
    assertion(fluent_value(working(left), Situation, false)),
    assertion(\+ fluent_value(image_set, Situation, [_])).
test(a_model_that_does_not_fit_is_remembered_and_changes_nothing_else, [true(Number-Kept == 4-4)]) :-
    taken_after([happens(surprise(i2, model_wrong(y, 0.02)), i2)], 4, _, Situation),
    assertion(fluent_value(model_fault, Situation, wrong(y, 0.02))),
    fluent_value(readings, Situation, Readings),
    fluent_value(image_set, Situation, Set),
    length(Readings, Number),
    length(Set, Kept).
test(the_image_in_which_a_light_was_dead_is_read_as_without_it, Left == 0) :-
    taken_after([happens(surprise(i2, light_dead(left)), i2)], 2, [_, settings([7|_], _, _)], Situation),
    fluent_value(readings, Situation, [reading(settings([Left|_], _, _), _)]).
test(what_was_applied_is_seen_in_what_was_sensed, Applied-Event == other-event) :-
    Seen = under(other, told(statistics(a, b, c, d, e), event)),
    statistics_seen(Seen, statistics(a, b, c, d, e)),
    settings_seen(Seen, asked, Applied),
    event_seen(Seen, Event),
    assertion(settings_seen(told(statistics(a, b, c, d, e), event), asked, asked)).
test(what_does_not_fit_is_said_with_its_axis, Text == 'the model does not fit, it is about 2.0 % too short along z') :-
    remark(because(i2, model_wrong(z, -0.02)), none, Text).
test(of_another_sun_only_the_last_image_is_remembered, [forall(member(Cause, [sun_changed, lights_swapped(left, top)])), true(Number == 3)]) :-
    taken_after([happens(surprise(i2, Cause), i2)], 4, _, Situation),
    fluent_value(readings, Situation, Readings),
    length(Readings, Number),
    fluent_value(image_set, Situation, Set),
    assertion(length(Set, 4)).          % edges are where they were
test(what_is_new_shows_in_the_first_image_again, [forall(member(Cause, [sun_changed, in_the_way])), true(First == Test)]) :-
    taken_after([happens(doubt(i2, Cause), i2)], 3, [First, _, Test], _).
test(what_is_in_the_way_is_looked_at_again_where_most_is_seen_first_and_never_as_when_it_was_doubted, Again == [third, first]) :-
    Shown = [four-(0.0-0.0), third-(0.1-0.0), second-(0.5-0.4), first-(0.0-0.2)],
    findall(reading(S, statistics(0.3, 0.6, Dark, Saturated, 1.0)), member(S-(Dark-Saturated), Shown), Readings),
    telling_settings(device([], [], [], none, none, 1), Readings, in_the_way, [], Test),
    telling_settings(device([], [], [], none, none, 1), [reading(Test, none)|Readings], in_the_way, [Test], Next),
    Again = [Test, Next].
test(what_is_in_the_way_changes_nothing_of_light_and_set, [true(Number-Kept == 4-4)]) :-
    taken_after([happens(surprise(i2, in_the_way), i2)], 4, _, Situation),
    fluent_value(readings, Situation, Readings),
    fluent_value(image_set, Situation, Set),
    length(Readings, Number),
    length(Set, Kept).
test(without_a_dead_light_the_last_image_is_the_same, Test == settings([0, 1, 0], Shutter, Aperture)) :-
    taken_after([happens(doubt(i2, light_dead(left)), i2)], 3, [_, settings([7, 1, 0], Shutter, Aperture), Test], _).
test(a_light_that_was_off_is_put_out_where_it_was_lit, Test == settings([7, 7, 0], Shutter, Aperture)) :-
    taken_after([happens(doubt(i2, light_dead(top)), i2)], 3, [settings(_, Shutter, Aperture), _, Test], _).
test(an_image_without_doubt_ends_the_questions, First == Test) :-
    taken_after([happens(doubt(i3, sun_changed), i3)], 5, [First, _, _, Test, Next], _),
    assertion(Next \= settings([0, 0, 0], _, _)).
test(swapped_lights_are_looked_at_one_by_one, Levels == [[0, 7, 0], [0, 0, 7]]) :-
    Cause = lights_swapped(right, top),
    taken_after([happens(doubt(i2, Cause), i2), happens(doubt(i3, Cause), i3)], 4, [_, _|Settings], _),
    findall(L, member(settings(L, _, _), Settings), Levels).
test(an_image_before_is_repeated_with_the_swapped_lights_in_each_others_place, Again == settings([1, 7, 0], Shutter, Aperture)) :-
    taken_after([happens(doubt(i3, lights_swapped(left, right)), i3)], 4, [_, settings([7, 1, 0], Shutter, Aperture), _, Again], _).
test(swapped_lights_of_other_levels_are_exchanged_by_their_share,
     [forall(member(Lit-Levels, [[31, 0]-[0, 1], [13, 1]-[31, 0]])), true(Test == Levels)]) :-
    Device = device([light(port, 32), light(starboard, 2)], [0.01], [4.0], none, exposure(0.01, 4.0), 0.01),
    S = settings(Lit, 0.01, 4.0),       % 13 of 31 is no level of the other, so one is looked at alone
    telling_settings(Device, [reading(S, none), reading(S, none)], lights_swapped(port, starboard), [], settings(Test, _, _)).
test(four_test_images_are_the_last, [true(Again-Without == First-[0, 7, 7]), nondet]) :-
    Cause = light_dead(left),
    findall(happens(doubt(Image, Cause), Image), member(Image, [i2, i3, i4, i5]), Events),
    taken_after(Events, 6, [First, _, _, Again, settings(Without, _, _), Next], _),
    assertion(Next \= settings(Without, _, _)).
test(a_trusted_pose_does_not_end_a_session_in_doubt, Taken == 3) :-
    in_world([threshold(99.0), happens(doubt(i2, sun_changed), i2)], informed, session, final, Situation),
    fluent_value(taken, Situation, Taken).
test(nothing_is_tested_where_no_more_images_may_be_taken, Taken == 2) :-
    never(Never),
    in_world([Never, images(2), happens(doubt(i2, sun_changed), i2)], informed, session, final, Situation),
    fluent_value(taken, Situation, Taken).
test(the_step_says_why, Reasons == ['not as foreseen: the light left is dead', 'not as foreseen: perhaps the sun has changed', '']) :-
    taken_after([happens(doubt(i2, sun_changed), i2), happens(surprise(i3, light_dead(left)), i3)], 3, _, Situation),
    fluent_value(steps, Situation, Steps),
    findall(Reason, member(step(_, _, _, _, keep, Reason, _, _, _), Steps), Reasons).
test(lights_are_told_by_their_names, Text == 'not as foreseen: the lights left and top are swapped') :-
    remark(because(i3, lights_swapped(left, top)), none, Text).

:- end_tests(surprises).
