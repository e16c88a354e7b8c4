:- module(test_indigolog_search, []).
:- use_module(library(plunit)).
:- use_module(library(lists), [append/3, last/2, member/2, memberchk/2, reverse/2]).
:- use_module('../../indigolog/indigolog').
:- use_module('../../indigolog/language/situation', [initial_situation/1]).
:- use_module('../../indigolog/search/memory', [new_memory/4, seen/4]).
:- use_module(theory_text).

/** <module> Every strategy of search, its budgets, and what happens to a plan when the world changes */

load :-
    module_property(test_indigolog_search, file(Here)),
    file_directory_name(Here, Folder),
    atom_concat(Folder, '/theories/roads.pl', File),
    load_theory(File).

plan(Program, Options, Trace) :-
    once(do(search(Program, Options), [], History)),
    reverse(History, Trace).

lengths([cost(drive(X, Y), L^distance(X, Y, L))]).
estimated([heuristic(L^(left(at, L)))|Options]) :- lengths(Options).
misled([heuristic(L^(misled(at, L)))|Options]) :- lengths(Options).

few([drive(a, b), drive(b, z)]).
short([drive(a, c), drive(c, d), drive(d, z)]).

:- begin_tests(strategies, [setup(load)]).

test(published_takes_the_first, Trace == Expected) :-
    few(Expected),
    plan(travel, [], Trace).

test(orders, all(H == [[drive(b, z), drive(a, b)], [drive(d, z), drive(c, d), drive(a, c)]])) :-
    do(search(ndet([drive(a, b), drive(b, z)], [drive(a, c), drive(c, d), drive(d, z)])), [], H).

test(fewest_actions, [forall(member(Strategy, [breadth, iterative])), Trace == Expected]) :-
    few(Expected),
    plan(travel, [strategy(Strategy)], Trace).

test(cheapest, [forall(member(Strategy, [astar, iterative])), Trace == Expected]) :-
    short(Expected),
    estimated(Costs),
    plan(travel, [strategy(Strategy)|Costs], Trace).

test(cheapest_without_an_estimate, [forall(member(Strategy, [astar, iterative])), Trace == Expected]) :-
    short(Expected),
    lengths(Costs),
    plan(travel, [strategy(Strategy)|Costs], Trace).

% Where a cost asks what was done, two ways to the same place differ.
test(cheapest_by_history, [forall(member(How, [[], [strategy(iterative)], [strategy(depth), anytime(true)]])), Trace == Expected]) :-
    Round = [drive(a, c), drive(c, a)],
    Rest = [drive(a, b), drive(b, z)],
    append(Round, Rest, Expected),
    plan([ndet([], Round), Rest], [cost(drive(b, z), N^(done(drive(c, a)) -> N = 1 ; N = 100))|How], Trace).

test(best_follows_the_estimate, Trace == Expected) :-
    few(Expected),
    misled(Costs),
    plan(travel, [strategy(best)|Costs], Trace).

test(anytime_improves, [forall(member(Strategy, [best, depth, beam(2)])), Trace == Expected]) :-
    short(Expected),
    lengths(Costs),
    plan(travel, [strategy(Strategy), anytime(true)|Costs], Trace).

test(anytime_weighted, Trace == Expected) :-
    short(Expected),
    estimated(Costs),
    plan(travel, [weight(5), anytime(true)|Costs], Trace).

% Two configurations are enough for a plan through b, not for the better one.
test(anytime_best_so_far, [forall(member(Strategy-N, [best-3, depth-3])), Trace == Expected]) :-
    few(Expected),
    misled(Costs),
    plan(travel, [strategy(Strategy), anytime(true), max_nodes(N)|Costs], Trace).

test(beam_of_one_is_greedy, Trace == Expected) :-
    few(Expected),
    misled(Costs),
    plan(travel, [strategy(beam(1))|Costs], Trace).

test(beam_may_miss, fail) :-
    misled(Costs),
    plan([travel, ?(at = a)], [strategy(beam(1))|Costs], _).

test(depth_with_options, Trace == Expected) :-
    few(Expected),
    plan(travel, [strategy(depth)], Trace).

test(no_plan_is_failure, [forall(member(Strategy, [depth, breadth, iterative, best, astar, beam(3)])), fail]) :-
    plan(in_circles, [strategy(Strategy), max_nodes(1000)], _).

test(no_plan_as_published, fail) :-
    plan(in_circles, [], _).

test(infinite_estimate_is_a_dead_end, Trace == Expected) :-
    short(Expected),
    plan(travel, [heuristic(L^(at = b -> L = inf ; L = 0))], Trace).

test(search_binds_the_program_around_it, H == [drive(c, d), drive(a, c)]) :-
    once(do([search([pi([x, y], [?(and(at = x, way(x, y))), drive(x, y), ?(and(y = Y, Y = c))])],
                    [strategy(breadth)]),
             pi(z, [?(road(Y, z, _)), drive(Y, z)]), ?(at = d)], [], H)).

