:- module(test_indigolog_differential, []).
:- use_module(library(plunit)).
:- use_module(library(lists), [reverse/2]).
:- use_module(library(random), [random_between/3, random_member/2]).
:- use_module('../../indigolog/indigolog').
:- use_module('../../indigolog/offline', []).
:- use_module('../../indigolog/situation', [initial_situation/1]).
:- use_module(naive).

/** <module> Random programs have the same executions in the interpreter and in the naive evaluator

The number of programs is 500, or what the environment variable PROGRAMS says.
*/

bound(4).

traces(Program, Traces) :-
    bound(Bound),
    initial_situation(S0),
    findall(Trace,
            ( indigolog_offline:complete(Program, S0, none, 1, 1, Bound-limit(false), S),
              situation_history(S, History),
              reverse(History, Trace) ),
            Traces0),
    sort(Traces0, Traces).

% program(+Depth, -Program): Depth bounds the nesting.
program(0, P) :-
    !,
    random_member(P, [inc, inc, switch(a), switch(b), all_off, put(k, counter), never, [],
                      count_down(2)]).
program(D, P) :-
    D1 is D-1,
    random_member(Kind, [leaf, seq, seq, test, ndet, wndet, rndet, if, while, star, pi, for, conc,
                         pconc, rconc, rrobin, gexec, goal]),
    program(Kind, D1, P).

program(leaf, _, P) :- program(0, P).
program(seq, D, [P, Q]) :- program(D, P), program(D, Q).
program(test, D, [?(F), P]) :- formula(1, F), program(D, P).
program(ndet, D, ndet(P, Q)) :- program(D, P), program(D, Q).
program(wndet, D, wndet(P, Q)) :- program(D, P), program(D, Q).
program(rndet, D, rndet(P, Q)) :- program(D, P), program(D, Q).
program(if, D, if(F, P, Q)) :- formula(1, F), program(D, P), program(D, Q).
program(while, D, while(F, P)) :- formula(1, F), program(D, P).
program(star, D, star(P, N)) :- random_between(0, 2, N), program(D, P).
program(pi, D, pi((x, lamps), [switch(x), P])) :- program(D, P).
program(for, _, for(x, [a, b], switch(x))).
program(conc, D, conc(P, Q)) :- program(D, P), program(D, Q).
program(pconc, D, pconc(P, Q)) :- program(D, P), program(D, Q).
program(rconc, D, rconc([P, Q])) :- program(D, P), program(D, Q).
program(rrobin, D, rrobin([P, Q])) :- program(D, P), program(D, Q).
program(gexec, D, gexec(F, P)) :- formula(1, F), program(D, P).
program(goal, D, goal(F, P, G, Q)) :- formula(1, F), formula(1, G), program(D, P), program(D, Q).

formula(0, F) :-
    !,
    random_between(0, 3, N),
    random_member(F, [true, lit(a), lit(b), counter < N, counter = N, all_lit,
                      some((l, lamps), lit(l)), all((l, [a, b]), lit(l))]).
formula(_, F) :-
    formula(0, P),
    formula(0, Q),
    random_member(F, [P, neg(P), and(P, Q), or(P, Q)]).

whole(P) :-
    random_member(Kind, [plain, plain, plain, interrupts]),
    (   Kind == plain
    ->  program(3, P)
    ;   formula(1, F), formula(1, G), program(1, A), program(1, B),
        P = prioritized_interrupts([interrupt(F, A), interrupt(G, B)])
    ).

number_of_programs(N) :-
    (   getenv('PROGRAMS', Text)
    ->  atom_number(Text, N)
    ;   N = 500
    ).

differing(P, Ours, Naive) :-
    number_of_programs(N),
    set_random(seed(2000)),
    bound(Bound),
    between(1, N, _),
    whole(P),
    traces(P, Ours),
    naive_traces(P, Bound, Naive),
    Ours \== Naive,
    !.

:- begin_tests(differential).

test(same_traces, [setup(test_indigolog_differential:load), fail]) :-
    differing(P, Ours, Naive),
    print_message(error, format("~q has~n~q~nby the axioms~n~q", [P, Ours, Naive])).

:- end_tests(differential).

load :-
    module_property(test_indigolog_differential, file(Here)),
    file_directory_name(Here, Folder),
    atom_concat(Folder, '/theories/lights.pl', File),
    load_theory(File).
