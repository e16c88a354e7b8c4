:- module(test_strategies, []).
:- use_module(library(plunit)).
:- use_module(library(apply)).
:- use_module(library(lists)).
:- use_module('../../domain/reasoning/merit', [worst_merit/1]).
:- use_module('../../domain/testing/simulated_world').
:- use_module('../../indigolog/indigolog').

/** <module> The strategies of domain/controllers, the approach and the procedures, run in a world without images */

never(threshold(1.0e-6)).

fluents(Situation, Names, Values) :-
    maplist([Name, Value]>>fluent_value(Name, Situation, Value), Names, Values).

:- begin_tests(acquisition_strategies).

test(images_are_kept_while_there_is_no_pose, Images-Discarded == [i3, i2, i1]-[]) :-
    never(Never),
    in_world([Never, images(3), blind_below(1000)], heuristic, [connect, advance(1), control], final, Situation),
    fluents(Situation, [image_set, discarded], [Set, Discarded]),
    findall(Image, member(kept(Image, _), Set), Images).

test(each_finds_the_pose_in_mild_light,
     [forall(member(Name, [simple, greedy, heuristic, informed, auto_exposed])), nondet]) :-
    in_world([seed(3)], Name, session, final, Situation),
    situation_holds(converged, Situation),
    fluent_value(taken, Situation, Taken),
    assertion(Taken =< 10).
test(each_does_the_same_again,
     [forall(member(Name, [simple, greedy, heuristic, informed, auto_exposed, fixed, fused, gradient]))]) :-
    never(Never),
    in_world([Never, images(4), seed(5)], Name, session, final, First),
    in_world([Never, images(4), seed(5)], Name, session, final, Second),
    situation_history(First, History),
    situation_history(Second, Again),
    assertion(History == Again).
test(each_stops_when_no_more_images_may_be_taken,
     [forall(member(Name, [simple, greedy, heuristic, informed])), true(Taken == 4)]) :-
    never(Never),
    in_world([Never, images(4)], Name, session, final, Situation),
    fluent_value(iteration, Situation, Taken).
test(no_strategy_takes_more_images_than_it_may, Taken == 4) :-
    never(Never),
    in_world([Never, images(4)], simple,
             [connect, while(true, [choose_random, take_image, measure, keep_image])], failed, Situation),
    fluent_value(iteration, Situation, Taken).
test(a_first_pose_is_likely_now_before_it_is_kept, Likely == [false, true, true]) :-
    findall(Is,
            ( member(Test-Then, [likely-[], likely_now-[], likely-keep_image]),
              in_world([seed(3)], simple, [connect, choose_reference, take_image, measure, Then], final, Situation),
              ( situation_holds(Test, Situation) -> Is = true ; Is = false ) ),
            Likely).
test(the_reason_is_that_there_is_no_pose, Reasons == ['no pose with it', 'no pose with it']) :-
    never(Never),
    in_world([Never, images(2), blind_below(1000)], greedy, [connect, advance(1), control], final, Situation),
    fluent_value(steps, Situation, Steps),
    findall(Reason, member(step(_, _, _, _, discard, Reason, _, _, _), Steps), Reasons).
test(what_cannot_be_done_is_not_done,
     [forall(member(Program-Done, [ [take_image]-0, [keep_image]-0, [choose_random, take_image, keep_image]-1 ]))]) :-
    in_world([], simple, [connect|Program], failed, Situation),
    fluents(Situation, [iteration, image_set], [Done, []]).
test(simple_keeps_every_image, Images-Discarded == [i4, i3, i2, i1]-[]) :-
    never(Never),
    in_world([Never, images(4), useless], simple, session, final, Situation),
    fluents(Situation, [image_set, discarded], [Set, Discarded]),
    findall(Image, member(kept(Image, _), Set), Images).
test(images_that_do_not_help_are_dropped,
     [forall(member(Name, [greedy, heuristic])), true(Images-Discarded == [i1]-[i4, i3, i2])]) :-
    never(Never),
    in_world([Never, images(4), useless, sun(0.1), seed(2)], Name, session, final, Situation),
    fluents(Situation, [image_set, discarded], [Set, Discarded]),
    findall(Image, member(kept(Image, _), Set), Images).
test(heuristic_does_not_repeat_itself) :-
    never(Never),
    in_world([Never, images(8), useless], heuristic, session, final, Situation),
    settings_taken(Situation, Settings),
    sort(Settings, Distinct),
    same_length(Settings, Distinct).
test(heuristic_marks_the_states_of_images_that_did_not_help, Count =:= 3) :-
    never(Never),
    in_world([Never, images(4), useless, sun(0.1), seed(2)], heuristic, session, final, Situation),
    fluent_value(unfavourable, Situation, States),
    length(States, Count).
test(heuristic_believes_no_image_alone) :-
    in_world([threshold(50.0)], heuristic, session, final, Situation),
    fluent_value(image_set, Situation, Set),
    length(Set, Size),
    assertion(Size >= 2).