% What the test binds has variables of its own.
test(plan_without_an_action, [forall(member(S, [depth, breadth, iterative, best, astar, beam(3)])), Last == z]) :-
    once(do([search(?(Way = [a, _, _]), [strategy(S)]), ?(Way = [_, _, z])], [], [])),
    last(Way, Last).

test(message_as_published, Trace == Expected) :-
    few(Expected),
    once(do(search(travel, 'on the way'), [], H)),
    reverse(H, Trace).

:- end_tests(strategies).

:- begin_tests(search_misuse, [setup(load)]).

test(without_end_as_published, [condition(\+ getenv('TESTS', quick)), error(golog(search_depth(100_000)))]) :-
    do(search(for_ever(0)), [], _).

test(unknown_option, error(golog(search_option(depth(3))))) :-
    do(search(travel, [depth(3)]), [], _).

test(unknown_strategy, error(golog(search_option(strategy(best(first)))))) :-
    do(search(travel, [strategy(best(first))]), [], _).


test(estimate_is_no_number, error(golog(search_value(heuristic, at)))) :-
    do(search(travel, [heuristic(at)]), [], _).

test(cost_is_negative, error(golog(search_value(cost(drive(a, b)), -1)))) :-
    do(search(travel, [cost(-1)]), [], _).

test(cost_is_infinite, error(golog(search_value(cost(drive(a, b)), inf)))) :-
    plan(travel, [cost(inf)], _).

:- end_tests(search_misuse).

:- dynamic warned/1.

:- multifile user:message_hook/3.

user:message_hook(golog(search_budget(Budget)), warning, _) :-
    assertz(test_indigolog_search:warned(Budget)).

warnings(Goal, Warnings) :-
    retractall(warned(_)),
    call(Goal),
    findall(W, warned(W), Warnings0),
    sort(Warnings0, Warnings).

:- begin_tests(search_budgets, [setup(load)]).

test(nodes, [forall(member(S, [depth, breadth, iterative, best, astar, beam(2)])), Warnings == [max_nodes(1)]]) :-
    warnings(\+ do(search(travel, [strategy(S), max_nodes(1)]), [], _), Warnings).

test(seconds, Warnings == [max_seconds(0)]) :-
    warnings(\+ do(search([star([drive(a, c), drive(c, a)]), ?(false)], [max_seconds(0)]), [], _), Warnings).

test(the_program_goes_on, all(H == [[drive(b, z), drive(a, b)]])) :-
    do(ndet(search(travel, [max_nodes(1)]), [drive(a, b), drive(b, z)]), [], H).

test(an_interrupt_goes_on, History == [stop_interrupts, drive(b, z), drive(a, b)]) :-
    indigolog(prioritized_interrupts([ interrupt(neg(at = z), search(travel, [max_nodes(1)])),
                                       interrupt(at = a, drive(a, b)), interrupt(at = b, drive(b, z)) ]),
              [device(world), history(History)]).

% The search inside uses its budget up; the one around it has none.
test(inside_a_search, all(H == [[drive(b, z), drive(a, b)]])) :-
    do(search(ndet(search(travel, [max_nodes(1)]), [drive(a, b), drive(b, z)])), [], H).

:- end_tests(search_budgets).

:- dynamic happening/2.

% Events that arrive after an action: happening(Action, Event).
world:can_execute(_).
world:execute(A, Result) :-
    (   A == ask
    ->  Result = ten
    ;   Result = none
    ),
    forall(retract(test_indigolog_search:happening(A, Event)),
           assertz(test_indigolog_search:happening(now, Event))).
world:exogenous(Events) :-
    findall(E, retract(test_indigolog_search:happening(now, E)), Events).

:- begin_tests(monitoring, [setup(load), cleanup(retractall(test_indigolog_search:happening(_, _)))]).

run(Program, Events, Trace) :-
    retractall(test_indigolog_search:happening(_, _)),
    forall(member(A-E, Events), assertz(test_indigolog_search:happening(A, E))),
    indigolog(Program, [device(world), history(History), outcome(final)]),
    reverse(History, Trace).

test(followed, Trace == [drive(a, b), drive(b, z)]) :-
    run(search(travel), [], Trace).

test(what_does_not_matter_keeps_the_plan, Trace == [drive(a, c), rain, drive(c, d), drive(d, z)]) :-
    lengths(Costs),
    run(search(travel, Costs), [drive(a, c)-rain], Trace).

test(sensing_keeps_the_plan, Trace == [ask, e(ask, ten), drive(a, b), drive(b, z)]) :-
    run(search([ask, travel]), [], Trace).

% The road ahead closes: back, and the other way round.
test(repaired, [forall(member(Strategy, [breadth, astar, iterative, best, depth, beam(5)])),
                Trace == [drive(a, c), close(c, d), drive(c, a), drive(a, b), drive(b, z)]]) :-
    lengths(Costs),
    run([search([drive(a, c), travel], [strategy(Strategy)|Costs])], [drive(a, c)-close(c, d)], Trace).

