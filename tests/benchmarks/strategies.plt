:- module(test_benchmark_strategies, []).
:- use_module(library(plunit)).
:- use_module(library(lists)).
:- use_module('../../domain/testing/simulated_world').
:- use_module('../../indigolog/indigolog').

/** <module> `informed` without one of its ingredients does without it */

never(threshold(1.0e-6)).

ended(Name, Options, Situation) :-
    format(atom(File), "../../benchmarks/strategies/~w.pl", [Name]),
    in_world(Options, File, session, final, Situation).

first_settings(Situation, First) :-
    settings_taken(Situation, [First|_]).

informed_first(Seed, First) :-
    never(Never),
    in_world([Never, images(1), seed(Seed)], informed, session, final, Situation),
    first_settings(Situation, First).

:- begin_tests(benchmark_strategies).

test(a_random_first_image_hangs_on_the_seed, [true(First \== Other)]) :-
    never(Never),
    ended(random_first, [Never, images(1), seed(1)], One),
    ended(random_first, [Never, images(1), seed(2)], Two),
    first_settings(One, First),
    first_settings(Two, Other).
test(the_others_begin_with_the_safe_one, [forall(member(Name, [unpredicted, choosy, credulous, untested])), true(First == Safe)]) :-
    never(Never),
    informed_first(1, Safe),
    ended(Name, [Never, images(1), seed(2)], Situation),
    first_settings(Situation, First).
test(without_prediction_nothing_is_foreseen, Outlook == []) :-
    never(Never),
    ended(unpredicted, [Never, images(4)], Situation),
    fluent_value(outlook, Situation, Outlook).
test(what_is_choosy_drops_what_adds_nothing, Number == 1) :-
    never(Never),
    ended(choosy, [Never, images(4), useless], Situation),
    fluent_value(image_set, Situation, Set),
    length(Set, Number).
test(what_is_credulous_ends_with_one_image, Taken-Two == 1-2) :-
    Enough = threshold(50),
    ended(credulous, [Enough], Situation),
    fluent_value(taken, Situation, Taken),
    in_world([Enough], informed, session, final, Confirmed),
    fluent_value(taken, Confirmed, Two).
test(what_lasts_takes_all_images_it_may, [forall(member(Name, [lasting, lasting_unpredicted, lasting_random])), true(Taken-First == 5-Safe)]) :-
    informed_first(1, Safe),
    ended(Name, [threshold(50), images(5)], Situation),
    fluent_value(taken, Situation, Taken),
    first_settings(Situation, First).
test(what_lasts_foresees_only_where_it_is_said_to, Outlooks == [true, false, false]) :-
    findall(Foreseen,
            ( member(Name, [lasting, lasting_unpredicted, lasting_random]),
              ended(Name, [threshold(50), images(4)], Situation),
              fluent_value(outlook, Situation, Outlook),
              ( Outlook == [] -> Foreseen = false ; Foreseen = true ) ),
            Outlooks).
test(without_tests_a_doubt_is_not_looked_at_again, [true(Third \== First)]) :-
    never(Never),
    ended(untested, [Never, images(3), happens(doubt(i2, sun_changed), i2)], Situation),
    settings_taken(Situation, [First, _, Third]).

:- end_tests(benchmark_strategies).
