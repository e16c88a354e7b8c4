:- module(test_indigolog_chance, []).
:- use_module(library(plunit)).
:- use_module(library(aggregate), [aggregate_all/3]).
:- use_module(library(lists), [append/3, member/2, nextto/3, nth0/3, nth1/3, reverse/2]).
:- use_module(library(random), [random/1, random_between/3]).
:- use_module(library(readutil), [read_file_to_terms/3]).
:- use_module('../../indigolog/indigolog').
:- use_module('../../indigolog/language/chance', [drawn_apart/1, with_seed/2, world_moment/1]).
:- use_module(theory_text).

/** <module> What the world draws is nothing that a program's own draws miss */

% A program that draws in a test of its own, between actions of which some ask the world.
theory("
prim_action(put(_)).   poss(put(_), true).
prim_action(push).     poss(push, true).
prim_action(look).     poss(look, true).
fun_fluent(seen).      initially(seen, 0).     senses(look, seen).
fun_fluent(bumps).     initially(bumps, 0).    exog_action(bump).
causes_val(bump, bumps, N, N is bumps + 1).
drawn(X) :- random_between(1, 1000000, X).
proc(round, [look, pi(x, [?(drawn(x)), put(x)]), push]).
proc(rounds, [round, round, round]).
").

own_world("
execute(look, X) :- !, random_between(1, 1000000, X).
execute(push, _) :- !, random(_).
execute(_, _).
exog_occurs(bump) :- random(X), X < 0.3.
").

% A device that is called by the thread of the program.
noisy:can_execute(_).
noisy:execute(look, X) => random_between(1, 1000000, X).
noisy:execute(_, _)    => random(_).
noisy:exogenous(Actions) :-
    random(X),
    ( X < 0.3 -> Actions = [bump] ; Actions = [] ).

quiet:can_execute(_).
quiet:execute(look, X) => X = 1.
quiet:execute(_, _)    => true.

world(own_world, []).
world(device, [device(noisy)]).
world(device_with_a_deadline, [device(noisy), deadline(20)]).

load(World) :-
    theory(Theory),
    (   World == own_world
    ->  own_world(Own)
    ;   Own = ""
    ),
    string_concat(Theory, Own, Text),
    load_text(Text).

run(Options, History) :-
    indigolog(rounds, [check(false), seed(7), history(Newest)|Options]),
    reverse(Newest, History).

% cut(+File, +Kept): of the journal in File the first Kept facts are left.
cut(File, Kept) :-
    read_file_to_terms(File, Facts, []),
    length(First, Kept),
    append(First, _, Facts),
    setup_call_cleanup(open(File, write, Out),
                       forall(member(Fact, First), format(Out, "~q.~n", [Fact])),
                       close(Out)).

puts(History, Puts) :-
    findall(X, member(put(X), History), Puts).

sensed(History, Results) :-
    findall(X, member(e(look, X), History), Results).

:- begin_tests(chance).

test(follows_its_journal, [forall(world(World, Options)), setup(( load(World), tmp_file(journal, File) )),
                           cleanup(delete_file(File)), Replayed == Whole]) :-
    run([journal(File)|Options], Whole),
    indigolog(rounds, [replay(File), history(Newest)]),
    reverse(Newest, Replayed).

% Wherever it was interrupted, the program draws on as it would have, and so does the world.
test(resumed_from_anywhere, [forall(( world(World, Options), between(1, 10, Kept) )),
                             setup(( load(World), tmp_file(journal, File) )), cleanup(delete_file(File)),
                             Again == Whole]) :-
    run([journal(File)|Options], Whole),
    cut(File, Kept),
    indigolog(rounds, [resume(File), history(Newest)|Options]),
    reverse(Newest, Again).

% While the program waits the world is asked again and again.
test(resumed_where_it_waits, [forall(between(1, 9, Kept)), setup(( load(own_world), tmp_file(journal, File) )),
                              cleanup(delete_file(File)), Again == Whole]) :-
    Program = [wait, look, wait, look, wait, look, wait, look, wait, look],
    indigolog(Program, [check(false), seed(7), journal(File), history(Whole)]),
    read_file_to_terms(File, Facts, []),
    nth0(Kept, Facts, Next),
    (   last_of_turn(Kept, Facts, Next)
    ->  cut(File, Kept),
        indigolog(Program, [check(false), resume(File), history(Again)])
    ;   Again = Whole
    ).

% What happens in one turn is written at once: no run ends within.
last_of_turn(Kept, Facts, Next) :-
    \+ ( Next = exogenous(Turn, _), nth1(Kept, Facts, exogenous(Turn, _)) ).

% Of 3000 moments, each on its own: even over the values, and over the pairs of successive ones.
test(moments_are_independent, [true(( Singles < 30, Pairs < 100 ))]) :-
    with_seed(1, throws(3000, Ds)),
    chi_square(Ds, 6, Singles),
    findall(D, ( nextto(A, B, Ds), D is 6*A+B-6 ), Ds2),
    chi_square(Ds2, 36, Pairs).

throws(N, Ds) :-
    findall(D,
            ( between(1, N, Moment),
              world_moment(Moment),
              drawn_apart(random_between(1, 6, D)) ),
            Ds).

chi_square(Ds, Values, Sum) :-
    length(Ds, N),
    Expected is N/Values,
    aggregate_all(sum((Count-Expected)**2/Expected),
                  ( between(1, Values, D), aggregate_all(count, member(D, Ds), Count) ),
                  Sum).

test(draws_as_in_a_world_without_chance, [forall(world(World, Options)), Noisy == Quiet]) :-
    load(device),
    run([device(quiet)], Whole0),
    puts(Whole0, Quiet),
    load(World),
    run(Options, Whole1),
    puts(Whole1, Noisy).

% The world's draws are no constant, and not those of the program over again; a seed repeats them.
test(the_world_draws_on, [forall(world(World, Options)), setup(load(World)), Whole == Again]) :-
    run(Options, Whole),
    sensed(Whole, Results),
    puts(Whole, Puts),
    append(Results, Puts, All),
    sort(All, Different),
    assertion(length(Different, 6)),
    run(Options, Again).

test(nothing_is_drawn_from_who_runs_it, [setup(load(own_world)), X == Y]) :-
    set_random(seed(5)),
    random_between(1, 1000000, X),
    set_random(seed(5)),
    run([], _),
    random_between(1, 1000000, Y).

:- end_tests(chance).
