:- module(test_indigolog_border, []).
:- use_module(library(plunit)).
:- use_module(library(lists), [member/2]).
:- use_module('../../indigolog/indigolog').
:- use_module('../../indigolog/tools/checks', [program_problems/2]).
:- use_module(theory_text, [load_text/1]).

/** <module> What comes from outside is refused where it comes in: from devices, options, histories, programs */

load :-
    module_property(test_indigolog_border, file(Here)),
    file_directory_name(Here, Folder),
    atom_concat(Folder, '/theories/lights.pl', File),
    load_theory(File).

% What the device reports, and what it senses; `fails` where it fails.
:- dynamic reporting/1, sensing/1.

says:can_execute(_).
says:execute(_, Result) :- test_indigolog_border:sensing(R), ( nonvar(R), R = throws(E) -> throw(error(E, _)) ; Result = R ).
says:exogenous(Actions) :- test_indigolog_border:reporting(As), As \== fails, Actions = As.

run(Program, Events, Sensed, Options) :-
    retractall(reporting(_)),
    retractall(sensing(_)),
    assertz(reporting(Events)),
    assertz(sensing(Sensed)),
    indigolog(Program, [check(false)|Options]).

:- dynamic ignored/1.

:- multifile user:message_hook/3.

user:message_hook(golog(undeclared_event(A)), warning, _) :-
    assertz(test_indigolog_border:ignored(A)).

:- begin_tests(border_of_devices, [setup(load)]).

test(reports, [forall(( member(Events, [nothing, [_], [numbered(_)], [bump|_], bump, fails]),
                        member(Device, [device(says), device(says, [])]) )),
               error(golog(no_events(says, _)))]) :-
    run([inc, wait], Events, none, [Device, max_wait(60)]).

test(sensing_result, History == [failed(look, golog(open_result(look)))]) :-
    run(look, [], f(_), [device(says), history(History)]).

test(no_sensing_result, History == [failed(look, golog(nothing_sensed(look)))]) :-
    run(look, [], _, [device(says), history(History)]).

test(what_is_open_in_an_error, History == [failed(look, lost(look, '_'))]) :-
    run(look, [], throws(lost(look, _)), [device(says), history(History)]).

test(reported_by_a_thread, error(golog(open_event(numbered(_))))) :-
    run(inc, [], none, [device(says), on_action([_, _]>>report_exogenous(numbered(_)))]).

test(reported_together, [forall(member(Events, [[bump], [], 3])), error(golog(no_event(Events)))]) :-
    run(inc, [], none, [device(says), on_action({Events}/[_, _]>>report_exogenous(Events))]).

% A device gives a list of them, and a list in it is none.
test(no_action_at_all, [forall(member(Event-Told, [3-3, []-[], [bump]-'[|]'(_, _)])), true(subsumes_term(Told, Ignored))]) :-
    retractall(test_indigolog_border:ignored(_)),
    run([inc, wait], [Event], none, [device(says), max_wait(60)]),
    findall(A, test_indigolog_border:ignored(A), [Ignored]).

