:- module(test_merit, []).
:- use_module(library(plunit)).
:- use_module('../../domain/reasoning/merit').

fix(Rms, Uncertainty, Score, fix(pose([0, 0, 0], [0, 0, 1]), [], quality(Rms, Uncertainty, 1.0, Score, 0.0), [])).

:- begin_tests(merit).

test(none_is_worst, Merit =:= Worst) :-
    worst_merit(Worst),
    merit(none, Merit).
test(joins_error_uncertainty_and_doubt, true(abs(Merit - (0.25*0.4 + 0.2 + 0.5)) < 1.0e-9)) :-
    fix(0.4, 0.001, 0.95, Fix),
    merit(Fix, Merit).
test(never_worse_than_none, Merit =:= Worst) :-
    worst_merit(Worst),
    fix(0.2, 10.0, 1.0, Fix),
    merit(Fix, Merit).
test(no_term_alone_is_enough, [forall(member(Q, [q(0.0, 0.0, 0.85), q(0.0, 0.006, 1.0), q(4.5, 0.0, 1.0)]))]) :-
    default_threshold(Threshold),
    Q = q(Rms, Uncertainty, Score),
    fix(Rms, Uncertainty, Score, Fix),
    merit(Fix, Merit),
    assertion(Merit > Threshold).
test(better_by_two_percent_is_better) :-
    fix(1.0, 0.0, 1.0, Fix),
    improves(Fix, 0.256).
test(better_by_one_percent_is_not, fail) :-
    fix(1.0, 0.0, 1.0, Fix),
    improves(Fix, 0.2525).

:- end_tests(merit).
