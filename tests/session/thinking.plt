:- module(test_session_thinking, []).
:- use_module(library(plunit)).
:- use_module('../../session/thinking').

/** <module> How long a strategy may compute between two actions */

computes(Seconds) :-
    statistics(cputime, Now),
    End is Now + Seconds,
    repeat,
    statistics(cputime, Then),
    Then >= End,
    !.

:- begin_tests(thinking).

test(a_test_that_never_ends_is_said, error(usage_error(Message))) :-
    catch(within_budget(mine, 0.3, ( repeat, fail )), error(usage_error(Message0), _),
          ( format(string(Message), Message0, []), throw(error(usage_error(Message), _)) )),
    assertion(sub_string(Message, _, _, _, "mine: the strategy has computed for 0.3 s without an action")).
test(each_action_gives_it_its_time_again) :-
    within_budget(mine, 0.4, forall(between(1, 4, _), ( computes(0.2), note_thought ))).
test(nothing_is_looked_at_afterwards) :-
    within_budget(mine, 0.2, true),
    computes(0.5).
test(an_error_goes_on, throws(own)) :-
    within_budget(mine, 10, throw(own)).

:- end_tests(thinking).