test(heuristic_believes_two_that_agree, Images == [i2, i1]) :-
    in_world([threshold(50.0), useless], heuristic, session, final, Situation),
    fluent_value(image_set, Situation, Set),
    findall(Image, member(kept(Image, _), Set), Images).
test(heuristic_turns_to_light_after_a_dark_image) :-
    in_world([sun(0.0), images(6)], heuristic, session, final, Situation),
    situation_holds(converged, Situation).
test(heuristic_turns_from_glare) :-
    in_world([sun(3.0), images(6)], heuristic, session, final, Situation),
    situation_holds(converged, Situation).
test(informed_takes_what_is_foreseen_to_add_most, Settings == settings([7, 1, 0], 0.0166667, 4.0)) :-
    never(Never),
    in_world([Never, images(2)], informed, session, final, Situation),
    settings_taken(Situation, [_, Settings]).
test(informed_does_as_the_heuristic_where_nothing_is_foreseen, [true(Taken == 6), nondet]) :-
    never(Never),
    in_world([Never, images(6), nothing_foreseen], informed, session, final, Situation),
    settings_taken(Situation, Settings),
    sort(Settings, Distinct),
    length(Distinct, Taken).
test(informed_keeps_what_does_no_harm_and_avoids_what_does, Images-States == [i2, i1]-[]) :-
    never(Never),
    in_world([Never, images(2), useless], informed, session, final, Situation),
    fluents(Situation, [image_set, unfavourable], [Set, States]),
    findall(Image, member(kept(Image, _), Set), Images).
test(informed_drops_an_image_that_harms, Discarded-States == [i2]-1) :-
    never(Never),
    in_world([Never, images(2), harmful], informed, session, final, Situation),
    fluents(Situation, [discarded, unfavourable], [Discarded, Unfavourable]),
    length(Unfavourable, States).
test(informed_keeps_an_image_with_which_the_pose_is_trusted_all_the_same, Taken == 2) :-
    in_world([threshold(99.0), harmful], informed, session, final, Situation),
    fluent_value(taken, Situation, Taken).
test(fused_takes_every_shutter_with_all_lights_full, Bracket-Kept == [0.0041667, 0.0083333, 0.0166667, 0.0333333, 0.0666667]-5) :-
    in_world([], fused, session, final, Situation),
    settings_taken(Situation, Settings),
    findall(Shutter, member(settings([7, 7, 7], Shutter, 4.0), Settings), Bracket),
    fluent_value(image_set, Situation, Set),
    length(Set, Kept).
test(gradient_turns_lights_until_gradients_are_rich, [forall(member(Sun, [0.0, 0.2, 2.0]))]) :-
    in_world([sun(Sun)], gradient, session, final, Situation),
    fluents(Situation, [image_set, richest_gamma, settings], [[_], Gamma, settings(_, Shutter, _)]),
    assertion(abs(Gamma - 1) < 0.5),
    assertion(( Sun < 1 -> Shutter =:= 0.0166667 ; Shutter < 0.0166667 )).
test(informed_begins_anew_when_a_target_moved_unannounced, Images-Reasons == [i5, i4, i3]-['', '', 'not as foreseen: the target has moved', '', '']) :-
    never(Never),
    in_world([Never, images(5), happens(surprise(i3, target_moved), i3)], informed, session, final, Situation),
    fluents(Situation, [image_set, steps], [Set, Steps]),
    findall(Image, member(kept(Image, _), Set), Images),
    findall(Reason, member(step(_, _, _, _, keep, Reason, _, _, _), Steps), Reasons).
test(five_images_that_bring_nothing_are_the_last, [forall(member(Name, [heuristic, informed])), true(Taken == 6)]) :-
    never(Never),
    in_world([Never, images(10), useless, sun(0.1), seed(2)], Name, session, final, Situation),
    fluent_value(taken, Situation, Taken).
test(eight_images_without_a_likely_pose_are_the_last, [forall(member(Name, [heuristic, informed])), true(Taken == 8)]) :-
    never(Never),
    in_world([Never, images(10), blind_below(1000)], Name, [connect, advance(1), control], final, Situation),
    fluent_value(taken, Situation, Taken).
test(four_images_that_leave_another_pose_as_likely_are_the_last, [forall(member(Name, [heuristic, informed])), true(Taken == 4)]) :-
    in_world([images(10), useless, rival(0.1), threshold(0.9), sun(0.1), seed(2)], Name, session, final, Situation),
    fluent_value(taken, Situation, Taken).
test(a_pose_that_is_looked_for_anew_has_all_its_images_before_it, Fruitless-Merit-Undecided == 0-Worst-0) :-
    worst_merit(Worst),
    in_world([images(10), useless, rival(0.1)], informed, [connect, control, start_over], final, Situation),
    fluents(Situation, [fruitless, least_merit, undecided], [Fruitless, Merit, Undecided]).
test(informed_takes_no_settings_twice) :-
    never(Never),
    in_world([Never, images(6)], informed, session, final, Situation),
    settings_taken(Situation, Settings),
    sort(Settings, Distinct),
    same_length(Settings, Distinct).
