:- module(test_strategies_to_copy, []).
:- use_module(library(plunit)).
:- use_module(library(lists)).
:- use_module('../../domain/testing/simulated_world').
:- use_module('../../indigolog/indigolog').

/** <module> The strategies of examples/ do what they say */

in_world_with(Options, Name, Situation) :-
    atomic_list_concat(['../../examples/', Name, '.pl'], File),
    in_world(Options, File, session, final, Situation).

:- begin_tests(strategies_to_copy).

test(each_finds_the_pose_in_mild_light,
     [forall(member(Name, [one_light_at_a_time, bracket, rules, second_opinion, other_parameters, look_again])), nondet]) :-
    in_world_with([], Name, Situation),
    situation_holds(converged, Situation).
test(each_ends_when_no_pose_can_be_had,
     [forall(member(Name, [one_light_at_a_time, bracket, rules, second_opinion, other_parameters, look_again])), nondet]) :-
    in_world_with([threshold(1.0e-6), images(4)], Name, Situation),
    situation_holds(neg(converged), Situation),
    fluent_value(iteration, Situation, Taken),
    assertion(Taken =< 4).
test(bracket_keeps_the_light_and_uses_every_shutter, Lights == [[7, 7, 7]]) :-
    in_world_with([threshold(1.0e-6)], bracket, Situation),
    settings_taken(Situation, Settings),
    setof(Levels, S^A^member(settings(Levels, S, A), Settings), Lights),
    setof(S, L^A^member(settings(L, S, A), Settings), Shutters),
    assertion(length(Shutters, 5)).
test(rules_go_on_when_the_sun_changes, nondet) :-
    in_world_with([threshold(0.7), happens(sun_changed, i1)], rules, Situation),
    situation_holds(converged, Situation),
    situation_history(Situation, History),
    assertion(memberchk(sun_changed, History)).
test(second_opinion_measures_the_newest_image_alone, nondet) :-
    in_world_with([], second_opinion, Situation),
    situation_history(Situation, [_, estimate([Newest])|_]),
    fluent_value(image_set, Situation, [kept(Newest, _), _|_]).
test(the_last_look_is_under_the_settings_of_the_first_whose_lights_are_graded, First == Last) :-
    in_world_with([], look_again, Situation),
    settings_taken(Situation, Settings),
    Settings = [First|Others],
    last(Others, Last),
    assertion(First = settings([7, 5, 4], _, _)).
test(a_pose_that_one_image_shows_is_confirmed_by_that_image_again, Settings == [First, First]) :-
    in_world_with([threshold(99.0)], look_again, Situation),
    settings_taken(Situation, Settings),
    Settings = [First|_].
test(what_was_doubted_is_tested_before_the_last_look, nondet) :-
    in_world_with([happens(doubt(i2, light_dead(left)), i2)], look_again, Situation),
    settings_taken(Situation, [First, _, Test|Others]),
    assertion(Test = settings([0|_], _, _)),
    last(Others, First).
test(parameters_that_help_stay, Set == [refinement_scale_px-4.0]) :-
    in_world_with([threshold(2.0), cured_by(refinement_scale_px, 4.0)], other_parameters, Situation),
    situation_holds(converged, Situation),
    set_in(Situation, Set).
test(parameters_that_do_not_help_are_taken_back_on_the_same_image,
     Set == [refinement_scale_px-4.0, refinement_scale_px-1.0, edge_contrast_grey-4.0, edge_contrast_grey-0.0]) :-
    in_world_with([threshold(1.0e-6), images(1)], other_parameters, Situation),
    set_in(Situation, Set).
test(nothing_is_tuned_where_the_pose_is_trusted, Set == []) :-
    in_world_with([threshold(50)], other_parameters, Situation),
    set_in(Situation, Set).

:- end_tests(strategies_to_copy).

%   Parameters of the vision server in the order in which they were set.
set_in(Situation, Set) :-
    situation_history(Situation, Newest),
    findall(Name-Value, member(set_parameter(Name, Value), Newest), Back),
    reverse(Back, Set).
