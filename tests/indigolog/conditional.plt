:- module(test_indigolog_conditional, []).
:- use_module(library(plunit)).
:- use_module(library(apply), [exclude/3]).
:- use_module(library(lists), [member/2, reverse/2]).
:- use_module('../../indigolog/indigolog').
:- use_module('../../indigolog/tools/explain', [why/3]).
:- use_module(theory_text, [load_text/1]).

/** <module> Conditional plans: what happens to them when the world does something else; options of achieve */

load(Name) :-
    module_property(test_indigolog_conditional, file(Here)),
    file_directory_name(Here, Folder),
    atomic_list_concat([Folder, '/theories/', Name, '.pl'], File),
    load_theory(File).

% The world: what is sensed, and happening(Action, Event): after Action comes Event.
:- dynamic sensed/2, happening/2.

errand:can_execute(_).
errand:execute(A, Result) :-
    ( retract(test_indigolog_conditional:sensed(A, R)) -> Result = R ; Result = none ),
    forall(retract(test_indigolog_conditional:happening(A, Event)),
           assertz(test_indigolog_conditional:happening(now, Event))).
errand:exogenous(Events) :-
    findall(E, retract(test_indigolog_conditional:happening(now, E)), Events).

% run(+Program, +World, -Actions, -Outcome)
run(Program, World, Actions, Outcome) :-
    retractall(sensed(_, _)),
    retractall(happening(_, _)),
    forall(member(A-R, World),
           (   R = event(E) -> assertz(happening(A, E)) ; assertz(sensed(A, R)) )),
    indigolog(Program, [device(errand), history(History), outcome(Outcome)]),
    reverse(History, Trace),
    exclude([e(_, _)]>>true, Trace, Actions).

:- begin_tests(conditional_monitoring, [setup(load(errand))]).

test(as_planned, Actions-Outcome == [feel(front), go(front), deliver]-final) :-
    run(searchc(errand), [feel(front)-open], Actions, Outcome).

test(other_branch, Actions-Outcome == [feel(front), go(back), deliver]-final) :-
    run(searchc(errand), [feel(front)-shut], Actions, Outcome).

% The door falls shut after it was felt: round the back.
test(repaired_after_an_event, Actions-Outcome == [feel(front), slam(front), go(back), deliver]-final) :-
    run(searchc(errand), [feel(front)-open, feel(front)-event(slam(front))], Actions, Outcome).

test(an_event_that_does_not_matter, Actions-Outcome == [feel(front), rain, go(front), deliver]-final) :-
    run(searchc(errand), [feel(front)-open, feel(front)-event(rain)], Actions, Outcome).

% What has been done is not done again.
test(only_what_is_left, Actions-Outcome == [feel(front), go(front), lose, fetch, deliver]-final) :-
    run(searchc(errand), [feel(front)-open, go(front)-event(lose)], Actions, Outcome).

test(beyond_repair, Actions-Outcome == [feel(front), slam(front), slam(back)]-failed) :-
    run(searchc(errand), [feel(front)-open, feel(front)-event(slam(front)), feel(front)-event(slam(back))], Actions, Outcome).

% No branch was planned for a result that sensing/2 does not list.
test(unforeseen_result, Actions-Outcome == [feel(front), go(back), deliver]-final) :-
    run(searchc(errand), [feel(front)-stuck], Actions, Outcome).

test(after_the_last_action, Actions-Outcome == [go(back), deliver, recall, deliver]-final) :-
    run(achieve(delivered, 4, [actions([go(_), deliver])]), [deliver-event(recall)], Actions, Outcome).

test(achieve_is_repaired, Actions-Outcome == [go(back), lose, fetch, deliver]-final) :-
    run(achieve(delivered, 4, [actions([go(_), fetch, deliver])]), [go(back)-event(lose)], Actions, Outcome).

% Beside another program, whose actions are not its own.
test(beside_another_program, Actions-Outcome == [feel(front), sing, go(front), deliver]-final) :-
    run(pconc([?(done(feel(front))), sing], searchc(errand)), [feel(front)-open], Actions, Outcome).

% The step of an action that fails has been made, as it has outside of plans; what follows is planned again.
door_theory("prim_action(go(_)). poss(go(_), true). rel_fluent(in). initially(in, false). causes_true(go(_), in, true).
             exog_action(failed(_, _)). execute(go(1), _) :- fail. execute(go(2), _).").

door(Program, History, Outcome, Rest, S) :-
    indigolog(Program, [check(false), history(History), outcome(Outcome), rest(Rest), situation(S)]).

test(an_action_that_fails, [setup(( door_theory(T), load_text(T) )), cleanup(load(errand)),
                            Outcome-History == final-[go(2), failed(go(1), golog(device_failed(theory, go(1))))]]) :-
    door(searchc([go(1), go(2)]), History, Outcome, _, _).

test(after_which_there_is_no_plan, [setup(( door_theory(T), load_text(T) )), cleanup(load(errand)),
        Outcome-Whys == failed-[no_plan(searchc(?(in)), failed(go(1), golog(device_failed(theory, go(1)))))]]) :-
    door(searchc([go(1), ?(in)]), _, Outcome, Rest, S),
    why(Rest, S, Whys).

:- end_tests(conditional_monitoring).

:- begin_tests(achieve, [setup(load(errand))]).

test(restricted, Actions-Outcome == [go(back), deliver]-final) :-
    run(achieve(delivered, 4, [id(by_the_back)]), [], Actions, Outcome).

test(simulated, all(H == [[deliver, go(garden), sim(unlock)]])) :-
    do(achieve(delivered, 2, [simid(gardener), actions([go(garden), deliver])]), [], H).

test(without_the_simulator, fail) :-
    do(achieve(delivered, 2, [actions([go(garden), deliver])]), [], _).

test(simulator_without_end, error(golog(simulator_loops(for_ever)))) :-
    do(achieve(delivered, 2, [simid(for_ever)]), [], _).

test(unknown_option, error(golog(achieve_option(deep(3))))) :-
    do(achieve(delivered, 2, [actions([deliver]), deep(3)]), [], _).

% The theory leaves the argument free: those of the list are meant.
test(actions_with_free_arguments, [setup(load_text("fun_fluent(at). initially(at, a). prim_action(go(_)). poss(go(_), true).
                                                    causes_val(go(X), at, X, true).")),
                                   cleanup(load(errand)), all(H == [[go(b)]])]) :-
    do(achieve(at = b, 1, [actions([go(c), go(b), go(_), go(b)])]), [], H).

test(each_plan_once, [setup(load_text("fun_fluent(n). initially(n, 0). prim_action(inc). poss(inc, true).
                                       causes_val(inc, n, N, N is n+1).")),
                      cleanup(load(errand)), all(H == [[inc, inc]])]) :-
    do(achieve(n = 2, 4, [actions([inc])]), [], H).

:- end_tests(achieve).
