:- module(test_indigolog, []).
:- use_module(library(plunit)).
:- use_module(library(lists), [reverse/2, member/2]).
:- use_module('../../indigolog/indigolog').
:- use_module(theory_text).

/** <module> Every construct of the language, the projection of fluents and the online executive */

theory_file(File) :-
    module_property(test_indigolog, file(Here)),
    file_directory_name(Here, Folder),
    atom_concat(Folder, '/theories/lights.pl', File).

load :-
    theory_file(File),
    load_theory(File).

% traces(+Program, -Traces): all complete executions, oldest action first.
traces(Program, Traces) :-
    findall(Trace,
            ( do(Program, [], History), reverse(History, Trace) ),
            Traces0),
    sort(Traces0, Traces).

:- begin_tests(left_recursion, [setup(load_text("
prim_action(up).       poss(up, true).
prim_action(down).     poss(down, true).
proc(rise, ndet([], [rise, up])).
proc(lift, [rise, down]).
proc(right, ndet([], [up, right])).
proc(never, [never, up]).
proc(joint, sync([[joint, up]])).
"))]).

% Final of a procedure does not depend on whether it is asked for within its own Trans.
found(rise, [[], [up]]).
found(lift, [[down], [up, down]]).
found(right, [[], [up], [up, up]]).
found(never, []).
found(joint, []).

test(found, [forall(found(Program, Expected)), Traces == Expected]) :-
    findall(Trace, ( do(Program, [], 2, History), reverse(History, Trace) ), Traces0),
    sort(Traces0, Traces).

:- end_tests(left_recursion).

:- begin_tests(constructs, [setup(load)]).

construct([], [[]]).
construct([inc, switch(a)], [[inc, switch(a)]]).
construct(?(counter = 0), [[]]).
construct([inc, ?(counter = 0)], []).
construct(never, []).
construct(ndet(inc, switch(a)), [[inc], [switch(a)]]).
construct(wndet(never, inc), [[inc]]).
construct(wndet(inc, switch(a)), [[inc]]).
construct(rndet(inc, switch(a)), [[inc], [switch(a)]]).
construct(if(counter = 0, inc, switch(a)), [[inc]]).
construct(if(counter = 1, inc, switch(a)), [[switch(a)]]).
construct(while(counter < 3, inc), [[inc, inc, inc]]).
construct([star(inc, 2), ?(counter > 0)], [[inc], [inc, inc]]).
construct([pi(l, [?(lit(l)), switch(l)])], []).
construct([switch(b), pi(l, [?(lit(l)), switch(l)])], [[switch(b), switch(b)]]).
construct(pi((l, lamps), switch(l)), [[switch(a)], [switch(b)], [switch(c)]]).
construct(pi([x, y], [?(and(x = a, y = x)), switch(y)]), [[switch(a)]]).
construct(pi((r(l), [a, b]), switch(l)), [[switch(a)], [switch(b)]]).
construct(pi(L, [?(L = a), switch(L)]), [[switch(a)]]).
construct(rpi((l, lamps), switch(l)), [[switch(a)], [switch(b)], [switch(c)]]).
construct(pi((x, [a]), pi((x, [b]), switch(x))), [[switch(b)]]).
construct(pi((x, [b]), pi([(y, [x]), (x, [a])], [switch(y), switch(x)])), [[switch(b), switch(a)]]).
construct(pi((x, [b]), rpi([(y, [b]), (r(x), [a])], [switch(y), switch(x)])), [[switch(b), switch(a)]]).
construct(pi((x, [b]), ?(some([(y, [b]), (x, [a])], neg(x = y)))), [[]]).
construct(for(l, lamps, switch(l)), [[switch(a), switch(b), switch(c)]]).
construct(conc(inc, switch(a)), [[inc, switch(a)], [switch(a), inc]]).
construct(pconc(inc, switch(a)), [[inc, switch(a)]]).
construct(pconc([?(counter = 1), switch(a)], inc), [[inc, switch(a)]]).
construct([iconc(never), inc], [[inc]]).
construct(rconc(inc, switch(a)), [[inc, switch(a)], [switch(a), inc]]).
construct(rrobin([[inc, inc], switch(a)]),
          [[inc, inc, switch(a)], [inc, switch(a), inc], [switch(a), inc, inc]]).
construct(sync([[inc, inc], [inc, inc]]), [[inc, inc]]).
construct(sync([inc, switch(a)]), []).
construct(prioritized_interrupts([interrupt(counter < 2, inc)]),
          [[inc, inc, stop_interrupts]]).
construct(prioritized_interrupts([interrupt(counter = 1, [switch(a), inc]),
                                  interrupt(counter < 3, inc)]),
          [[inc, switch(a), inc, inc, stop_interrupts]]).
construct([switch(a), prioritized_interrupts([interrupt(l, lit(l), switch(l))])],
          [[switch(a), switch(a), stop_interrupts]]).
construct(gexec(counter < 2, [inc, inc, inc]), [[inc, inc]]).
construct(goal(counter = 1, [inc, inc], false, []), [[inc]]).
construct(goal(counter = 9, [inc, inc], counter = 1, switch(a)), [[inc, switch(a)]]).
construct(search([ndet(inc, switch(a)), ?(lit(a))]), [[switch(a)]]).
construct(inc_to(2), [[inc, inc]]).
construct(count_down(3), [[inc, inc, inc]]).
construct(loops, [[inc]]).
construct(star(?(true)), [[]]).
construct([inc, put(k, counter)], [[inc, put(k, 1)]]).

test(traces, [forall(construct(Program, Expected)), Traces == Expected]) :-
    traces(Program, Traces).

test(unknown_action, error(golog(unknown_action(nothing)))) :-
    do(nothing, [], _).

test(deterministic, true) :-
    do(inc_to(50), [], _).

% Whatever the encoding of the terminal and of this file.
test(theory_in_utf_8, H == ['gr\xf6\\xdf\er', 'sag \x6697\\x3044\']) :-
    load_text("prim_action(gr\xf6\\xdf\er). poss(gr\xf6\\xdf\er, true). prim_action('sag \x6697\\x3044\'). poss('sag \x6697\\x3044\', true).
               proc(both, ['sag \x6697\\x3044\', gr\xf6\\xdf\er])."),
    call_cleanup(do(both, [], H), load).

:- end_tests(constructs).

:- begin_tests(formulas, [setup(load)]).

formula(and(counter = 0, neg(lit(a))), [], true).
formula(and([true, counter < 1]), [], true).
formula(or([lit(a), counter = 0]), [], true).
formula(or(lit(a), lit(b)), [switch(b)], true).
formula(impl(lit(a), false), [], true).
formula(impl(lit(a), false), [switch(a)], false).
formula(some(l, lit(l)), [], false).
formula(some(l, lit(l)), [switch(c)], true).
formula(all((l, lamps), neg(lit(l))), [], true).
formula(all_lit, [switch(c), switch(b), switch(a)], true).
formula(all_lit, [switch(b), switch(a)], false).
formula(lit(a), [switch(a), switch(a)], false).
formula(lit(a), [all_off, switch(a)], false).
formula(member(2 + counter, [2 + 1]), [inc], true).
formula(counter * 2 =:= 4, [inc, inc], true).
formula(mark(some(term)) = [1, x], [put(some(term), [1, x])], true).
formula(mark(other) = none, [put(some(term), 1)], true).
formula(door = open, [], false).
formula(door = open, [e(look, open), look], true).
formula(done(inc), [inc], true).
formula(counter = 11, [bump, inc], true).

test(holds, [forall(formula(Formula, History, Expected)), Truth == Expected]) :-
    (   holds(Formula, History)
    ->  Truth = true
    ;   Truth = false
    ).

test(enumerates, all(L == [a, c])) :-
    holds(lit(L), [switch(c), switch(a)]).

:- end_tests(formulas).

:- dynamic seen/1, arriving/1, printed/1, catching/0.

:- multifile user:message_hook/3.

user:message_hook(golog(problem(_, _, _)), Kind, _) :-
    test_indigolog:catching,
    assertz(test_indigolog:printed(problem(Kind))).

catch_messages(Goal, Printed) :-
    retractall(seen(_)),
    retractall(printed(_)),
    setup_call_cleanup(assertz(catching), call(Goal), retractall(catching)),
    findall(P, printed(P), Printed).

:- begin_tests(online, [setup(load)]).

online(Program, Options, History) :-
    indigolog(Program, [check(false), history(History), device(test_device)|Options]).

test_device:can_execute(_).
test_device:execute(look, ajar) :- !.
test_device:execute(switch(b), _) :- !, throw(error(lamp_broken, _)).
test_device:execute(inc, _) :- !, assertz(test_indigolog:seen(inc)).
test_device:execute(_, none).
test_device:exogenous(As) :- findall(A, retract(test_indigolog:arriving(A)), As).

test(sensing, H == [inc, e(look, ajar), look]) :-
    online([look, ?(door = ajar), inc], [], H).

test(two_equal_events_are_two, H == [inc, bump, bump]) :-
    assertz(test_indigolog:arriving(bump)),
    assertz(test_indigolog:arriving(bump)),
    online([?(counter = 20), inc], [], H).

test(device_failure_is_an_event, H == [inc, failed(switch(b), lamp_broken)]) :-
    online([switch(b), inc], [], H).

% Mistakes are printed before anything happens, once for a theory.
test(checked_first, [setup(load), Reported-Printed == reported-[problem(warning), problem(error)]]) :-
    catch_messages(( catch(indigolog([inc, leap], [device(test_device)]), error(golog(Reported), _), true),
                     \+ test_indigolog:seen(inc) ),
                   Printed).

test(checked_once, [setup(load), Printed-More == [problem(warning)]-[]]) :-
    catch_messages(indigolog(inc, [device(test_device)]), Printed),
    catch_messages(indigolog(inc, [device(test_device)]), More).

test(stuck, error(golog(program_ended(failed, _, _)))) :-
    online([inc, ?(false)], [], _).

test(limit, Outcome-H == limit-[inc, inc]) :-
    online(star(inc), [max_actions(2), outcome(Outcome)], H).

test(step_before_end, H == [inc, inc]) :-
    online(star(inc, 2), [], H).

test(stop, throws(stopped(enough))) :-
    indigolog(star(inc), [check(false), device(test_device), on_action(test_indigolog:stop_now)]).

test(journal_resumes, [setup(tmp_file(journal, File)), cleanup(delete_file(File)), H-Again == [inc, inc]-[inc, inc]]) :-
    online([inc, inc], [journal(File), seed(5)], H),
    retractall(test_indigolog:seen(_)),
    online([inc, inc], [resume(File), journal(File)], Again),
    \+ test_indigolog:seen(_).

test(same_seed_same_choices, A == B) :-
    Program = for(i, [1, 2, 3, 4, 5, 6, 7, 8], [?(i > 0), rndet(inc, look)]),
    online(Program, [seed(7)], A),
    online(Program, [seed(7)], B).

:- end_tests(online).

:- public stop_now/2.

stop_now(_, _) :-
    request_stop(enough).
