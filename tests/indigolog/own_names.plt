:- module(test_indigolog_own_names, []).
:- use_module(library(plunit)).
:- use_module(library(lists), [member/2, reverse/2]).
:- use_module('../../indigolog/indigolog').
:- use_module('../../indigolog/tools/checks').
:- use_module(theory_text).

/** <module> What a theory declares wins over what is built in, from the first use on */

own_set("prim_action(set(_)). prim_action(unset(_)). prim_action(k).
fun_fluent(x). fun_fluent(count).
poss(set(_), true). poss(unset(_), x = 5). poss(k, true).
causes_val(set(N), x, N, true).
causes_val(unset(_), x, 0, true).
causes_val(k, count, N, N is count + 1).
initially(x, 0). initially(count, 0).").

traces(Program, Traces) :-
    findall(Trace, ( do(Program, [], History), reverse(History, Trace) ), Traces).

answer([set(5), ?(x = 5), k], [[set(5), k]]).
answer([set(5), set(5), ?(x = 5), k], [[set(5), set(5), k]]).
answer([set(5), unset(1), ?(x = 0)], [[set(5), unset(1)]]).
answer([unset(1), ?(x = 0)], []).
answer([set(2 + count), ?(x = 2 + 0)], [[set(2 + 0)]]).

:- dynamic sent/1.

recording:can_execute(_).
recording:execute(A, _) :- assertz(test_indigolog_own_names:sent(A)).

nothing_sent :-
    retractall(sent(_)).

sent_actions(Sent) :-
    findall(A, sent(A), Sent).

:- begin_tests(own_names).

test(own_action, [forall(answer(Program, Expected)), Traces == [Expected, Expected, Expected]]) :-
    own_set(Text),
    load_text(Text),
    findall(Ts, ( member(_, [1, 2, 3]), traces(Program, Ts) ), Traces).

test(own_action_is_sent, [setup(nothing_sent), Sent == [set(5), k]]) :-
    own_set(Text),
    load_text(Text),
    indigolog([set(5), k], [device(recording)]),
    sent_actions(Sent).

test(built_in_is_not_sent, [setup(nothing_sent), Sent == [k]]) :-
    load_text("prim_action(k). poss(k, lit). rel_fluent(lit). initially(lit, false)."),
    indigolog([set(lit), k, unset(lit), ?(neg(lit))], [device(recording)]),
    sent_actions(Sent).

% An argument that is a fluent whose value is its own name stands for that value only while it has it.
test(fluent_as_an_argument, all(H == [[note(there), go(there), note(here)]])) :-
    load_text("prim_action(note(_)). prim_action(go(_)). fun_fluent(here).
poss(note(_), true). poss(go(_), true). causes_val(go(P), here, P, true). initially(here, here)."),
    do([note(here), go(there), note(here)], [], H).

reserved(e(_, _)).
reserved(sim(_)).
reserved(test(_)).
reserved(branch(_)).
reserved(stop_interrupts).

test(reserved, [forall(reserved(A)), true(Kinds == [error])]) :-
    format(string(Text), "prim_action(~p). poss(~p, true).", [A, A]),
    load_text(Text),
    problem_kinds(reserved(_), Kinds).

hidden(commit).
hidden(wait).
hidden(abort).
hidden(case(_, _)).
hidden(sync(_)).

test(hidden, [forall(( hidden(A), member(Form, ["prim_action(~p). poss(~p, true).", "proc(~p, []) :- ~p \\== a."]) )),
              true(Kinds == [warning])]) :-
    format(string(Text), Form, [A, A]),
    load_text(Text),
    problem_kinds(hidden(_), Kinds).

test(axiom_of_undeclared_set, true(Kinds == [error])) :-
    load_text("fun_fluent(x). initially(x, 0). causes_val(set(N), x, N, true)."),
    problem_kinds(unknown_action(_, _), Kinds).

problem_kinds(What, Kinds) :-
    theory_problems(Problems),
    findall(Kind, member(problem(Kind, _, _, What), Problems), Kinds).

:- end_tests(own_names).
