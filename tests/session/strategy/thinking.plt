:- module(test_session_thinking, []).
:- use_module(library(plunit)).
:- use_module('../../../session/strategy/thinking').
:- use_module('../../../indigolog/online/devices', []).

/** <module> How long a strategy may compute between two actions, and what is said of it meanwhile */

computes(Seconds) :-
    statistics(cputime, Now),
    End is Now + Seconds,
    repeat,
    statistics(cputime, Then),
    Then >= End,
    !.

is_busy(Seconds) :-
    get_time(Now),
    End is Now + Seconds,
    repeat,
    get_time(Then),
    Then >= End,
    !.

this_file(File) :-
    module_property(test_session_thinking, file(File)).

within(Seconds, Goal) :-
    this_file(File),
    within_budget([quiet(true)], File, Seconds, Goal).

never_ends :-
    repeat,
    fail.

:- dynamic heard/1.

%   What is shown while Goal runs.
shown_meanwhile(Goal, Messages) :-
    retractall(heard(_)),
    this_file(File),
    setup_call_cleanup(asserta((user:message_hook(session(thinking(now, What)), _, _) :- assertz(test_session_thinking:heard(What))), Hook),
                       within_budget([], File, 10, Goal),
                       erase(Hook)),
    findall(What, heard(What), Messages).

:- dynamic
    removed/1,                          % Alarm, whose memory may be another's by now
    twice/1,
    sent/0.                             % the stop, once

%   A stop comes when an alarm has just been removed: as Ctrl-C does at any moment.
stopped_at_a_removal(Goal) :-
    retractall(removed(_)),
    retractall(twice(_)),
    retractall(sent),
    thread_self(Me),
    setup_call_cleanup(( wrap_predicate(time:remove_alarm(Old), test, Remove, test_session_thinking:remove(Me, Old, Remove)),
                         wrap_predicate(time:alarm(_, _, New, _), test, Set,
                                        ( Set, retractall(test_session_thinking:removed(New)) )) ),
                       catch(Goal, stopped, true),
                       ( unwrap_predicate(time:remove_alarm/1, test), unwrap_predicate(time:alarm/4, test) )).

remove(Me, Alarm, Remove) :-
    (   removed(Alarm)
    ->  assertz(twice(Alarm))
    ;   Remove,
        assertz(removed(Alarm)),
        (   sent
        ->  true
        ;   assertz(sent),
            thread_signal(Me, throw(stopped))
        )
    ).

:- begin_tests(thinking).

test(a_test_that_never_ends_is_said, error(usage_error(_))) :-
    catch(within(0.3, never_ends), error(usage_error(Message), _),
          ( assertion(sub_string(Message, _, _, _, "thinking.plt:31: the strategy has computed for 0.3 s in never_ends/0 without an action")),
            throw(error(usage_error(Message), _)) )).
test(each_action_gives_it_its_time_again) :-
    within(0.4, forall(between(1, 4, _), ( computes(0.2), note_thought ))).
test(nothing_is_looked_at_afterwards) :-
    within(0.2, true),
    computes(0.5).
test(an_error_goes_on, throws(own)) :-
    within(10, throw(own)).
test(what_takes_long_is_told_once_with_its_place, true(Messages = [computing(Place, ' in is_busy/1')])) :-
    shown_meanwhile(is_busy(2.6), Messages),
    Messages = [computing(Place, _)|_],
    assertion(sub_atom(Place, _, _, 0, 'thinking.plt:16')).
test(what_is_waited_for_is_told, true(Messages == [wait])) :-
    shown_meanwhile(( b_setval(indigolog_waits, true), sleep(2.2), b_setval(indigolog_waits, false) ), Messages).
test(nothing_is_told_of_a_pause, true(Messages == [])) :-
    shown_meanwhile(apart_from_thought(sleep(2.2)), Messages).
test(a_stop_while_alarms_are_changed_has_none_removed_twice) :-
    stopped_at_a_removal(within(1, forall(between(1, 20, _), ( computes(0.1), note_thought )))),
    assertion(sent),
    assertion(\+ twice(_)).

:- end_tests(thinking).
