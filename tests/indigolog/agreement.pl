:- module(agreement, []).
/** <module> Random agents behave alike in the interpreter and by the axioms

    swipl tests/indigolog/agreement.pl PROGRAMS [SEED]

Ten random programs for each random theory, the first that of SEED, 1 if not given.  Questions: the set
of complete traces of a program, with the values of all fluents at the end of each; whether it is final after a
random history, and the values there; the plan that a strategy of search finds, and online, in a random world, that the run is one
of those that the axioms allow.  One process asks each question and compares, then asks all once more in
random order; a second one, in which nothing was asked before, asks them in another order.  The exit
status is 1 if an answer differs, and says where.
*/

:- use_module(library(lists), [member/2, memberchk/2, min_list/2, nth1/3, reverse/2, sum_list/2]).
:- use_module(library(apply), [maplist/3]).
:- use_module(library(process), [process_kill/2, process_wait/2]).
:- use_module(library(random), [random_member/2, random_permutation/2]).
:- use_module(library(unix), [fork/1, pipe/2]).
:- use_module('../../indigolog/indigolog').
:- use_module('../../indigolog/language/history', [history_situation/2]).
:- use_module('../../indigolog/language/situation', [fluent_status/3]).
:- use_module(naive).
:- use_module(naive_values, [naive_theory/1, naive_values/3]).
:- use_module(random_agents).

:- initialization(main, main).

% A process that is forked has one thread; it would wait at its end for the one that collects garbage.
:- set_prolog_gc_thread(false).

% Most actions of a trace, and of a plan.
bound(4).
bound_of_plans(20).

programs_a_theory(10).

% What one comparison may cost; one that costs more is left out and counted.
inferences(2_000_000).

main :-
    current_prolog_flag(argv, Argv),
    (   maplist(atom_number, Argv, [Programs|Seeds]),
        ( Seeds = [First] ; Seeds == [], First = 1 )
    ->  true
    ;   format(user_error, "usage: swipl tests/indigolog/agreement.pl PROGRAMS [SEED]~n", []),
        halt(2)
    ),
    programs_a_theory(Each),
    Last is First + (Programs + Each - 1) // Each - 1,
    Counts = counts(0, 0, 0),
    forall(between(First, Last, Seed), alike(Seed, First, Counts)),
    told(Programs, Counts).

told(Programs, counts(Compared, Traces, Out)) :-
    format("~D programs alike: ~D comparisons, ~D traces; ~D comparisons left out~n", [Programs, Compared, Traces, Out]).

alike(Seed, First, Counts) :-
    (   in_a_process(first_time(Seed), Answers, ok),
        in_a_process(again(Seed, Answers), _, ok)
    ->  forall(member(answer(_, What, Answer), Answers), count(What, Answer, Counts)),
        programs_a_theory(Each),
        Done is (Seed-First+1) * Each,
        ( Done mod 1000 =:= 0 -> told(Done, Counts) ; true )
    ;   format(user_error, "to see it again: swipl tests/indigolog/agreement.pl 1 ~d~n", [Seed]),
        halt(1)
    ).

count(What, Answer, Counts) :-
    (   Answer == left_out
    ->  add(3, 1, Counts)
    ;   add(1, 1, Counts),
        ( What == traces -> length(Answer, N), add(2, N, Counts) ; true )
    ).

add(I, N, Counts) :-
    arg(I, Counts, N0),
    N1 is N0+N,
    nb_setarg(I, Counts, N1).


                /* Processes */

:- meta_predicate in_a_process(1, -, -).

% in_a_process(:Goal, -Terms, -End): call(Goal, Out) in a process of its own, which writes
% Terms to Out; End is `ok` if it succeeded.
in_a_process(Goal, Terms, End) :-
    pipe(In, Out),
    fork(Process),
    (   Process == child
    ->  close(In),
        (   catch(call(Goal, Out), Error, ( print_message(error, Error), fail ))
        ->  write_canonical(Out, ok)
        ;   write_canonical(Out, differs)
        ),
        format(Out, ".~n", []),
        close(Out),
        current_prolog_flag(pid, Own),
        process_kill(Own, kill)         % halt/0 may wait for ever, for a lock that was held when it was forked
    ;   close(Out),
        read_term(In, Term, []),
        read_terms(Term, In, Terms, End),
        close(In),
        process_wait(Process, _)
    ).

