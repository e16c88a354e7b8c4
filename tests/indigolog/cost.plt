:- module(test_indigolog_cost, []).
:- use_module(library(plunit)).
:- use_module('../../indigolog/indigolog').

/** <module> What a step costs depends on the axioms of its action, not on what went before or what else there is

Costs are inferences, which do not depend on the machine.
*/

load(Text) :-
    setup_call_cleanup(( tmp_file_stream(text, File, Out), close(Out) ),
                       ( setup_call_cleanup(open(File, write, Stream),
                                            format(Stream, "~s", [Text]),
                                            close(Stream)),
                         load_theory(File) ),
                       delete_file(File)).

count(`fun_fluent(counter). prim_action(inc). poss(inc, true).
       causes_val(inc, counter, N, N is counter + 1). initially(counter, 0).
       proc(count(N), while(counter < N, inc)).`).

beside_others(Codes) :-
    count(Count),
    append(Count, `\nfun_fluent(cell(I)) :- between(1, 10000, I). initially(cell(_), 0).`, Codes).

costless:can_execute(_).
costless:execute(_, none).

run(offline, Program) :-
    once(do(Program, [], _)).
run(online, Program) :-
    indigolog(Program, [device(costless)]).

per_step(Mode, N, Cost) :-
    run(Mode, count(N)),                  % initial values are remembered from here on
    statistics(inferences, Before),
    run(Mode, count(N)),
    statistics(inferences, After),
    Cost is (After-Before)/N.

per_program(Count, Cost) :-
    run(online, all(Count)),
    statistics(inferences, Before),
    run(online, all(Count)),
    statistics(inferences, After),
    Cost is (After-Before)/Count.

:- begin_tests(cost).

test(flat, [forall(member(Mode, [offline, online])), setup(( count(Text), load(Text) )), true(Long < 1.02*Short)]) :-
    per_step(Mode, 500, Short),
    per_step(Mode, 10_000, Long).

test(beside_ten_thousand_fluents, true(Many < 1.02*Few)) :-
    count(Count),
    load(Count),
    per_step(offline, 1000, Few),
    beside_others(Others),
    load(Others),
    per_step(offline, 1000, Many).

% Of programs side by side each step looks at each once.
test(beside_others_in_random_order, true(Many < 3*Few)) :-
    load(`fun_fluent(n(I)) :- between(1, 200, I). initially(n(_), 0).
          prim_action(inc(I)) :- between(1, 200, I). poss(inc(_), true).
          causes_val(inc(I), n(I), N, N is n(I) + 1).
          proc(all(Count), rconc(Es)) :- numlist(1, Count, Is), findall([inc(I), inc(I)], member(I, Is), Es).`),
    per_program(100, Few),
    per_program(200, Many).

% A step costs no more in a procedure that calls itself and goes on after that, however deep.
test(after_calls_of_itself, true(Many < 1.2*Few)) :-
    load(`fun_fluent(counter). prim_action(inc). poss(inc, true). causes_val(inc, counter, N, N is counter + 1).
          initially(counter, 0).
          proc(all(N), if(N = 0, [], [inc, pi(m, [?(m is N-1), all(m)]), inc])).`),
    per_program(100, Few),
    per_program(400, Many).

% An action that sets many fluents costs no more for each than one that sets few, whether or not two axioms speak of the same.
test(many_effects, [forall(member(Again, ["", "causes_val(reset, seen(C), true, cell(C))."])), true(Many < 1.5*Few)]) :-
    per_effect(Again, 100, Few),
    per_effect(Again, 2000, Many).

per_effect(Again, N, Cost) :-
    format(codes(Text), "cell(C) :- between(1, ~d, C). fun_fluent(seen(C)) :- cell(C). initially(seen(_), true).
                         prim_action(reset). poss(reset, true). causes_val(reset, seen(C), false, cell(C)). ~s", [N, Again]),
    load(Text),
    run(offline, reset),
    statistics(inferences, Before),
    run(offline, reset),
    statistics(inferences, After),
    Cost is (After-Before)/N.

% All ten thousand have been set; what is set often costs hardly more than alone.
test(beside_ten_thousand_that_are_set, true(Many < 1.15*Few)) :-
    count(Count),
    load(Count),
    per_step(offline, 1000, Few),
    beside_others(Others),
    append(Others, `\nprim_action(mark(_)). poss(mark(_), true).
                    causes_val(mark(I), cell(I), 1, true).
                    cells(L) :- numlist(1, 10000, L).`, Marking),
    load(Marking),
    once(do([inc, for(i, cells, mark(i))], [], Marked)),
    from(Marked, 1000, Short),
    from(Marked, 2000, Long),
    Many is (Long-Short)/1000.

% The situation after History is remembered, and on backtracking again.
from(History, N, Cost) :-
    statistics(inferences, Before),
    \+ \+ do(count(N), History, _),
    statistics(inferences, After),
    Cost is After-Before.

test(going_on_from_a_long_history, true(Cost < 200)) :-
    count(Count),
    load(Count),
    once(do(count(10_000), [], History)),
    statistics(inferences, Before),
    once(do(inc, History, [inc|_])),
    statistics(inferences, After),
    Cost is After-Before.

:- end_tests(cost).

                /* Loading: processor time, of which the least of two counts */

separate(N, Text) :-
    findall(Line,
            ( between(1, N, I),
              format(string(Line), "fun_fluent(f~d). initially(f~d, 0).", [I, I]) ),
            Lines),
    atomic_list_concat(Lines, '\n', Text).

loading(N, Least) :-
    separate(N, Text),
    findall(Seconds, ( member(_, [1, 2]), seconds(load(Text), Seconds) ), [A, B]),
    Least is min(A, B).

seconds(Goal, Seconds) :-
    statistics(cputime, Before),
    call(Goal),
    statistics(cputime, After),
    Seconds is After-Before.

:- begin_tests(loading).

% Four times as many fluents: 4 where loading is linear, 16 where it is quadratic.
test(linear, true(Many < 9*Few)) :-
    loading(2500, Few),
    loading(10_000, Many).

:- end_tests(loading).
