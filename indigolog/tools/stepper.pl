:- module(indigolog_stepper,
          [ start_stepper/3,          % +Program, +Options, -Stepper
            stop_stepper/1,           % +Stepper
            command/4                 % +Command, +Stepper, -Stepper1, -Answer
          ]).
/** <module> A program step by step, by hand

A stepper is stepper(Configurations, Devices), the configurations being
conf(E, S, Entries), the newest first: the program that remains, the situation,
and what a journal tells of the time after it, if one is replayed.

The commands are those that the console (console.pl) lists, as terms.
*/

:- use_module(library(aggregate), [aggregate_all/3]).
:- use_module(library(lists), [member/2, reverse/2]).
:- use_module(library(option), [option/3]).
:- use_module(library(solution_sequences), [limit/2]).
:- use_module('../language/configuration').
:- use_module('../language/context', [top_context/1]).
:- use_module('../online/devices').
:- use_module(checks, [check_program/1]).
:- use_module(effort, [found_within/5]).
:- use_module(explain, [why/3]).
:- use_module('../language/formula', [holds_in/2]).
:- use_module('../language/history', [own_step/1]).
:- use_module('../online/journal', [journal_entries/3]).
:- use_module('../online/run_options', [known_options/1]).
:- use_module('../online/runs', [begin_run/2, end_run/1]).
:- use_module('../language/progression', [progress/3]).
:- use_module('../language/sensing', [sensing_action/2]).
:- use_module('../language/situation').
:- use_module('../online/terminal', [ask_in/2]).
:- use_module('../language/theory').

:- meta_predicate within_limit(0).

%!  start_stepper(+Program, +Options, -Stepper) is det.
%
%   Options are device(Module)*, deadline(Seconds) as for indigolog/2, and
%   replay(File): steps are those of that journal to its end.

start_stepper(Program, Options, stepper([conf(Program, S, Entries)], Devices)) :-
    known_options(Options),
    current_theory(Theory),
    option(replay(File), Options, none),
    (   File == none
    ->  Entries = []
    ;   exists_file(File),
        journal_entries(File, _, Entries)
    ->  true
    ;   throw(error(golog(no_journal(File)), _))
    ),
    initial_situation(Theory, S),
    begin_run(_, Run),
    catch(open_devices(Options, Theory, Run, Devices), Error, ( end_run(Run), throw(Error) )).

%!  stop_stepper(+Stepper) is det.

stop_stepper(stepper(_, Devices)) :-
    Devices = devices(_, Run, _),
    call_cleanup(close_devices(Devices), end_run(Run)).

%!  command(+Command, +Stepper, -Stepper1, -Answer) is det.

command(step, Stepper, Stepper1, Answer) =>
    command(step(1), Stepper, Stepper1, Answer).
command(step(N), Stepper, Stepper1, Answer) =>
    Stepper = stepper([Now|Past], Devices),
    (   step(N, Now, Devices, New, Happened)
    ->  Stepper1 = stepper([New, Now|Past], Devices),
        Answer = happened([Happened])
    ;   Stepper1 = Stepper,
        (   N > 1
        ->  Answer = no_such_step(N)
        ;   stuck(Now, Answer)
        )
    ).
command(run, Stepper, Stepper1, Answer) =>
    command(run(inf), Stepper, Stepper1, Answer).
command(run(N), stepper([Now|Past], Devices), Stepper1, Answer) =>
    run(N, Now, Devices, New, Happened),
    (   Happened == []
    ->  Stepper1 = stepper([Now|Past], Devices)
    ;   Stepper1 = stepper([New, Now|Past], Devices)
    ),
    (   step_is_left(N, Happened)
    ->  stuck(New, End)
    ;   End = none
    ),
    Answer = ran(Happened, End).
command(exog(A), stepper([Now|Past], Devices), Stepper1, Answer) =>
    Now = conf(E, S, Entries),
    situation_theory(S, Theory),
    theory_module(Theory, Module),
    (   ground(A),
        Module:exog_action(A)
    ->  progress(A, S, S1),
        Stepper1 = stepper([conf(E, S1, Entries), Now|Past], Devices),
        Answer = happened([A])
    ;   Stepper1 = stepper([Now|Past], Devices),
        Answer = not_exogenous(A)
    ).
command(undo, stepper([Now|Past], Devices), Stepper1, Answer) =>
    (   Past == []
    ->  Stepper1 = stepper([Now], Devices),
        Answer = nothing_to_undo
    ;   Stepper1 = stepper(Past, Devices),
        Past = [conf(_, S, _)|_],
        situation_history(S, History),
        aggregate_all(count, ( member(A, History), \+ own_step(A) ), N),
        Answer = undone(N)
    ).
command(Question, Stepper, Stepper1, Answer) =>
    Stepper1 = Stepper,
    Stepper = stepper([Now|_], _),
    told(Question, Now, Answer).

% What changes nothing.
told(next, conf(E, S, _), Answer) =>
    possible_actions(E, S, Actions, All),
    may_end(E, S, End),
    ( All == true -> Answer = next(Actions, End) ; Answer = next_few(Actions, End) ).
