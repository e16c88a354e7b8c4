:- module(test_indigolog_agents, []).
:- use_module(library(plunit)).
:- use_module(library(apply), [maplist/2, maplist/3, partition/4]).
:- use_module(library(lists), [member/2, numlist/3, reverse/2, selectchk/3]).
:- use_module(library(random), [random_member/2]).
:- use_module(library(readutil), [read_file_to_terms/3]).
:- use_module('../../indigolog/indigolog').
:- use_module('../../indigolog/online/journal', [journal_close/1, journal_open/3]).
:- use_module('../await').
:- use_module(theory_text).

/** <module> Many agents in one process, one after the other, in threads, interleaved, and inside one another

Each has its own theory, world, events, journal and seed, and does what it does alone.
*/

theory(I, Text) :-
    format(string(Text),
           "prim_action(add(_)). prim_action(look). prim_action(rest).
            exog_action(ev(~d)). exog_action(poke(_)).
            fun_fluent(n). fun_fluent(seen). fun_fluent(pokes). (rel_fluent(on(X)) :- member(X, [a, b, ~d])).
            poss(add(K), neg(some((x, [~d]), K = x))). poss(look, true). poss(rest, some(x, on(x))).
            causes_val(add(K), n, M, M is n + K). causes_val(ev(_), n, M, M is n + ~d).
            causes_val(poke(_), pokes, M, M is pokes + 1). causes_true(rest, on(a), true).
            senses(look, seen).
            initially(n, 0). initially(pokes, 0). initially(on(X), V) :- ( X == ~d -> V = true ; V = false ).
            own(L) :- L = [1, 2, ~d].
            proc(go, [ while(n < 60, [ rndet(add(1), add(~d)), look, if(seen > 4, rest, add(2)),
                                       pi((r(k), own), add(k)),
                                       search([ndet(add(100), add(3)), ?(n < 100)]) ]),
                       while(pokes < 3, wait) ]).",
           [I, I, -1, I, I, I, I]).

program(I, Program) :-
    ( I mod 3 =:= 0 -> Program = conc(go, [rest, rest]) ; Program = go ).

% The world of all: what an agent senses and what happens to it follow from its name and what it has done.
:- dynamic done/2.                    % Run, Count

agents_world:can_execute(_).
agents_world:execute(A, Sensed) :- test_indigolog_agents:carried_out(A, Sensed).

carried_out(A, Sensed) :-
    current_run(agent(I)),
    ( retract(done(agent(I), N)) -> true ; N = 0 ),
    N1 is N+1,
    assertz(done(agent(I), N1)),
    ( A == look -> Sensed is (I*N*7) mod 10 ; Sensed = none ),
    ( N mod (I+2) =:= 1 -> report_exogenous(ev(I)) ; true ).

% run(+Way, +I, :OnAction, -Story): the agent from its theory to what can be told of it.
run(I, OnAction, story(Own, Pokes, Facts)) :-
    retractall(done(agent(I), _)),
    program(I, Program),
    tmp_file_stream(Journal, Stream, [encoding(utf8)]),
    close(Stream),
    ( I mod 2 =:= 0 -> Device = device(agents_world) ; Device = device(agents_world, [deadline(60)]) ),
    theory(I, Text),
    call_cleanup(( given_theory(I, Text, Given),
                   indigolog(Program, [ run(agent(I)), seed(I), journal(Journal), history(History), on_action(OnAction),
                                        max_wait(60), Device|Given ]),
                   read_file_to_terms(Journal, Facts0, []) ),
                 delete_file(Journal)),
    reverse(History, Actions),
    partition([poke(_)]>>true, Actions, Pokes, Own),
    partition([exogenous(_, poke(_))]>>true, Facts0, _, Facts1),
    maplist([F0, F]>>( F0 = executed(_, A, S) -> F = executed(A, S) ; F = F0 ), Facts1, Facts).

given_theory(I, Text, Given) :-
    (   I mod 3 =:= 1
    ->  load_text(Text, Theory),
        Given = [theory(Theory)]
    ;   load_text(Text),
        Given = []
    ).

