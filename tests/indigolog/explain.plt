:- module(test_indigolog_explain, []).
:- use_module(library(plunit)).
:- use_module('../../indigolog/indigolog').
:- use_module('../../indigolog/tools/explain', [why/3]).
:- use_module('../../indigolog/language/history', [history_situation/2]).
:- use_module('../../indigolog/tools/effort', [found_within/5]).
:- use_module(library(lists), [member/2]).

/** <module> What stands in the way of actions, formulas, programs and plans */

load(Name) :-
    module_property(test_indigolog_explain, file(Here)),
    file_directory_name(Here, Folder),
    atomic_list_concat([Folder, '/theories/', Name, '.pl'], File),
    load_theory(File).

whys(Question, History, Whys) :-
    history_situation(History, S),
    why(Question, S, Whys).

text(Term, Text) :-
    once(phrase(prolog:message(Term), Lines)),
    with_output_to(string(Text), print_message_lines(current_output, '', Lines)).

:- begin_tests(explain, [setup(load(lights))]).

test(a_variable_without_a_value_is_said, Text == "action at(_) is not possible: a variable in it has no value, as nothing before it gives it one
  p(_,_) is false
    lit(_) = false
") :-
    text(golog(why([impossible(at(_), [false(p(_, _), [value(lit(_), false)])])])), Text).

test(a_loop_without_an_end_is_told_what_has_one, [forall(member(Error, [no_end(4096), open_end(100_000, 100_000)]))]) :-
    once(phrase('$messages':translate_message(error(golog(Error), _)), Lines)),
    with_output_to(string(Text), print_message_lines(current_output, '', Lines)),
    once(sub_string(Text, _, _, _, "while(neg(P), E) in place of [star(E), ?(P)]")).

test(a_long_value_is_cut_short, Shown == "f = [1,2,3,4,5,6,7,8,9,10,11|...]\n") :-
    numlist(1, 100, L),
    text(golog(why([value(f, L)])), Shown).

why(holds(counter > 3), [false(counter > 3, [value(counter, 0)])]).
why(holds(counter < 3), []).
why(holds(lit(a)), [false(lit(a), [])]).
why(holds(and(counter = 0, lit(b))), [false(and(counter = 0, lit(b)), [false(lit(b), [])])]).
why(holds(and(counter = 1, lit(b))), [false(and(counter = 1, lit(b)), [false(counter = 1, [value(counter, 0)])])]).
why(holds(or(lit(a), counter > 3)),
    [false(or(lit(a), counter > 3), [false(lit(a), []), false(counter > 3, [value(counter, 0)])])]).
why(holds(neg(counter = 0)), [false(neg(counter = 0), [true(counter = 0, [value(counter, 0)])])]).
why(holds(all((l, [a, b]), lit(l))), [false(all((l, [a, b]), lit(l)), [false(lit(a), [])])]).
why(holds(all_lit), [false(all_lit, [false(lit(a), [])])]).
why(holds(neg(some((l, [b, c]), neg(lit(l))))),
    [false(neg(some((l, [b, c]), neg(lit(l)))), [true(some((l, [b, c]), neg(lit(l))), [value(lit(b), false)])])]).
why(holds(some((l, [a, b]), lit(l))),
    [false(some((l, [a, b]), lit(l)), [false(lit(a), []), false(lit(b), [])])]).
why(holds(door = open), [false(door = open, [value(door, unknown)])]).
why(poss(inc), []).
why(poss(never), [impossible(never, [false(false, [])])]).
why(poss(switch(z)), [not_an_instance(switch(z))]).
why(poss(nothing), [undeclared(nothing)]).
why([?(counter = 0), ?(lit(a)), inc], [false(lit(a), [])]).
why(ndet(never, ?(lit(a))), [false(lit(a), []), impossible(never, [false(false, [])])]).
why(pi((l, [a, b]), [?(lit(l)), inc]), [false(lit(a), []), false(lit(b), [])]).
why(while(counter < 0, inc), [false(counter < 0, [value(counter, 0)])]).
why(prioritized_interrupts([interrupt(lit(a), inc)]), [false(lit(a), [])]).
why(if(lit(a), inc, never), [impossible(never, [false(false, [])])]).
why(inc, []).
why(atomic([?(lit(a)), inc]), [false(lit(a), [])]).
why(sync([inc, ndet(switch(a), [?(counter = 0), switch(b)])]),
    [apart([offer(inc, [inc]), offer(ndet(switch(a), [?(counter = 0), switch(b)]), [switch(a), switch(b)])])]).
why(sync([inc, []]), [apart([offer(inc, [inc]), offer([], [])])]).
why(sync([inc, [?(lit(a)), inc], [?(lit(b)), inc]]), [false(lit(a), []), false(lit(b), [])]).
why(sync([ndet(never, inc), inc]), []).
why(search([inc, sync([inc, never])]), [dead_end([inc], [impossible(never, [false(false, [])])])]).
why(searchc([inc, ?(lit(a))]), [no_step(searchc([inc, ?(lit(a))]))]).
why(case(look, [if(open, inc)]), [no_result(look)]).
why(set(lit(a)), []).
why(search([inc, ndet(switch(a), inc), ?(lit(b))]),
    [ dead_end([inc, switch(a)], [false(lit(b), [])]),
      dead_end([inc, inc], [false(lit(b), [])]) ]).
why(search([ndet(never, inc)]), []).

test(why, [forall(why(Question, Expected)), Whys == Expected]) :-
    whys(Question, [], Whys).

test(after_a_history, Whys == [false(counter > 3, [value(counter, 2)])]) :-
    whys(holds(counter > 3), [inc, inc], Whys).

% Alternatives that were rejected before the plan was found, and no more.
test(up_to_the_plan, Whys == [dead_end([switch(a)], [false(lit(b), [])])]) :-
    whys(search([ndet(switch(a), ndet(switch(b), inc)), ?(lit(b))]), [], Whys).

test(no_end_of_steps_without_an_action, Whys == [not_all([while(true, ?(true)), inc])]) :-
    whys([while(true, ?(true)), inc], [], Whys).

test(reads_well, Text == "and(counter<3,lit(b)) is false\n  lit(b) is false\n") :-
    whys(holds(and(counter < 3, lit(b))), [], Whys),
    text(golog(why(Whys)), Text).

test(what_each_can_do_reads_well,
     Text == "the programs of sync have no action in common\n  inc can do [inc]\n  [] can do nothing\n") :-
    whys(sync([inc, []]), [], Whys),
    text(golog(why(Whys)), Text).

test(nothing_to_explain, Text == "There is nothing to explain: it is so\n") :-
    text(golog(why([])), Text).

% The error of a program that got stuck says where.
test(error, Text == "the program ended as failed after 1 actions:\nlit(b) is false\n") :-
    catch(indigolog([inc, ?(lit(b))], [check(false), device(idle)]), error(golog(Formal), _), true),
    phrase(prolog:error_message(golog(Formal)), Lines),
    with_output_to(string(Text), print_message_lines(current_output, '', Lines)).

% What was sensed and tested is in the history as well, and is no action.
test(error_after_sensing, true(sub_string(Text, _, _, _, "after 2 actions:"))) :-
    catch(indigolog([inc, look, ??(true), ?(lit(b))], [check(false), device(idle)]), error(golog(Formal), _), true),
    phrase(prolog:error_message(golog(Formal)), Lines),
    with_output_to(string(Text), print_message_lines(current_output, '', Lines)).

idle:can_execute(_).
idle:execute(look, open) :- !.
idle:execute(_, none).

:- end_tests(explain).

                /* The limit on what an explanation costs */

counted(N) :-
    between(1, inf, N),
    findall(M, ( between(1, inf, M), M >= 50, ! ), [_|_]).

:- begin_tests(effort).

% Wherever the limit strikes, in an inner findall/3 too, the one around it has its one solution.
test(broken_off, [forall(between(2000, 2060, Limit)), true(Ends = [[1, 2|_]-false])]) :-
    findall(Found-Whole, found_within(Limit, N, test_indigolog_explain:counted(N), Found, Whole), Ends).

test(all_found, true(Found-Whole == [a, b]-true)) :-
    found_within(10_000, X, member(X, [a, b]), Found, Whole).

:- end_tests(effort).