told(fluents, Now, Answer) =>
    told(fluents(_), Now, Answer).
told(fluents(F), conf(_, S, _), Answer) =>
    known_fluents(S, Pairs),
    findall(F0-V, ( member(F0-V, Pairs), once(called(F, F0)) ), Matching),
    Answer = fluents(Matching).
told(program, conf(E, _, _), Answer) =>
    Answer = program(E).
told(history, conf(_, S, _), Answer) =>
    situation_history(S, History),
    reverse(History, Actions),
    Answer = history(Actions).
told(test(P), conf(_, S, _), Answer) =>
    check_program(?(P)),
    (   holds_in(P, S)
    ->  Answer = holds(P)
    ;   told(why(holds(P)), conf(_, S, _), Answer)
    ).
told(why, conf(E, S, _), Answer) =>
    told(why(E), conf(E, S, _), Answer).
told(why(Question), conf(_, S, _), Answer) =>
    why(Question, S, Whys),
    Answer = why(Whys).
told(help, _, Answer) =>
    Answer = help.

% called(+F, ?Fluent): Fluent matches F, or has arguments and is of this name.
called(F, F).
called(Name, Fluent) :-
    compound(Fluent),
    compound_name_arity(Fluent, Name, _).


                /* Steps */

% Of a program that has no end of steps, as a search that finds ever longer plans, those that are found first.
most_actions(100).                      % chosen by hand
most_inferences(5_000_000).             % chosen by hand: about a second

% possible_actions(+E, +S, -Actions, -All): All is false where there may be more.
possible_actions(E, S, Actions, All) :-
    top_context(C),
    most_actions(Most),
    most_inferences(Limit),
    found_within(Limit, A, limit(Most, ( after_action(E, S, C, _, S1), last_action(S1, A) )), Actions, Whole),
    length(Actions, N),
    ( Whole == true, N < Most -> All = true ; All = false ).

waits(E, S) :-
    top_context(C),
    once(after_action(E, S, C, _, S1)),
    last_action(S1, wait).

may_end(E, S, End) :-
    top_context(C),
    (   within_limit(ends(E, S, C))
    ->  End = may_end
    ;   End = no
    ).

within_limit(Goal) :-
    most_inferences(Limit),
    call_with_inference_limit(Goal, Limit, Result),
    !,
    Result \== inference_limit_exceeded.

stuck(conf(E, S, _), Answer) :-
    (   may_end(E, S, may_end)
    ->  Answer = final
    ;   waits(E, S)
    ->  Answer = waits
    ;   why(E, S, Whys),
        Answer = stuck(Whys)
    ).

% What the journal tells, or the N-th action, carried out.
step(_, conf(E, S, [exogenous(_, A)|Entries]), _, conf(E, S1, Entries), Happened) :-
    !,
    Happened = A,
    progress(A, S, S1).
step(_, conf(E, S, [Entry|Entries]), _, conf(E1, S2, Entries), Happened) :-
    !,
    arg(2, Entry, A),
    top_context(C),
    (   after_action(E, S, C, E1, S1),
        last_action(S1, A1),
        A1 == A
    ->  true
    ;   throw(error(golog(journal_differs(Entry, E)), _))
    ),
    (   Entry = executed(_, _, Sensing)
    ->  sensed(Sensing, A, S1, S2),
        Happened = A
    ;   Entry = failed(_, _, Reason),
        Happened = failed(A, Reason),
        progress(Happened, S, S2)
    ).
step(N, conf(E, S, []), Devices, conf(E1, S2, []), A) :-
    top_context(C),
    ( N == 1 -> nth_step(N, E, S, C, E1, S1) ; within_limit(nth_step(N, E, S, C, E1, S1)) ),
    last_action(S1, A),
    (   A == wait
    ->  waited(S),
        S2 = S
    ;   situation_theory(S, Theory),
        ask_in(S1, execute_action(Devices, Theory, A, Sensing)),
        sensed(Sensing, A, S1, S2)
    ).

nth_step(N, E, S, C, E1, S1) :-
    Count = count(0),
    after_action(E, S, C, E1, S1),
    arg(1, Count, N0),
    N1 is N0+1,
    nb_setarg(1, Count, N1),
    N1 == N,
    !.

% The exogenous action that is waited for has just happened.
waited(S) :-
    last_action(S, A),
    situation_theory(S, Theory),
    theory_module(Theory, Module),
    \+ \+ Module:exog_action(A).

sensed(Sensing, A, S1, S2) :-
    situation_theory(S1, Theory),
    (   Sensing \== none,
        sensing_action(Theory, A)
    ->  progress(e(A, Sensing), S1, S2)
    ;   S2 = S1
    ).

run(N, Now, Devices, New, Happened) :-
    (   N \== 0,
        step(1, Now, Devices, Next, A)
    ->  Happened = [A|More],
        fewer(N, N1),
        run(N1, Next, Devices, New, More)
    ;   New = Now,
        Happened = []
    ).

fewer(inf, inf) :- !.
fewer(N, N1) :- N1 is N-1.

step_is_left(inf, _).
step_is_left(N, Happened) :-
    integer(N),
    length(Happened, Done),
    Done < N.
