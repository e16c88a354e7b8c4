:- module(test_indigolog_executive, []).
:- use_module(library(plunit)).
:- use_module(library(lists), [append/3, reverse/2, numlist/3, member/2, memberchk/2]).
:- use_module(library(readutil), [read_file_to_string/3, read_file_to_terms/3]).
:- use_module(library(apply), [foldl/4]).
:- use_module(library(yall)).
:- use_module('../../indigolog/indigolog').
:- use_module('../../indigolog/online/journal').

/** <module> Devices, events, failures, stopping, and the journal of a run */

:- dynamic seen/1, arriving/1.

load :-
    module_property(test_indigolog_executive, file(Here)),
    file_directory_name(Here, Folder),
    atom_concat(Folder, '/theories/lights.pl', File),
    load_theory(File).

fresh :-
    retractall(seen(_)),
    retractall(arriving(_)).

trace(Program, Options, Trace) :-
    indigolog(Program, [check(false), history(History)|Options]),
    reverse(History, Trace).

:- multifile user:message_hook/3.

user:message_hook(golog(device_left(Device)), warning, _) :-
    assertz(test_indigolog_executive:seen(left(Device))).

asleep:can_execute(_).
asleep:execute(_, _) :- shell('sleep 5').

seen_all(All) :-
    findall(X, seen(X), All).

% A device that remembers who called it, and tells of what is arriving.
worker:can_execute(_).
worker:execute(look, ajar) :- !.
worker:execute(switch(b), _) :- !, throw(error(lamp_broken, _)).
worker:execute(switch(c), _) :- !, sleep(20).
worker:execute(A, _) :-
    thread_self(Id),
    ( Id == main -> Who = main ; Who = other ),
    assertz(test_indigolog_executive:seen(A-Who)).
worker:exogenous(As) :-
    findall(A, retract(test_indigolog_executive:arriving(A)), As).
worker:resumed(Situation) :-
    situation_history(Situation, History),
    length(History, N),
    assertz(test_indigolog_executive:seen(resumed(N))).

hooked:can_execute(_).
hooked:execute(A, _) :- assertz(test_indigolog_executive:seen(A)).
hooked:started :- assertz(test_indigolog_executive:seen(started)).
hooked:stopped :- assertz(test_indigolog_executive:seen(stopped)).

broken:can_execute(_).
broken:execute(_, _).
broken:started :- throw(error(cannot_start, _)).

faulty:can_execute(_).
faulty:execute(_, _).
faulty:exogenous(_) :- throw(error(sensor_lost, _)).

refusing:can_execute(_).
refusing:execute(_, _) :- fail.

% Reports events from its own action.
reporting:can_execute(_).
reporting:execute(_, _) :-
    forall(between(1, 100, N), report_exogenous(numbered(N))).

:- begin_tests(devices, [setup(load), cleanup(fresh)]).

test(in_the_thread_of_the_program, [setup(fresh), Seen == [inc-main]]) :-
    trace(inc, [device(worker)], [inc]),
    seen_all(Seen).

test(in_its_own_thread, [setup(fresh), Seen == [inc-other, inc-other]]) :-
    trace([inc, inc], [device(worker, [])], [inc, inc]),
    seen_all(Seen).

test(senses_from_its_thread, Trace == [look, e(look, ajar), inc]) :-
    trace([look, ?(door = ajar), inc], [device(worker, [])], Trace).

test(events_from_its_thread, Trace == [bump, bump, inc]) :-
    fresh,
    assertz(test_indigolog_executive:arriving(bump)),
    assertz(test_indigolog_executive:arriving(bump)),
    trace([while(counter < 20, wait), inc], [device(worker, []), max_wait(60)], Trace).

test(failure_from_its_thread, Trace == [failed(switch(b), lamp_broken), inc]) :-
    trace([switch(b), inc], [device(worker, [])], Trace).

test(no_answer, [forall(member(Device, [device(worker, [deadline(0.5)]), device(worker)])),
                 Trace == [failed(switch(c), golog(deadline(switch(c), 0.5))), inc]]) :-
    trace([switch(c), inc], [Device, deadline(0.5)], Trace).

test(a_device_that_fails, Trace == [failed(inc, golog(device_failed(refusing, inc)))]) :-
    trace(inc, [device(refusing, [])], Trace).

