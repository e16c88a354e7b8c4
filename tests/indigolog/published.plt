:- module(test_indigolog_published, []).
:- use_module(library(plunit)).
:- use_module(library(aggregate), [aggregate_all/3]).
:- use_module(library(apply), [exclude/3]).
:- use_module(library(lists), [append/3, last/2, member/2, permutation/2, reverse/2]).
:- use_module(library(process), [process_create/3, process_wait/2]).
:- use_module('../../indigolog/indigolog').
:- use_module('../../indigolog/tools/checks', [theory_problems/1]).
:- use_module(theory_text).

/** <module> Theories in the published style run as they are, from the command line and from Prolog */

path(Relative, Path) :-
    module_property(test_indigolog_published, file(Here)),
    file_directory_name(Here, Folder),
    atomic_list_concat([Folder, /, Relative], Path).

load :-
    path('theories/lift.pl', File),
    load_theory(File).

% run(+Words, +Input, -Status, -Lines): what run.pl prints for the lift.
run(Words, Input, Status, Lines) :-
    path('theories/lift.pl', Theory),
    command([Theory|Words], [], Input, Status, Lines).

command(Words, Environment, Input, Status, Lines) :-
    path('../../indigolog/run.pl', Script),
    current_prolog_flag(executable, Swipl),
    process_create(Swipl, [Script, '--'|Words],
                   [ stdin(pipe(In)), stdout(pipe(Out)), stderr(null), process(Process), environment(Environment) ]),
    call_cleanup(( call_cleanup(write(In, Input), close(In)),
                   read_string(Out, _, Output) ),
                 ( close(Out), process_wait(Process, exit(Status)) )),
    split_string(Output, "\n", "", Lines0),
    exclude(==(""), Lines0, Lines).

trace(Program, Trace) :-
    once(do(Program, [], History)),
    reverse(History, Trace).

moves(Trace, N) :-
    aggregate_all(count, ( member(A, Trace), memberchk(A, [up, down]) ), N).

% fewest(+Floors, +From, -Moves): over all orders of serving Floors and parking at 1.
fewest(Floors, From, Moves) :-
    aggregate_all(min(D), ( permutation(Floors, Order), distance(Order, From, D) ), Moves).

distance([], From, D) :- D is From - 1.
distance([F|Fs], From, D) :-
    distance(Fs, F, D0),
    D is D0 + abs(F - From).

:- multifile user:message_hook/3.

% The lift's theory asks for exogenous actions as well, of an input that has ended.
user:message_hook(golog(prompt(exogenous)), help, _).

:- begin_tests(published, [setup(load)]).

test(plain, Trace == [down, open, close, clear(2), up, up, up, up, open, close, clear(6), down, down, down, down, down, open]) :-
    trace(control(plain), Trace).

test(search_finds_the_shortest, true(Found-Last == Fewest-open)) :-
    trace(control(short), Trace),
    moves(Trace, Found),
    last(Trace, Last),
    fewest([2, 6], 3, Fewest).

test(shortest_wherever_calls_come_from, [forall(member(Calls, [[1], [4], [1, 5], [4, 5], [1, 4, 5]])), true(Found == Fewest)]) :-
    findall(press(N), member(N, Calls), Pressed),
    once(do(control(short), Pressed, History)),
    once(append(New, Pressed, History)),
    moves(New, Found),
    append(Calls, [2, 6], Floors),
    fewest(Floors, 3, Fewest).

test(command_offline, Status-Last == 0-"17 actions.") :-
    run(['control(plain)'], "", Status, Lines),
    last(Lines, Last).

test(command_searches, Status-Last == 0-"15 actions.") :-
    run(['control(short)'], "", Status, Lines),
    last(Lines, Last).

% A press on the terminal while it goes down, then nothing more.
test(command_online_with_events, Status-Lines ==
     0-["down", "open", "close", "clear(2)", "up", "up", "open", "close", "clear(4)", "up", "up", "open", "close", "clear(6)",
        "down", "down", "down", "down", "down", "stop_interrupts", "20 actions."]) :-
    run(['control(reactive)', '--online'], "nil.\npress(4).\n", Status, Lines).

% Asked what is felt, on is answered.
test(command_online_with_sensing, Status-Lines == 0-["feel(5)", "up", "up", "open", "close", "clear(5)", "6 actions."]) :-
    run(['[feel(5), if(button(5) = on, serve(5), [])]', '--online'], "nil.\non.\n", Status, Lines).

% Only button 4 is on: it is felt for before and after each floor down.
test(finds_out_by_touch, Actions == [up, open, close, clear(4), down, down, down]) :-
    set_world([4], []),
    indigolog(control(sensing), [device(house), history(History)]),
    done_but(feel(_), History, Actions).

test(reads_the_panel, Actions == [up, up, open, close, clear(5), down, down, down, down]) :-
    set_world([5], []),
    indigolog([feel(2), feel(6), control(list)], [device(house), history(History)]),
    done_but(feel(_), History, Actions0),
    exclude(==(read_panel), Actions0, Actions).