% Three pokes from outside, by name, when it has begun.
poke_once(I, A, _) :-
    (   done(agent(I), 1),
        \+ member(A, [poke(_), ev(_)])
    ->  forall(between(1, 3, K), report_exogenous(agent(I), poke(K)))
    ;   true
    ).

alone(I, Story) :-
    run(I, test_indigolog_agents:poke_once(I), Story).

in_threads(Is, Stories) :-
    maplist([I, T]>>thread_create(nb_story(I), T), Is, Threads),
    maplist([T, Story]>>( thread_join(T, exited(Story)) ), Threads, Stories).

nb_story(I) :-
    alone(I, Story),
    thread_exit(Story).

% Each action of an engine is a chance for another one.
interleaved(Is, Stories) :-
    maplist([I, I-E]>>engine_create(Story, interrupted(I, Story), E), Is, Engines),
    turns(Engines, Pairs),
    maplist([I, Story]>>memberchk(I-Story, Pairs), Is, Stories).

interrupted(I, story(Story)) :-
    run(I, test_indigolog_agents:poke_and_yield(I), Story).

poke_and_yield(I, A, S) :-
    poke_once(I, A, S),
    engine_yield(went_on).

turns([], []) :- !.
turns(Engines, Pairs) :-
    random_member(I-E, Engines),
    engine_next(E, Said),
    (   Said = story(Story)
    ->  Pairs = [I-Story|Pairs1],
        selectchk(I-E, Engines, Engines1),
        engine_destroy(E),
        turns(Engines1, Pairs1)
    ;   turns(Engines, Pairs)
    ).

:- dynamic inside/1.

:- begin_tests(agents).

test(together, [forall(member(How-N, [in_threads-2, in_threads-10, interleaved-2, interleaved-10])),
                true(Stories == Alone)]) :-
    numlist(1, N, Is),
    maplist(alone, Is, Alone),
    call(How, Is, Stories),
    forall(member(story(Own, Pokes, Facts), Alone),
           ( length(Own, L), L > 12, Pokes == [poke(1), poke(2), poke(3)], Facts = [begun(_, _)|_] )).

% A device that runs another agent before it answers.
agents_outer:can_execute(_).
agents_outer:execute(_, none) :-
    test_indigolog_agents:alone(2, Story),
    assertz(test_indigolog_agents:inside(Story)).

drawn_alone([rndet(note(1), note(2)), rndet(note(3), note(4)), rndet(note(5), note(6)), rndet(note(7), note(8))]).

test(one_inside_another, [setup(retractall(test_indigolog_agents:inside(_))), true(All-Stories == Expected-[Alone, Alone, Alone, Alone])]) :-
    Text = "prim_action(note(_)). poss(note(_), true). fun_fluent(x). initially(x, 0).",
    drawn_alone(Program),
    load_text(Text, Theory),
    indigolog(Program, [theory(Theory), seed(5), device(agents_recorder), history(Expected)]),
    alone(2, Alone),
    indigolog(Program, [theory(Theory), seed(5), device(agents_outer), history(All)]),
    findall(S, test_indigolog_agents:inside(S), Stories).

agents_recorder:can_execute(_).
agents_recorder:execute(_, none).