% An error says in which program and after which actions.
test(where_it_was, History-Said == [inc]-true) :-
    catch(trace([inc, ?(nonsense(1)), inc], [device(hooked)], _), Error, true),
    Error = error(_, golog(at(_, History), _)),
    once(phrase(prolog:message(Error), Lines)),
    with_output_to(string(Text), print_message_lines(current_output, '', Lines)),
    (   sub_string(Text, _, _, _, "  in [?(nonsense(1)),inc]\n  after 1 actions, newest first [inc]\n")
    ->  Said = true
    ;   Said = Text
    ).

test(hooks, [forall(member(Device, [device(hooked), device(hooked, [])])), setup(fresh),
             Seen == [started, inc, stopped]]) :-
    trace(inc, [Device], [inc]),
    seen_all(Seen).

test(stopped_after_an_error, [setup(fresh), Seen == [started, inc, stopped]]) :-
    catch(trace([inc, ?(false)], [device(hooked, [])], _), error(golog(program_ended(_, _, _)), _), true),
    seen_all(Seen).

test(cannot_start, [forall(member(Device, [device(broken), device(broken, [])])), error(cannot_start)]) :-
    trace(inc, [Device], _).

test(the_others_are_stopped, [setup(fresh), Seen == [started, stopped]]) :-
    catch(trace(inc, [device(hooked, []), device(broken, [])], _), error(cannot_start, _), true),
    seen_all(Seen).

test(events_that_cannot_be_had, [forall(member(Device, [device(faulty), device(faulty, [])])), error(sensor_lost)]) :-
    trace(while(true, [wait]), [Device], _).

test(not_a_device, error(golog(no_device(nobody, can_execute/1)))) :-
    trace(inc, [device(nobody)], _).

test(unknown_option, [forall(member(Option, [max_action(3), device(worker, [timeout(3)])])), error(golog(unknown_option(_)))]) :-
    trace(inc, [Option], _).

test(no_thread_is_left, After == Before) :-
    findall(T, thread_property(T, status(_)), Before),
    trace(inc, [device(worker, []), device(hooked, [])], _),
    findall(T, thread_property(T, status(_)), After).

% A device that no signal reaches, since it waits in C: the run ends all the same, and says so.
test(left_behind, [setup(retractall(test_indigolog_executive:seen(_))),
                   Trace-All == [failed(inc, golog(deadline(inc, 1)))]-[left(asleep)]]) :-
    trace(inc, [device(asleep, [deadline(1)])], Trace),
    seen_all(All).

:- end_tests(devices).

%   Another thread does not know when the run begins.
until_heard(Goal) :-
    (   catch(Goal, error(golog(nothing_runs(_)), _), fail)
    ->  true
    ;   sleep(0.01),
        until_heard(Goal)
    ).

until_ended(Goal) :-
    until_heard(Goal),
    repeat,
    sleep(0.1),
    catch(( Goal, fail ), error(golog(nothing_runs(_)), _), true),
    !.

:- begin_tests(events, [setup(load), cleanup(fresh)]).

test(in_order_and_none_lost, Numbers == Expected) :-
    numlist(1, 100, Expected),
    trace([inc, ?(counter = 1)], [device(reporting, [])], Trace),
    findall(N, member(numbered(N), Trace), Numbers).

% What comes before `wait` has begun is not what it waits for, so it is reported again and again.
test(from_another_thread, [true(memberchk(inc, Rest)), nondet]) :-
    thread_create(until_ended(report_exogenous(waiting, bump)), Id),
    call_cleanup(trace([wait, inc], [run(waiting), device(hooked), max_wait(60)], Trace), thread_join(Id, _)),
    Trace = [bump|Rest].

test(nobody_listens, error(golog(nothing_runs(bump)))) :-
    report_exogenous(bump).

test(nothing_happens, error(golog(nothing_happened(0.05)))) :-
    trace(wait, [device(hooked), max_wait(0.05)], _).

:- end_tests(events).

:- begin_tests(stopping, [setup(load), cleanup(fresh)]).

after_three(Goal, inc, Situation) :-
    (   fluent_value(counter, Situation, 3)
    ->  call(Goal)
    ;   true
    ).

test(stop, throws(stopped(enough))) :-
    trace(star(inc), [device(hooked), on_action(plunit_stopping:after_three(request_stop(enough)))], _).

test(abort, Outcome-Trace == aborted-[inc, inc, inc]) :-
    trace(while(true, inc), [device(hooked), outcome(Outcome), on_action(plunit_stopping:after_three(request_abort))], Trace).