% Smoke arrives after the first action, and is gone after the third.
test(reacts, Actions == [down, smoke, ring, ring, reset, open, close, clear(2), up, hotter, hotter, toggle, up, up, up, open, close,
                         clear(6), down, down, down, down, down, stop_interrupts]) :-
    set_world([], [1-smoke, 3-reset, 7-hotter, 7-hotter]),
    indigolog(control(reactive), [device(house), history(History)]),
    reverse(History, Actions).

:- end_tests(published).

:- begin_tests(older).

% causes/4, senses/1, and helper predicates that ask for domains.
test(possible_values, [forall(member(Felt-Actions,
                                     [ "1\n"-["smell", "shoot", "2 actions."],
                                       "0\n1\n"-["smell", "walk(2)", "smell", "shoot", "4 actions."] ])),
                       Status-Lines == 0-Actions]) :-
    path('theories/caves.pl', Theory),
    command([Theory, control, '--online'], [], Felt, Status, Lines).

% A domain is a predicate of the list, or of each element: one that has none now is empty.
test(domains, [setup(load_text("side(left). side(right). binary(B) :- B = 0 ; B = 1. sides([left, right]). :- dynamic none/1.
                                prim_action(turn(S)) :- domain(S, side). prim_action(set(S, B)) :- domain(S, sides), domain(B, binary).
                                poss(turn(_), true). poss(set(_, _), true).")),
               forall(member(Program-Traces, [ pi((s, side), turn(s))-[[turn(left)], [turn(right)]],
                                               for(s, sides, turn(s))-[[turn(left), turn(right)]],
                                               ?(all((b, binary), member(b, [0, 1])))-[[]],
                                               ?(some((n, none), true))-[] ])),
               true(Found == Traces)]) :-
    findall(Trace, ( do(Program, [], History), reverse(History, Trace) ), Found),
    theory_problems(Problems),
    assertion(Problems == []).

test(no_domain, [forall(member(Domain, [anything, integer, number_or(_)])), error(golog(no_domain(_)))]) :-
    load_text("anything(_). number_or(_, _)."),
    do(pi((x, Domain), ?(x = 1)), [], _).

% A clause that never applies says as little as a fact does.
test(no_sensing, Problems == []) :-
    load_text("prim_action(up). poss(up, true). senses(_) :- fail. settles(_, _, _, _, _) :- fail."),
    theory_problems(Problems).

% What a theory may call, it may also define.
test(own_world, [setup(load_text("prim_action(up). poss(up, true). fun_fluent(seen). senses(up, seen).
                                  ask_execute(up, 7). execute(A, R) :- ask_execute(A, R).
                                  ask_exog_occurs(_) :- fail. exog_occurs(A) :- ask_exog_occurs(A)."))]) :-
    indigolog([up, ?(seen = 7)]).

test(random_order, L == [1, 2, 3, 4]) :-
    path('theories/caves.pl', Theory),
    load_theory(Theory),
    once(holds(any_order(L0), [])),
    msort(L0, L).

:- end_tests(older).

:- begin_tests(shared_theories).

% Published theories kept beside the project, unchanged.
test(run, [ condition(shared_folder(_)),
            forall(member(Name-Program-Actions,
                          [ count-'bench(count(30))'-30, count-'bench(frame(20))'-20, toggle-'bench(toggle(12))'-12,
                            interrupts-'bench(interrupts(5, 20))'-21, pick-'bench(pick(10, 8))'-8,
                            conc-'bench(conc(3, 4))'-12, blocks-'bench(blocks(4))'-4 ])),
            true(Status-Last == 0-Expected) ]) :-
    shared_folder(Folder),
    atomic_list_concat([Folder, /, Name, '.pl'], Theory),
    command([Theory, Program], ['BLOCKS'='4', 'PICK'='10'], "", Status, Lines),
    last(Lines, Last),
    format(string(Expected), "~d actions.", [Actions]).

:- end_tests(shared_theories).

shared_folder(Folder) :-
    path('../../../shared/data/golog', Folder),
    exists_directory(Folder).

% The house: some buttons are on, and events come after so many actions.
:- dynamic on/1, due/1, done/1.

set_world(Buttons, Events) :-
    retractall(on(_)), forall(member(N, Buttons), assertz(on(N))),
    retractall(due(_)), forall(member(E, Events), assertz(due(E))),
    retractall(done(_)), assertz(done(0)).

house:can_execute(_).
house:execute(A, Result) :- test_indigolog_published:executed(A, Result).
house:exogenous(As) :- test_indigolog_published:arrived(As).

executed(A, Result) :-
    retract(done(N)),
    N1 is N+1,
    assertz(done(N1)),
    (   A = feel(F)
    ->  ( on(F) -> Result = on ; Result = off )
    ;   A == read_panel
    ->  findall(B, ( between(1, 6, F), ( on(F) -> B = 1 ; B = 0 ) ), Result)
    ;   A = clear(F)
    ->  retractall(on(F)), Result = none
    ;   Result = none
    ).

arrived(As) :-
    done(N),
    findall(A, ( due(M-A), M =< N ), As),
    forall(( due(M-A), M =< N ), retract(due(M-A))).

done_but(Left, History, Actions) :-
    findall(A, ( member(A, History), A \= e(_, _), \+ A = Left ), Newest),
    reverse(Newest, Actions).
