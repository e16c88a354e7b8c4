:- module(test_merit, []).
:- use_module(library(plunit)).
:- use_module('../../domain/reasoning/merit').

fix(Rms, Uncertainty, Score, fix(pose([0, 0, 0], [0, 0, 1]), [], quality(Rms, Uncertainty, 1.0, Score, 0.0), [])).

%   A pose that would have that score by itself, beside another one.
beside(Chance, Alone, fix(pose([0, 0, 0], [0, 0, 1]), [], quality(0.1, 0.001, 1.0, Score, Chance), [])) :-
    Score is Alone / (1 + Chance).

:- begin_tests(merit).

test(none_is_worst, Merit =:= Worst) :-
    worst_merit(Worst),
    merit(none, Merit).
test(is_doubt_alone, true(abs(Merit - 0.75) < 1.0e-9)) :-
    fix(0.4, 0.001, 0.95, Fix),
    merit(Fix, Merit).
test(never_worse_than_none, true(Merit < Worst)) :-
    worst_merit(Worst),
    fix(0.2, 10.0, 0.0, Fix),
    merit(Fix, Merit).
test(a_pose_that_is_wrong_once_in_ten_is_not_trusted, true(Merit > Threshold)) :-
    default_threshold(Threshold),
    fix(0.1, 0.0, 0.9, Fix),
    merit(Fix, Merit).
test(better_by_two_percent_is_better) :-
    fix(1.0, 0.0, 0.9, Fix),
    improves(Fix, 1.536).
test(better_by_one_percent_is_not, fail) :-
    fix(1.0, 0.0, 0.9, Fix),
    improves(Fix, 1.515).

test(another_pose_holds_back_what_it_alone_would_keep_from_trust, Held == [0.08, 0.5]) :-
    findall(Chance, ( member(Chance, [0.0, 0.05, 0.08, 0.5]), beside(Chance, 0.99, Fix), held_back(Fix, 1.0, Chance) ), Held).
test(a_pose_that_would_not_be_trusted_by_itself_is_not_held_back, fail) :-
    beside(0.5, 0.9, Fix),
    held_back(Fix, 1.0, _).
test(another_pose_that_is_as_likely_as_before_still_holds_back, Held == [0.0995, 0.1, 0.2]) :-
    findall(Chance, ( member(Chance, [0.05, 0.08, 0.0995, 0.1, 0.2]), beside(Chance, 0.99, Fix), still_held_back(Fix, 1.0, 0.1) ), Held).
test(nothing_is_still_held_back_at_once, fail) :-
    beside(0.5, 0.99, Fix),
    still_held_back(Fix, 1.0, none).

:- end_tests(merit).
