:- module(test_instead, []).
:- use_module(library(plunit)).
:- use_module(library(lists)).
:- use_module('../../domain/reasoning/instead').
:- use_module('../../domain/testing/simulated_world').

/** <module> One image under other settings than the strategy chose */

taken_instead(Words, Settings) :-
    setup_call_cleanup(
        set_instead(Words),
        in_world([threshold(1.0e-6), images(3), seed(4)], heuristic, session, final, Situation),
        set_instead(none)),
    settings_taken(Situation, Settings).

:- begin_tests(instead).

test(that_image_alone_is_taken_so) :-
    taken_instead(none, [First, Second, _]),
    taken_instead('i2: left 7 top 1, 1/60 s, f/4', [First, Other, _]),
    assertion(Other == settings([7, 0, 1], 0.0166667, 4.0)),
    assertion(Second \== Other).
test(all_spellings, [forall(member(Words-Expected,
                                   [ 'i12: left 1 right 2 top 3, 1/240 s, f/5.6'-settings([1, 2, 3], S, 5.6),
                                     'i1:top 7,0.5 s,f/4'-settings([0, 0, 7], 0.5, 4),
                                     'i1: 1/2 s, f/2.8'-settings([0, 0, 0], 0.5, 2.8),
                                     ' i1 : , 1/2 s , f/2.8 '-settings([0, 0, 0], 0.5, 2.8) ])), nondet]) :-
    S is 1 / 240,
    testbed(Device),
    instead_settings(Words, Device, Expected).
test(what_is_no_settings_is_none,
     [forall(member(Words, [ '', 'i1', 'left 7', 'i1: left, 1/60 s, f/4', 'i1: bottom 7, 1/60 s, f/4', 'i1: left 7, 1/0 s, f/4',
                             'i1: left 7, 1/60 s', 'i1: left 7, 1/60 s, f/4 and more', 'x1: left 7, 1/60 s, f/4' ])), fail]) :-
    testbed(Device),
    instead_settings(Words, Device, _).

:- end_tests(instead).