test(stop_while_waiting, throws(stopped(by_signal))) :-
    thread_create(( until_heard(report_exogenous(waiting, bump)), request_stop(by_signal) ), Id),
    call_cleanup(trace([wait, wait], [run(waiting), device(hooked)], _), thread_join(Id, _)).

test(facts, Facts == [executed(0, look, ajar), exogenous(1, bump), executed(1, inc, none)]) :-
    fresh,
    trace([look, inc], [device(worker), on_fact(plunit_stopping:noted)], _),
    findall(F, seen(fact(F)), Facts).

noted(Fact, _) :-
    assertz(test_indigolog_executive:seen(fact(Fact))),
    (   Fact = executed(0, _, _)
    ->  assertz(test_indigolog_executive:arriving(bump))
    ;   true
    ).

test(rest_of_the_program, Rest == [inc]) :-
    indigolog([inc, ?(false), inc], [check(false), device(hooked), outcome(failed), rest(All)]),
    All = [_|Rest].

:- end_tests(stopping).

:- begin_tests(journal, [setup(load), cleanup(fresh)]).

program([inc, look, switch(b), rndet(switch(a), put(k, 1)), inc]).

written(File) :-
    program(Program),
    fresh,
    assertz(test_indigolog_executive:arriving(bump)),
    trace(Program, [device(worker), journal(File), seed(3)], _).

test(one_fact_an_event, [setup(tmp_file(journal, File)), cleanup(delete_file(File)),
                         Facts = [begun(_, 3), exogenous(0, bump), executed(0, inc, none), executed(1, look, ajar),
                                  failed(2, switch(b), lamp_broken), executed(3, _, none),
                                  executed(4, inc, none), ended(final)]]) :-
    written(File),
    read_file_to_terms(File, Facts, []).

% cut(+File, +Lines, +Rest): only the first Lines lines, and Rest after them.
cut(File, N, Rest) :-
    read_file_to_string(File, Text, []),
    split_string(Text, "\n", "", Lines),
    length(First, N),
    append(First, _, Lines),
    setup_call_cleanup(open(File, write, Out),
                       ( forall(member(Line, First), (write(Out, Line), nl(Out))), write(Out, Rest) ),
                       close(Out)).

% Wherever a run is killed, even in the middle of a line, it ends as it would have.
test(resumed_from_anywhere, [forall(between(1, 7, N)), setup(tmp_file(journal, File)), cleanup(delete_file(File)),
                             Again == Whole]) :-
    program(Program),
    written(File),
    trace(Program, [replay(File)], Whole),
    cut(File, N, "exec"),
    fresh,
    ( N < 2 -> assertz(test_indigolog_executive:arriving(bump)) ; true ),
    trace(Program, [device(worker), resume(File), journal(File)], Again),
    trace(Program, [replay(File)], Again).

test(device_takes_over, [forall(member(Lines-N, [2-1, 4-4])), setup(tmp_file(journal, File)),
                         cleanup(delete_file(File)), First == resumed(N)]) :-
    program(Program),
    written(File),
    cut(File, Lines, ""),
    fresh,
    trace(Program, [device(worker), resume(File)], _),
    seen_all([First|_]).

test(replay_calls_no_device, [setup(tmp_file(journal, File)), cleanup(delete_file(File)),
                              Outcome-Seen-Same == replayed-[]-true]) :-
    program(Program),
    written(File),
    read_file_to_string(File, Before, []),
    fresh,
    trace(Program, [device(worker), replay(File), outcome(Outcome), journal(File)], _),
    seen_all(Seen),
    read_file_to_string(File, After, []),
    ( Before == After -> Same = true ; Same = false ).

% Whatever is there when a follower looks, and half a line at a time.
test(a_journal_that_grows_is_followed, [forall(between(1, 6, N)), setup(tmp_file(journal, File)),
                                        cleanup(delete_file(File)), Followed-Outcome == Whole-replayed]) :-
    program(Program),
    written(File),
    read_file_to_string(File, Text, []),
    trace(Program, [replay(File)], Whole),
    cut(File, N, ""),
    size_file(File, Bytes),
    sub_string(Text, Bytes, _, 0, Rest),
    nb_setval(test_to_come, Rest),
    context_module(Here),
    trace(Program, [replay(File), follow(Here:grown(File)), outcome(Outcome)], Followed).

