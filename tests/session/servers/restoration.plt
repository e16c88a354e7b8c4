:- module(test_session_restoration, []).
:- use_module(library(plunit)).
:- use_module(library(lists), [append/3, last/2]).
:- use_module('../../../session/servers/restoration').

/** <module> What a vision server is told again */

lit(settings([7], 0.01, 4)).

% An image that is dropped after it was told that a light is dead before it.
history([ discard(i3, dark), surprise(i3, light_dead(left)), e(capture(i3, S), told(0, surprise(i3, light_dead(left)))),
          capture(i3, S),
          e(predict(device, [], [i1, i2]), []), set_parameter(population, 50), e(capture(i2, S), 0), capture(i2, S),
          e(predict(device, [], []), []), e(capture(i1, S), 0), capture(i1, S), connect ]) :-
    lit(S).

:- begin_tests(restoration).

test(what_is_told_is_in_order_of_time) :-
    history(Newest),
    told_again(Newest, [Set, Predicted, Happened, Discarded]),
    Set.parameters.population == 50,
    Predicted.predicted == true,
    Happened.happened.cause == light_dead,
    Happened.happened.since == i3,
    Discarded.discarded == i3.

test(what_was_published_with_an_image_is_told_of_it, Since-Cause == i2-target_moved) :-
    history(Newest),
    once(append(_, [e(capture(i2, S), 0)|Older], Newest)),
    told_again([target_moved, e(capture(i2, S), 0)|Older], Told),
    last(Told, Moved),
    _{since:Since, cause:Cause} :< Moved.happened.

% The session was killed between an image's answer and what it brought with it.
test(a_surprise_that_was_not_met_is_in_what_the_image_sensed, Event-Since == surprise(i3, light_dead(left))-i3) :-
    history([_, surprise(_, _)|Newest]),
    unmet_surprise(Newest, Event),
    told_again(Newest, Told),
    last(Told, Happened),
    Since = Happened.happened.since.
test(what_was_met_is_not_met_again, fail) :-
    history(Newest),
    unmet_surprise(Newest, _).
test(of_images_before_the_last_nothing_is_unmet, fail) :-
    history([_, surprise(_, _)|Newest]),
    lit(S),
    unmet_surprise([e(capture(i4, S), 0), capture(i4, S)|Newest], _).

:- end_tests(restoration).