test(repaired_as_published, Trace == [drive(a, c), close(c, d), drive(c, a), drive(a, b), drive(b, z)]) :-
    run(search([drive(a, c), pi((x, [d, a]), drive(c, x)), travel]), [drive(a, c)-close(c, d)], Trace).

test(beyond_repair, error(golog(program_ended(failed, _, _)))) :-
    retractall(test_indigolog_search:happening(_, _)),
    assertz(test_indigolog_search:happening(drive(a, b), close(b, z))),
    indigolog(search(travel), [device(world)]).

:- end_tests(monitoring).

                /* What follows the last action of a plan belongs to it */

counter("prim_action(inc). prim_action(dec). prim_action(home). prim_action(alarm).
fun_fluent(n). rel_fluent(away).
poss(inc, true). poss(dec, true). poss(home, away). poss(alarm, true).
causes_val(inc, n, M, M is n + 1). causes_val(dec, n, M, M is n - 1).
causes_false(home, away, true). causes_true(alarm, away, true).
initially(n, 1). initially(away, true).").

load_counter :-
    counter(Text),
    load_text(Text).

plan_of(E, search(E)).
plan_of(E, search(E, [strategy(Strategy)])) :-
    member(Strategy, [depth, breadth, iterative, best, astar, beam(3)]).
plan_of(E, searchc(E)).

:- begin_tests(end_of_a_plan, [setup(load_counter)]).

test(before_the_world_moves, [forall(plan_of([inc, inc, ?(n = 3)], E)), true(Last == [dec, inc, inc])]) :-
    findall(H, do(conc(E, dec), [], H), Hs),
    memberchk(Last, Hs).

% What has a lower priority waits for it.
test(before_lower_priorities, [forall(plan_of([inc, inc, ?(n = 3)], E)), all(H == [[dec, inc, inc]])]) :-
    do(pconc(E, dec), [], H).

test(once, [forall(plan_of([inc, inc], E)), all(H == [[dec, inc, inc]])]) :-
    do([E, dec], [], H).

test(achieved_before_lower_priorities, set(H == [[alarm, home]])) :-
    do(pconc(achieve(neg(away), 3, [actions([home])]), alarm), [], H).

test(home_by_search, Actions == [stop_interrupts, dec, inc, inc]) :-
    indigolog(prioritized_interrupts([interrupt(n = 1, search([inc, inc, ?(n = 3)])), interrupt(n = 3, dec)]),
              [device(obliging), history(Actions)]).

obliging:can_execute(_).
obliging:execute(_, _).

:- end_tests(end_of_a_plan).

                /* Memory */

vast("prim_action(put(_, _)). fun_fluent(at(X)) :- member(X, [1, 2, 3, 4, 5, 6]).
poss(put(X, Y), at(X) \\== Y). causes_val(put(X, Y), at(X), Y, true).
initially(at(_), 0).
proc(wander, star(pi((x, [1, 2, 3, 4, 5, 6]), pi((y, [0, 1, 2, 3, 4, 5, 6, 7]), put(x, y))))).").

:- begin_tests(memory, [setup(( vast(Text), load_text(Text) ))]).

% What other tests left on the stack would count as used before, and a search be allowed as much more.
test(gives_up, [forall(member(S, [depth, breadth, best, astar])), true(Warnings = [max_mb(1, N)])]) :-
    garbage_collect,
    warnings(\+ do(search([wander, ?(false)], [strategy(S), max_mb(0.2)]), [], _), Warnings),
    Warnings = [max_mb(_, N)|_],
    N > 50.

% In the table and in the atoms that it holds.
test(bytes_of_a_configuration, true(Bytes < 200)) :-
    initial_situation(S),
    new_memory([], S, [], Memory),
    N = 40_000,
    garbage_collect,
    garbage_collect_atoms,
    held_bytes(Before),
    forall(between(1, N, I), \+ seen(Memory, wander(I), S, 1)),
    garbage_collect,
    garbage_collect_atoms,
    held_bytes(After),
    Bytes is (After-Before)/N,
    forall(between(1, N, I), seen(Memory, wander(I), S, 1)).

held_bytes(Bytes) :-
    statistics(globalused, Global),
    statistics(atom_space, Atoms),
    Bytes is Global+Atoms.

:- end_tests(memory).

                /* Variables with constraints on them */

:- begin_tests(constraints, [setup(load_text("prim_action(add(_)). fun_fluent(n). poss(add(_), true). initially(n, 0). causes_val(add(X), n, M, M is n + X)."))]).

% What follows add(1) is the same program of both choices, but for what x may not be.
test(told_apart, [forall(( member(Strategy, [published, depth, breadth, iterative, best, astar, beam(3)]),
                           ( Strategy == published -> How = [] ; How = [strategy(Strategy)] ) )),
                  H == [add(6), add(1)]]) :-
    once(do(search(pi(x, [ndet(?(dif(x, 6)), ?(dif(x, 1))), add(1), ?(member(x, [1, 6])), ?(x > 3), add(x)]), How), [], H)).

:- end_tests(constraints).