read_terms(Term, In, Terms, End) :-
    (   Term = answer(_, _, _)
    ->  Terms = [Term|Terms1],
        read_term(In, Term1, []),
        read_terms(Term1, In, Terms1, End)
    ;   Terms = [],
        End = Term
    ).

first_time(Seed, Out) :-
    asked(Seed, Clauses, Questions),
    numbered(Questions, 1, Seed, Clauses, Answers),
    forall(member(Term, Answers),
           ( write_canonical(Out, Term), format(Out, ".~n", []) )),
    same_answers(Answers, Questions, Seed, Clauses).

% Not by findall/3: SWI-Prolog 9.0.4 may mix its solutions with those of one that a limit on inferences broke off.
numbered([], _, _, _, []).
numbered([What-P|Questions], I, Seed, Clauses, [answer(I, What, Answer)|Answers]) :-
    first_answer(What, P, Seed, Clauses, Answer),
    I1 is I+1,
    numbered(Questions, I1, Seed, Clauses, Answers).

again(Seed, Answers, _) :-
    asked(Seed, Clauses, Questions),
    Other is -Seed,
    set_random(seed(Other)),
    same_answers(Answers, Questions, Seed, Clauses).

% No answer depends on what was asked before: each question in random order.
same_answers(Answers, Questions, Seed, Clauses) :-
    random_permutation(Answers, Order),
    forall(( member(answer(I, What, Answer), Order), Answer \== left_out ),
           (   nth1(I, Questions, What1-P),
               What1 =@= What,
               answer(What1, P, Again),
               Again =@= Answer
           ->  true
           ;   print_message(error, format("theory ~w: ~q~n~q asked for ~q again:~n~q~nbefore~n~q",
                                           [Seed, Clauses, P, What, Again, Answer])),
               fail
           )).


                /* Questions */

% asked(+Seed, -Clauses, -Questions): the theory, loaded, and What-Program, ...
asked(Seed, Clauses, Questions) :-
    set_random(seed(Seed)),
    random_member(Kind, [plain, sensing, knowing]),
    random_theory(Kind, Clauses),
    load_clauses(Clauses),
    naive_theory(Clauses),                % the world needs it too
    programs_a_theory(Each),
    findall(Question,
            ( between(1, Each, I),
              Own is Seed*1000 + I,
              set_random(seed(Own)),
              random_program(Kind, 3, P),
              random_program(online(Kind), 2, Q),
              random_plan(Kind, R),
              random_world(World),
              random_history(H),
              random_member(How, [[strategy(depth)], [strategy(breadth)], [strategy(iterative)], [strategy(best)],
                                  [strategy(astar)], [strategy(beam(3))], [cost(tick(_), 3), cost(act(2), 0)],
                                  [strategy(best), anytime(true), cost(tick(_), 3), heuristic(X^or(n = X, X = 1))]]),
              member(Question, [traces-P, final(H)-P, values(H)-[], plan(How)-R, online(World, Own)-Q]) ),
            Questions).

load_clauses(Clauses) :-
    tmp_file_stream(File, Stream, [extension(pl)]),
    close(Stream),
    write_theory(File, Clauses),
    call_cleanup(load_theory(File), delete_file(File)).

% first_answer(+What, +Program, +Seed, +Clauses, -Answer) is semidet: `left_out` where it
% costs too much; fails, having printed how, if it is not what the axioms say.
first_answer(What, P, Seed, Clauses, Answer) :-
    inferences(Most),
    (   catch(call_with_inference_limit(compared(What, P, Ours, Naive), Most, Result),
              Error,
              ( Ours = Error, Naive = none ))
    ->  true
    ;   Ours = failed, Naive = none
    ),
    (   Result == inference_limit_exceeded    % too many executions to list them all
    ->  Answer = left_out
    ;   agree(What, Ours, Naive)
    ->  Answer = Ours
    ;   print_message(error, format("theory ~w: ~q~n~q differs in ~q:~n~q~nby the axioms~n~q",
                                    [Seed, Clauses, P, What, Ours, Naive])),
        fail
    ).

compared(What, P, Ours, Naive) :-
    answer(What, P, Ours),
    by_axioms(What, P, Ours, Naive).

agree(online(_, _), Ours, Naive) =>
    is_list(Naive),
    memberchk(Ours, Naive).
agree(plan(How), none, Naive) =>
    ( Naive == [] -> true ; memberchk(strategy(beam(_)), How) ).
