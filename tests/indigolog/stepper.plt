:- module(test_indigolog_stepper, []).
:- use_module(library(plunit)).
:- use_module('../../indigolog/indigolog').
:- use_module('../../indigolog/tools/stepper').
:- use_module(theory_text).

/** <module> A program step by step */

load :-
    module_property(test_indigolog_stepper, file(Here)),
    file_directory_name(Here, Folder),
    atom_concat(Folder, '/theories/lights.pl', File),
    load_theory(File).

answers(Program, Options, Commands, Answers) :-
    setup_call_cleanup(start_stepper(Program, Options, Stepper),
                       answers(Commands, Stepper, Answers),
                       stop_stepper(Stepper)).

answers([], _, []).
answers([C|Cs], Stepper, [A|As]) :-
    command(C, Stepper, Stepper1, A),
    answers(Cs, Stepper1, As).

last_answer(Program, Commands, Answer) :-
    answers(Program, [device(looking)], Commands, Answers),
    once(append(_, [Answer], Answers)).

looking:can_execute(look).
looking:execute(look, ajar).

% What is printed of it is not of interest.
silenced(Goal) :-
    setup_call_cleanup(asserta((user:message_hook(_, error, _) :- !), Ref), Goal, erase(Ref)).

:- begin_tests(stepper, [setup(load)]).

answer([inc, inc], [step], happened([inc])).
answer([inc, inc], [step, step, step], final).
answer([inc, ?(false)], [step, step], stuck([false(false, [])])).
answer(ndet(inc, switch(a)), [next], next([inc, switch(a)], no)).
answer(star(inc), [next], next([inc], may_end)).
answer([], [next], next([], may_end)).
answer(ndet(inc, switch(a)), [step(2), history], history([switch(a)])).
answer(ndet(inc, switch(a)), [step(3)], no_such_step(3)).
answer([inc, inc, inc], [run], ran([inc, inc, inc], final)).
answer([inc, inc, inc], [run(2)], ran([inc, inc], none)).
answer([inc, inc, inc], [run(2), program], program(inc)).
answer(inc, [fluents(counter)], fluents([counter-0])).
answer(inc, [step, fluents(counter)], fluents([counter-1])).
answer(inc, [fluents(lit)], fluents([lit(a)-false, lit(b)-false, lit(c)-false])).
answer(inc, [exog(bump), fluents(counter)], fluents([counter-10])).
answer(inc, [exog(inc)], not_exogenous(inc)).
answer(inc, [step, undo], undone(0)).
answer([inc, inc, inc], [run(2), exog(bump), undo, undo, history], history([])).
answer(inc, [undo], nothing_to_undo).
answer(inc, [test(counter = 0)], holds(counter = 0)).
answer(inc, [test(counter = 1)], why([false(counter = 1, [value(counter, 0)])])).
answer(?(lit(a)), [why], why([false(lit(a), [])])).
answer(inc, [why(poss(never))], why([impossible(never, [false(false, [])])])).
answer(look, [step, history], history([look, e(look, ajar)])).
answer([wait, inc], [step], waits).
answer([wait, inc], [exog(bump), step, step], happened([inc])).

test(answers, [forall(answer(Program, Commands, Expected)), Answer == Expected]) :-
    last_answer(Program, Commands, Answer).

test(each_fluent_once, Pairs == Once) :-
    last_answer(inc, [fluents], fluents(Pairs)),
    sort(Pairs, Sorted),
    length(Sorted, N),
    length(Once, N),
    append(Once, _, Pairs).

% Ever longer plans: the first is done, and of those that begin otherwise some are listed.
test(no_end_of_plans, [ setup(load_text("prim_action(up). poss(up, true). fun_fluent(floor). initially(floor, 0).
                                         causes_val(up, floor, N, N is floor + 1).
                                         proc(rise(N), while(floor < N, up)).
                                         proc(more(N), ndet(rise(N), pi(m, [?(m is N + 1), more(m)]))).")),
                        cleanup(load),
                        Happened-N-End == happened([up])-100-no ]) :-
    answers(search(more(1)), [], [next, step], [next_few(Actions, End), Happened]),
    length(Actions, N).

test(test_of_what_the_theory_does_not_have, error(golog(reported))) :-
    silenced(last_answer(inc, [test(nothere)], _)).

test(journal, [setup(tmp_file(journal, File)), cleanup(delete_file(File)),
               Answers == [happened([look]), fluents([door-ajar]), happened([bump]), ran([inc], final)]]) :-
    setup_call_cleanup(open(File, write, Out),
                       format(Out, "begun([look,inc],1).~nexecuted(0,look,ajar).~nexogenous(1,bump).~nexecuted(1,inc,none).~n", []),
                       close(Out)),
    answers([look, inc], [replay(File)], [step, fluents(door), step, run], Answers).

test(journal_of_something_else, [setup(tmp_file(journal, File)), cleanup(delete_file(File)),
                                 error(golog(journal_differs(executed(0, look, ajar), inc)))]) :-
    setup_call_cleanup(open(File, write, Out),
                       format(Out, "begun(look,1).~nexecuted(0,look,ajar).~n", []),
                       close(Out)),
    answers(inc, [replay(File)], [step], _).

:- end_tests(stepper).