grown(File, _, _) :-
    nb_getval(test_to_come, Rest),
    Rest \== "",
    string_length(Rest, Length),
    Part is min(Length, 17),
    sub_string(Rest, 0, Part, _, Now),
    sub_string(Rest, Part, _, 0, Later),
    nb_setval(test_to_come, Later),
    setup_call_cleanup(open(File, append, Out), write(Out, Now), close(Out)).

test(another_program, [setup(tmp_file(journal, File)), cleanup(delete_file(File)), error(golog(other_program(File, _)))]) :-
    written(File),
    trace(inc, [device(worker), resume(File)], _).

test(another_theory_of_what_happened, [setup(tmp_file(journal, File)), cleanup(delete_file(File)),
                                       error(golog(journal_differs(executed(0, look, none), _)))]) :-
    setup_call_cleanup(open(File, write, Out),
                       format(Out, "begun(inc,1).~nexecuted(0,look,none).~n", []),
                       close(Out)),
    trace(inc, [device(worker), resume(File)], _).

test(a_line_that_is_no_fact, [setup(tmp_file(journal, File)), cleanup(delete_file(File)), error(golog(journal(File, 2)))]) :-
    setup_call_cleanup(open(File, write, Out),
                       format(Out, "begun(inc,1).~nexecuted(0,~nended(final).~n", []),
                       close(Out)),
    trace(inc, [device(worker), resume(File)], _).

test(no_journal, error(golog(no_journal('/nowhere/at/all')))) :-
    trace(inc, [device(worker), resume('/nowhere/at/all')], _).

% The same command again must not spoil what the first left behind.
test(not_written_twice, [setup(tmp_file(journal, File)), cleanup(delete_file(File)), true(After == Before)]) :-
    written(File),
    read_file_to_string(File, Before, []),
    catch(( written(File), fail ), error(golog(journal_exists(File)), _), true),
    read_file_to_string(File, After, []).

% Killed while it wrote the first line.
test(not_yet_begun, [forall(member(Start, ["", "beg", "begun(in"])), setup(tmp_file(journal, File)), cleanup(delete_file(File)),
                     Facts = [begun(inc, 1), executed(0, inc, none), ended(final)]]) :-
    setup_call_cleanup(open(File, write, Out), write(Out, Start), close(Out)),
    fresh,
    trace(inc, [device(worker), journal(File), seed(1)], _),
    read_file_to_terms(File, Facts, []).

test(a_file_of_something_else, [setup(tmp_file(journal, File)), cleanup(delete_file(File)), error(golog(journal_exists(File)))]) :-
    setup_call_cleanup(open(File, write, Out), write(Out, "notes"), close(Out)),
    trace(inc, [device(worker), journal(File)], _).

test(a_refused_resume_writes_nothing, [setup(tmp_file(journal, File)), cleanup(delete_file(File)), true(After == Before)]) :-
    setup_call_cleanup(open(File, write, Out),
                       format(Out, "begun(inc,1).~nexecuted(0,look,none).~n", []),
                       close(Out)),
    read_file_to_string(File, Before, []),
    catch(( trace(inc, [device(worker), resume(File), journal(File)], _), fail ),
          error(golog(journal_differs(_, _)), _), true),
    read_file_to_string(File, After, []).

% Killed before the first action.
test(begun_once, [setup(tmp_file(journal, File)), cleanup(delete_file(File)),
                  Facts == [begun(inc, 1), executed(0, inc, none), ended(final)]]) :-
    setup_call_cleanup(open(File, write, Out), format(Out, "begun(inc,1).~n", []), close(Out)),
    fresh,
    trace(inc, [device(worker), resume(File), journal(File)], _),
    read_file_to_terms(File, Facts, []).

% As of a procedure that calls ever deeper: Prolog cannot write all of it.
test(an_error_that_is_too_deep, [setup(tmp_file(journal, File)), cleanup(delete_file(File)), true(Facts = [begun(inc, 1), ended(error(_))])]) :-
    length(Wraps, 30_000),
    foldl([_, Term, s(Term)]>>true, Wraps, 0, Deep),
    journal_open(File, 0, Journal),
    journal_write(Journal, begun(inc, 1)),
    journal_write(Journal, ended(error(Deep))),
    journal_close(Journal),
    read_file_to_terms(File, Facts, []).

test(a_full_disk, [condition(exists_file('/dev/full')), error(golog(journal_not_written('/dev/full', _)))]) :-
    trace(inc, [device(hooked), journal('/dev/full')], _).

:- end_tests(journal).