test(exogenous_action_of_a_theory, [setup(load_text("prim_action(a). poss(a, true). exog_action(b(_)). exog_occurs(b(_)).
                                                     execute(_, _).")),
                                    cleanup(load), error(golog(open_event(b(_))), golog(world(exog_occurs(_)), _))]) :-
    indigolog([a, a]).

test(an_event_that_is_not_declared_is_said_once,
     [ setup(load_text("prim_action(a). poss(a, true). exog_occurs(b(1)). exog_occurs(_) :- fail. execute(_, _).")),
       cleanup(load), Ignored == [b(1)] ]) :-
    retractall(test_indigolog_border:ignored(_)),
    indigolog([a, a, a], [check(false)]),
    findall(A, test_indigolog_border:ignored(A), Ignored).

% A theory with a world of its own, beside devices that know nothing of it.
own_world("prim_action(look). poss(look, true). fun_fluent(seen). senses(look, seen). exog_action(rang).
           rel_fluent(heard). initially(heard, false). causes_true(rang, heard, true).
           :- dynamic said/0.
           exog_occurs(rang) :- \\+ said, assertz(said).
           execute(look, 7).").

apart:can_execute(_) :- fail.
apart:execute(_, _).

test(a_theory_s_own_world_is_asked_beside_devices, [setup(( own_world(Text), load_text(Text) )), cleanup(load),
                                                    History == [e(look, 7), look, rang]]) :-
    indigolog([?(heard), look], [check(false), device(apart), history(History)]).

test(an_error_in_a_theory_s_own_world_tells_where,
     [setup(load_text("prim_action(look). poss(look, true). fun_fluent(seen). senses(look, seen).
                       execute(look, X) :- X is 1 / 0.")),
      cleanup(load), error(evaluation_error(zero_divisor), golog(world(execute(look, _)), _))]) :-
    indigolog(look, [check(false), device(apart)]).

test(a_world_that_tells_no_result_tells_where,
     [ forall(member(Text-Error, ["_"-nothing_sensed(look), "f(_)"-open_result(look)])),
       setup(( format(string(Theory), "prim_action(look). poss(look, true). fun_fluent(seen). senses(look, seen).
                                       execute(look, ~s).", [Text]),
               load_text(Theory) )),
       cleanup(load), error(golog(Error), golog(world(execute(look, _)), _))]) :-
    indigolog(look, [check(false), device(apart)]).

test(a_world_that_fails_tells_where,
     [setup(load_text("prim_action(look). poss(look, true). fun_fluent(seen). senses(look, seen).
                       execute(look, _) :- fail.")),
      cleanup(load), error(golog(device_failed(theory, look)), golog(world(execute(look, _)), _))]) :-
    indigolog(look, [check(false), device(apart)]).

:- end_tests(border_of_devices).

:- begin_tests(border_of_runs, [setup(load)]).

wrong(Option) :-
    member(Option, [ deadline(soon), deadline(0), max_actions(-1), max_actions(many), max_actions(_), max_wait(-1), max_wait(x),
                     max_silent(-1), seed(x), check(maybe), journal(f(x)), journal(''), device(says, [thread(maybe)]),
                     device(says, [deadline(-1)]) ]).

test(option_values, [forall(wrong(Option)), error(golog(option_value(_, _)))]) :-
    run(inc, [], none, [device(says), Option]).

test(no_list_of_options, [forall(member(Options, [journal(x), [device(says)|x]])), error(type_error(list, _))]) :-
    indigolog(inc, Options).

test(no_list_of_device_options, error(type_error(list, deadline(3)))) :-
    run(inc, [], none, [device(says, deadline(3))]).

test(stepper, error(golog(unknown_option(replya(x))))) :-
    step_through(inc, [replya(x)]).

test(no_such_run, [forall(member(Goal, [request_stop(nobody, enough), request_abort(nobody)])), error(golog(no_run(nobody)))]) :-
    call(Goal).

% Prolog would be gone.
test(halt, [forall(member(Program, [?(halt), [inc, ?(halt(0))]])), error(golog(called_halt))]) :-
    run(Program, [], none, [device(says)]).

test(halt_at_loading, [error(golog(load(_, 1))), cleanup(load)]) :-
    load_text("prim_action(a). :- initialization(halt).").

:- end_tests(border_of_runs).

:- begin_tests(border_of_histories, [setup(load)]).

test(unknown_action, [forall(member(History-Entry, [[incc]-incc, [inc, incc, inc]-incc, [inc(1)]-inc(1), [inc, 3]-3])),
                      error(golog(unknown_entry(Entry)))]) :-
    holds(counter = 1, History).

test(wherever, [forall(member(Goal, [do(inc, [incc], _), do(inc, [incc], 3, _), trans(inc, [incc], _, _), final([], [incc]),
                                     explain(poss(inc), [incc])])),
                error(golog(unknown_entry(incc)))]) :-
    call(Goal).

test(open_action, error(golog(open_action(switch(_))))) :-
    holds(counter = 0, [switch(_)]).

test(open_history, [forall(member(History, [_, [inc|_]])), error(instantiation_error)]) :-
    do(inc, History, _).

% What the interpreter enters itself.
test(marks) :-
    holds(counter = 11, [wait, set(lit(a)), e(lit(b), true), test(counter = _), sim(bump), abort, inc, stop_interrupts]).

:- end_tests(border_of_histories).

:- begin_tests(border_of_programs, [setup(load)]).

wrong(prioritized_interrupts(interrupt(lit(a), inc)), no_list(_, _, _)).
wrong(rrobin(inc), no_list(_, _, _)).
wrong(case(look, if(open, inc)), no_list(_, _, _)).
wrong(pi(3, inc), no_variable(_, 3)).
wrong(pi([x, f(y)], [?(x = 1), inc]), no_variable(_, f(y))).
wrong(for(2, [1], inc), no_variable(_, 2)).
wrong(star(inc, many), no_count(_, _, many)).
wrong(star(inc, counter + 2), no_count(_, _, counter + 2)).
wrong(achieve(lit(a), many), no_count(_, _, many)).
wrong(time(inc, soon), no_seconds(_, _, soon)).
wrong(time(inc, -1), no_seconds(_, _, -1)).

test(arguments, [forall(wrong(Program, What)), true(subsumes_term(What, Found))]) :-
    program_problems(Program, [problem(error, _, _, Found)]).

% They are not known yet, or stand for what is picked.
test(not_known_yet, [forall(member(Program, [ pi(k, [1, 2], star(inc, k)), rrobin(_), rrobin([inc|_]), pi(_, inc),
                                              pi((r(_), [1]), inc), time(inc, _), star(inc, 2) ])),
                     true(Problems == [])]) :-
    program_problems(Program, Problems).

:- end_tests(border_of_programs).

:- begin_tests(border_of_the_stack, [setup(load)]).

% Every action leaves a choice open: told after seconds.
test(open_end, error(golog(open_end(_, 100_000)))) :-
    do([star(inc), ?(counter = -1)], [], _).

% What leaves none goes on.
test(long, true(N == 100_001)) :-
    once(do(while(counter < 100_001, inc), [], History)),
    length(History, N).

% What is long for a plan is said while it goes on.
test(longer, true(Said == [golog(long_execution(262_144))])) :-
    nb_setval(said, []),
    setup_call_cleanup(
        asserta((user:message_hook(Term, warning, _) :- nb_getval(said, Before), nb_setval(said, [Term|Before])), Hook),
        \+ do(while(true, inc), [], 262_200, _),
        erase(Hook)),
    nb_getval(said, Said).

% So does what has a limit.
test(long_with_choices, true(N == 100_001)) :-
    once(do(while(counter < 100_001, ndet(inc, bump)), [], 100_001, History)),
    length(History, N).

% Both answers to each question are open, so that the stack fills: told in time, and in a thread that has little of it.
test(no_end, [forall(member(Program, [[star(inc), ?(counter = -1)], [iconc(inc), ?(counter = -1)]])),
              true(subsumes_term(golog(no_end(_)), Formal))]) :-
    thread_create(catch(do(Program, [], _), error(Formal0, _), thread_exit(Formal0)), Id,
                  [stack_limit(40_000_000)]),
    thread_join(Id, exited(Formal)).

:- end_tests(border_of_the_stack).
