:- module(test_session_plan, []).
:- use_module(library(plunit)).
:- use_module(library(lists), [last/2]).
:- use_module('../../../session/options/plan').

/** <module> Hold points that a target can come to */

reached(Options, Nearest, Contact) :-
    within_reach(Options, device{nearest_m:Nearest}, plan{program:session([1.5, 0.6, 0.3])}, Plan),
    Plan.program = session(Ranges),
    last(Ranges, Contact).

:- begin_tests(plan).

test(hold_points_stay_where_the_target_can_come_to_them, [forall(member(Nearest, [0.3, 0.1, null])), true(Contact == 0.3)]) :-
    reached([], Nearest, Contact).
test(those_that_no_one_asked_for_are_farther_for_a_large_target, true(Contact == 3.6)) :-
    reached([], 3.0, Contact).
test(those_that_were_asked_for_are_refused, throws(error(usage_error(_), _))) :-
    reached([contact_range(0.3)], 3.0, _).

:- end_tests(plan).