test(fixed_takes_one_image_half_way_up, Settings == [settings([4, 4, 4], 0.0166667, 4.0)]) :-
    in_world([], fixed, session, final, Situation),
    settings_taken(Situation, Settings).
test(auto_exposed_keeps_one_image_of_those_it_metered) :-
    in_world([sun(1.0)], auto_exposed, session, final, Situation),
    fluents(Situation, [image_set, statistics, discarded], [[_], statistics(_, Highlight, _, _, _), [_|_]]),
    assertion(( Highlight > 0.5, Highlight < 1.0 )).

:- end_tests(acquisition_strategies).

:- begin_tests(acquisition_events).

test(another_sun_begins_another_set, Images == [i4, i3, i2]) :-
    never(Never),
    in_world([Never, images(4), happens(sun_changed, i2)], simple, session, final, Situation),
    fluent_value(image_set, Situation, Set),
    findall(Image, member(kept(Image, _), Set), Images).
test(a_target_that_moved_has_another_pose, Taken == 2) :-
    never(Never),
    in_world([Never, images(4), happens(target_moved, i2)], simple, session, final, Situation),
    fluents(Situation, [taken, iteration], [Taken, 4]).
test(a_target_that_moves_on_and_on_ends_the_session_as_well) :-
    never(Never),
    findall(happens(target_moved, Image), ( between(1, 40, N), atom_concat(i, N, Image) ), Moves),
    in_world([Never, images(5)|Moves], heuristic, session, final, Situation),
    fluents(Situation, [iteration], [5]).
test(a_light_that_died_is_left_off) :-
    never(Never),
    in_world([Never, images(6), happens(light_fault(left), i2)], heuristic, session, final, Situation),
    settings_taken(Situation, [_, _|Later]),
    length(Later, 4),
    forall(member(settings([Left|_], _, _), Later), Left =:= 0).

:- end_tests(acquisition_events).

:- begin_tests(approach).

test(goes_on_from_one_trusted_pose_to_the_next, Holds == [0.5-reached, 0.7-fixed, 1.0-fixed]) :-
    in_world([], heuristic, session([1.0, 0.7, 0.5]), final, Situation),
    hold_points(Situation, Holds).
test(looks_afresh_once_and_then_gives_up, Holds-Retries == [0.7-aborted, 1.0-fixed]-1) :-
    in_world([blind_below(0.8), images(3)], heuristic, session([1.0, 0.7, 0.5]), final, Situation),
    hold_points(Situation, Holds),
    situation_history(Situation, History),
    aggregate_all(count, member(start_over, History), Retries).
test(each_image_knows_its_range, Ranges == [1.0, 0.7]) :-
    in_world([], simple, session([1.0, 0.7]), final, Situation),
    fluent_value(steps, Situation, Steps),
    findall(Range, ( member(Step, Steps), arg(9, Step, Range) ), Newest),
    reverse(Newest, Oldest),
    list_to_set(Oldest, Ranges).

hold_points(Situation, Points) :-
    fluent_value(holds, Situation, Holds),
    findall(Range-Outcome, member(hold(Range, Outcome, _), Holds), Points).

:- end_tests(approach).

:- begin_tests(procedures).

%   What holds after a program.
after(Options, Program, Test) :-
    in_world(Options, simple, [connect|Program], final, Situation),
    situation_holds(Test, Situation).

test(nothing_is_trusted_before_there_is_a_pose, fail) :-
    after([], [], converged).
test(a_pose_under_the_threshold_is_trusted) :-
    after([sun(0.3)], [choose_reference, take_image, measure, keep_image], converged).
test(a_pose_over_the_threshold_is_not, fail) :-
    after([sun(0.3), threshold(0.1)], [choose_reference, take_image, measure, keep_image], converged).
test(exhausted_when_no_more_images_may_be_taken) :-
    after([images(1)], [choose_reference, take_image, drop_image(no)], and([exhausted, finished])).
test(a_first_pose_improves_on_none) :-
    after([], [choose_reference, take_image, measure], improved).
test(the_same_again_does_not_improve, fail) :-
    after([useless],
          [choose_reference, take_image, measure, keep_image, choose_reference, take_image, measure], improved).
test(two_images_confirm_each_other) :-
    Again = [choose_reference, take_image, measure, keep_image],
    after([], [Again, Again], confirmed).
test(one_image_confirms_nothing, fail) :-
    after([], [choose_reference, take_image, measure, keep_image], confirmed).
test(no_image_while_there_is_a_candidate, Outcome == failed) :-
    in_world([], simple, [connect, choose_reference, take_image, take_image], Outcome, _).
test(what_was_kept_cannot_be_dropped, Outcome == failed) :-
    in_world([], simple, [connect, choose_reference, take_image, measure, keep_image, drop_image(late)], Outcome, _).
test(an_unfavourable_state_is_remembered) :-
    after([], [choose_reference, mark_unfavourable], unfavourable = [state(medium, even, 0)]).

:- end_tests(procedures).