agree(plan(How), Plan, Naive) =>
    is_list(Naive),
    memberchk(Plan, Naive),
    (   cheapest(How)
    ->  maplist(plan_cost(How), [Plan|Naive], Costs),
        min_list(Costs, Least),
        Costs = [Least|_]
    ;   true
    ).
agree(_, Ours, Naive) =>
    Ours == Naive.

% No estimate of these is too high, or the estimate does not matter.
cheapest([strategy(Strategy)]) :-
    memberchk(Strategy, [breadth, iterative, astar]).
cheapest([cost(_, _)|_]).
cheapest([strategy(best), anytime(true)|_]).

plan_cost(How, Plan, Cost) :-
    findall(C, ( member(A, Plan), ( member(cost(A, C0), How) -> C = C0 ; C = 1 ) ), Cs),
    sum_list(Cs, Cost).

answer(traces, P, Traces) :-
    bound(Bound),
    findall(Trace-Values,
            ( do(P, [], Bound, History),
              reverse(History, Trace),
              values_after(History, our_values, Values) ),
            Traces0),
    sort(Traces0, Traces).
answer(final(H), P, Final) :-
    ( final(P, H) -> Final = true ; Final = false ).
answer(values(H), _, Values) :-
    values_after(H, our_values, Values).
answer(plan(How), P, Plan) :-
    (   do(search(P, How), [], History)
    ->  reverse(History, Plan)
    ;   Plan = none
    ).
answer(online(world(Results, Events), Seed), P, H-Outcome) :-
    bound(Bound),
    set_world(Results, Events),
    catch(indigolog(P, [check(false), device(scripted), seed(Seed), max_actions(Bound), outcome(Outcome), history(H)]),
          error(golog(impossible_result(Action, Result, _)), _),
          ( Outcome = contradiction, H = contradiction(Action, Result) )).

by_axioms(traces, P, _, Traces) :-
    bound(Bound),
    naive_traces(P, Bound, Traces0),
    findall(Trace-Values,
            ( member(Trace, Traces0),
              reverse(Trace, History),
              values_after(History, naive_values, Values) ),
            Traces).
by_axioms(final(H), P, _, Final) :-
    ( naive_final(P, H) -> Final = true ; Final = false ).
by_axioms(values(H), _, _, Values) :-
    values_after(H, naive_values, Values).
by_axioms(plan(_), P, _, Traces) :-
    bound_of_plans(Bound),
    naive_traces(P, Bound, Traces).
by_axioms(online(World, _), P, _-Outcome, Runs) :-
    bound(Bound),
    naive_runs(P, World, Bound, Runs0),
    (   Outcome == contradiction
    ->  findall(contradiction(A, _)-contradiction, member([A|_]-contradiction, Runs0), Runs)
    ;   Runs = Runs0
    ).

values_after(H, Of, Values) :-
    findall(F-Vs, ( fluent(F), call(Of, F, H, Vs) ), Values).

fluent(n).
fluent(m(a)).
fluent(m(b)).
fluent(p(a)).
fluent(p(b)).
fluent(q).
fluent(u).
fluent(w).

our_values(F, H, Vs) :-
    history_situation(H, S),
    fluent_status(F, S, Status),
    (   Status = v(V) -> Vs = [V]
    ;   Status = any(Vs0) -> sort(Vs0, Vs)
    ;   Vs = [none]
    ).


                /* The world of an online run */

:- dynamic results/1, events/1, executed/1.

set_world(Results, Events) :-
    retractall(results(_)), assertz(results(Results)),
    retractall(events(_)), assertz(events(Events)),
    retractall(executed(_)), assertz(executed(0)).

scripted:can_execute(_).
scripted:execute(A, Result) :- agreement:carried_out(A, Result).
scripted:exogenous(As) :- agreement:due(As).

carried_out(A, Result) :-
    retract(executed(N)),
    N1 is N+1,
    assertz(executed(N1)),
    (   naive_values:senses_something(A)
    ->  retract(results([R|Rs])),
        assertz(results(Rs)),
        naive:result_for(A, R, Result)
    ;   Result = none
    ).

due(As) :-
    executed(N),
    events(Es),
    findall(A, ( member(event(M, A), Es), M =< N ), As),
    findall(event(M, A), ( member(event(M, A), Es), M > N ), Rest),
    retractall(events(_)),
    assertz(events(Rest)).
