:- module(test_indigolog_differential,
          [ compare_programs/1        % +Number
          ]).
:- use_module(library(plunit)).
:- use_module(library(lists), [member/2, memberchk/2, reverse/2]).
:- use_module(library(random), [random_member/2, random_permutation/2]).
:- use_module('../../indigolog/indigolog').
:- use_module('../../indigolog/language/progression', [history_situation/2]).
:- use_module('../../indigolog/language/situation', [fluent_status/3]).
:- use_module(naive).
:- use_module(naive_values, [naive_theory/1, naive_values/3]).
:- use_module(random_agents).

/** <module> Random agents behave alike in the interpreter and by the axioms

For each random program of a random theory: the set of complete traces, the values of
all fluents at the end of each, whether the program is final after a random history; and
online, in a random world, that the run is one of those that the axioms allow.  The number
of programs is 400, or what the environment variable PROGRAMS says.
*/

bound(4).

programs_a_theory(10).

% What one comparison may cost; one that costs more is left out and counted.
inferences(2_000_000).

%!  compare_programs(+Number) is semidet.
%
%   Fails, having printed where, if some of Number programs behaves otherwise.

compare_programs(Number) :-
    programs_a_theory(Each),
    Theories is (Number + Each - 1) // Each,
    forall(between(1, Theories, Seed),
           (   alike(Seed, Each)
           ->  progress(Seed, Each, Number)
           ;   fail
           )).

progress(Seed, Each, Number) :-
    Done is Seed*Each,
    (   Number >= 1000,
        Done mod 1000 =:= 0
    ->  flag(differential_left_out, Out, Out),
        flag(differential_compared, Compared, Compared),
        flag(differential_traces, Traces, Traces),
        print_message(informational,
                      format("~D programs alike: ~D comparisons, ~D traces; ~D comparisons left out",
                             [Done, Compared, Traces, Out]))
    ;   true
    ).

alike(Seed, Each) :-
    set_random(seed(Seed)),
    random_member(Kind, [plain, sensing, knowing]),
    random_theory(Kind, Clauses),
    load_clauses(Clauses),
    naive_theory(Clauses),
    retractall(answered(_, _, _)),
    forall(between(1, Each, I),
           ( Own is Seed*1000 + I,
             set_random(seed(Own)),
             random_program(Kind, 3, P),
             random_program(online(Kind), 2, Q),
             random_world(World),
             random_history(H),
             same(traces, P, Seed, Clauses),
             same(final(H), P, Seed, Clauses),
             same(values(H), P, Seed, Clauses),
             same(online(World), Q, Seed, Clauses) )),
    same_again(Seed, Clauses),
    load_clauses(Clauses),
    same_again(Seed, Clauses).

load_clauses(Clauses) :-
    tmp_file_stream(File, Stream, [extension(pl)]),
    close(Stream),
    write_theory(File, Clauses),
    call_cleanup(load_theory(File), delete_file(File)).

:- dynamic answered/3.                % Question, Program, Answer

% No answer depends on what was asked before: each question again, in random order.
same_again(Seed, Clauses) :-
    findall(asked(What, P, Answer), answered(What, P, Answer), Asked),
    random_permutation(Asked, Questions),
    forall(member(asked(What, P, Answer), Questions),
           (   answer(What, P, Again),
               Again == Answer
           ->  true
           ;   print_message(error, format("theory ~w: ~q~n~q asked for ~q again:~n~q~nbefore~n~q",
                                           [Seed, Clauses, P, What, Again, Answer])),
               fail
           )).

same(What, P, Seed, Clauses) :-
    inferences(Most),
    (   catch(call_with_inference_limit(compared(What, P, Ours, Naive), Most, Result),
              Error,
              ( Ours = Error, Naive = none ))
    ->  true
    ;   Ours = failed, Naive = none
    ),
    (   Result == inference_limit_exceeded    % too many executions to list them all
    ->  flag(differential_left_out, Out, Out+1)
    ;   agree(What, Ours, Naive)
    ->  flag(differential_compared, Compared, Compared+1),
        ( memberchk(What, [traces, final(_)]) -> assertz(answered(What, P, Ours)) ; true ),
        (   What == traces
        ->  length(Ours, Traces),
            flag(differential_traces, Before, Before+Traces)
        ;   true
        )
    ;   print_message(error, format("theory ~w: ~q~n~q differs in ~q:~n~q~nby the axioms~n~q",
                                    [Seed, Clauses, P, What, Ours, Naive])),
        fail
    ).

agree(online(_), Ours, Naive) :- !, is_list(Naive), memberchk(Ours, Naive).
agree(_, Same, Same).

answer(traces, P, Traces) :-
    bound(Bound),
    findall(Trace,
            ( do(P, [], Bound, History),
              reverse(History, Trace) ),
            Traces0),
    sort(Traces0, Traces).
answer(final(H), P, Final) :-
    ( final(P, H) -> Final = true ; Final = false ).

compared(traces, P, Ours, Naive) :-
    answer(traces, P, Ours),
    bound(Bound),
    naive_traces(P, Bound, Naive).
compared(final(H), P, Ours, Naive) :-
    answer(final(H), P, Ours),
    ( naive_final(P, H) -> Naive = true ; Naive = false ).
compared(values(H0), P, Ours, Naive) :-
    bound(Bound),
    naive_traces(P, Bound, Traces),
    findall(T, ( member(T0, Traces), reverse(T0, T) ), Hs),
    findall(H-F-Vs, ( member(H, [H0|Hs]), fluent(F), our_values(F, H, Vs) ), Ours),
    findall(H-F-Vs, ( member(H, [H0|Hs]), fluent(F), naive_values(F, H, Vs) ), Naive).
compared(online(World), P, H-Outcome, Naive) :-
    bound(Bound),
    World = world(Results, Events),
    set_world(Results, Events),
    catch(indigolog(P, [check(false), device(scripted), max_actions(Bound), outcome(Outcome), history(H)]),
          error(golog(impossible_result(A, R, _)), _),
          ( Outcome = contradiction, H = contradiction(A, R) )),
    naive_runs(P, World, Bound, Naive0),
    (   Outcome == contradiction
    ->  findall(contradiction(A, R)-contradiction, member(_-contradiction, Naive0), Naive)
    ;   Naive = Naive0
    ).

fluent(n).
fluent(m(a)).
fluent(m(b)).
fluent(p(a)).
fluent(p(b)).
fluent(q).
fluent(F) :- member(F, [u, w]), naive_values:fluent(F).

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
scripted:execute(A, Result) :- test_indigolog_differential:carried_out(A, Result).
scripted:exogenous(As) :- test_indigolog_differential:due(As).

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

number_of_programs(N) :-
    (   getenv('PROGRAMS', Text)
    ->  atom_number(Text, N)
    ;   N = 400
    ).

:- begin_tests(differential).

test(alike, true(LeftOut * 20 < N)) :-
    number_of_programs(N),
    forall(member(Flag, [differential_left_out, differential_compared, differential_traces]), flag(Flag, _, 0)),
    compare_programs(N),
    flag(differential_left_out, LeftOut, LeftOut).

:- end_tests(differential).
