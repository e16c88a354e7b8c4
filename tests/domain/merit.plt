:- module(test_merit, []).
:- use_module(library(plunit)).
:- use_module('../../domain/reasoning/merit').

fix(Rms, Uncertainty, Score, fix(pose([0, 0, 0], [0, 0, 1]), [], quality(Rms, Uncertainty, 1.0, Score, 0.0), [])).

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

:- end_tests(merit).