% The same theory in many threads at once, whose helper facts differ from run to run.
test(one_theory_in_threads, true(Ends == Expected)) :-
    load_text("prim_action(mark(_)). poss(mark(X), member(X, [1, 2, 3])). (fun_fluent(cell(X)) :- between(1, 300, X)).
               initially(cell(_), 0). causes_val(mark(X), cell(X), V, V is cell(X) + 1).
               proc(mark_all(N), [while(cell(1) < N, for(i, [1, 2, 3], mark(i))),
                                  ?(findall(C, and(cell(C) = N, true), [1, 2, 3]))]).", Theory),
    numlist(1, 12, Ns),
    findall(N, ( member(I, Ns), N is I*3 ), Expected),
    maplist([I, T]>>thread_create(marked(I, Theory), T), Ns, Threads),
    maplist([T, L]>>thread_join(T, exited(L)), Threads, Ends).

marked(I, Theory) :-
    (   I mod 2 =:= 0
    ->  indigolog(mark_all(I), [theory(Theory), device(agents_recorder), history(H)])
    ;   in_theory(Theory, once(do(mark_all(I), [], H)))
    ),
    length(H, N),
    thread_exit(N).

% A thread's own theory is gone with it, and the one of the main thread stays.
test(theories_of_threads, true(H-Other == [mine]-[theirs])) :-
    load_text("prim_action(mine). poss(mine, true)."),
    thread_create(( load_text("prim_action(theirs). poss(theirs, true)."),
                    once(do(theirs, [], H0)), thread_exit(H0) ), Thread),
    thread_join(Thread, exited(Other)),
    once(do(mine, [], H)).

test(a_thread_without_one, true(H == [mine])) :-
    load_text("prim_action(mine). poss(mine, true)."),
    thread_create(( once(do(mine, [], H0)), thread_exit(H0) ), Thread),
    thread_join(Thread, exited(H)).

% Loaded anew while a thread runs the old one: that one goes on to its end.
test(loaded_anew, true(H = [mine, mine, go|_])) :-
    load_text("prim_action(mine). poss(mine, true). exog_action(go). exog_action(nothing). rel_fluent(gone). initially(gone, false).
               causes_true(go, gone, true)."),
    thread_create(( indigolog([while(neg(gone), wait), mine, mine], [run(old), device(agents_recorder), max_wait(60), history(H0)]),
                    thread_exit(H0) ), Thread),
    await(request_running(old)),
    load_text("prim_action(yours). poss(yours, true)."),
    report_exogenous(old, go),
    thread_join(Thread, exited(H)).

test(same_name, error(golog(run_exists(twin)))) :-
    load_text("prim_action(a). poss(a, true)."),
    indigolog(a, [run(twin), device(agents_recorder), on_action(plunit_agents:again)]).

again(_, _) :-
    indigolog(a, [run(twin), device(agents_recorder)]).

test(same_journal, [setup(tmp_file(journal, File)), cleanup(delete_file(File)), error(golog(journal_in_use(File)))]) :-
    load_text("prim_action(a). poss(a, true)."),
    indigolog(a, [journal(File), device(agents_recorder), on_action(plunit_agents:again_to(File))]).

again_to(File, _, _) :-
    indigolog(a, [journal(File), device(agents_recorder)]).

% A journal is opened while other threads close streams of theirs.
test(journals_of_many_threads, [true(Ends == Expected)]) :-
    numlist(1, 8, Is),
    maplist([_, T]>>thread_create(many_journals(300), T), Is, Ts),
    maplist([T, End]>>thread_join(T, End), Ts, Ends),
    maplist([_, true]>>true, Is, Expected).

many_journals(N) :-
    tmp_file_stream(File, Stream, [encoding(utf8)]),
    close(Stream),
    call_cleanup(forall(between(1, N, _), ( journal_open(File, 0, Journal), journal_close(Journal) )), delete_file(File)).

% Which of two is meant?
test(several_runs, error(golog(several_runs(bump)))) :-
    load_text("prim_action(a). poss(a, true)."),
    maplist([N, T]>>thread_create(indigolog([while(true, wait)], [run(N), device(agents_recorder), outcome(_)]), T), [left, right], Ts),
    await(( request_running(left), request_running(right) )),
    call_cleanup(report_exogenous(bump), ( request_abort(left), request_abort(right), maplist(thread_join, Ts) )).

request_running(Name) :-
    catch(report_exogenous(Name, nothing), error(golog(nothing_runs(_)), _), fail).

% A request reaches the run that is named, and no other.
test(stop_one, true(How == [stopped(enough), aborted])) :-
    load_text("prim_action(a). poss(a, true). exog_action(nothing)."),
    maplist([N, T]>>thread_create(ended(N), T), [left, right], Ts),
    await(( request_running(left), request_running(right) )),
    request_stop(left, enough),
    thread_join(Ts, left, First),
    request_abort(right),
    thread_join(Ts, right, Second),
    How = [First, Second].

thread_join([T, _], left, How) :- thread_join(T, exited(How)).
thread_join([_, T], right, How) :- thread_join(T, exited(How)).

ended(Name) :-
    catch(indigolog([while(true, wait)], [run(Name), device(agents_recorder), outcome(How)]), stopped(Reason), How = stopped(Reason)),
    thread_exit(How).

:- end_tests(agents).
