:- module(indigolog_executive,
          [ run/2,                    % +Program, :Options
            request_stop/1,           % +Reason
            internal_action/1         % +Action
          ]).
:- use_module(library(lists), [append/3, member/2]).
:- use_module(library(option), [option/2, option/3, meta_options/3]).
:- use_module(library(time), [call_with_time_limit/2]).
:- use_module(chance).
:- use_module(context, [top_context/1]).
:- use_module(journal).
:- use_module(situation).
:- use_module(termination, [final/3]).
:- use_module(theory).
:- use_module(transition, [step/4]).

:- meta_predicate run(+, :).

/** <module> The online executive

Each turn takes in the exogenous actions that have arrived, in their order, and
then makes one step of the program: a step is first looked for, and only a
program that has none may end.  An action of the step is carried to the device
that can execute it before the next turn.
*/

:- dynamic stop_requested/1.

%!  request_stop(+Reason) is det.
%
%   Make the run end between two steps with stopped(Reason).  May be called
%   from a signal handler, a device or another thread.

request_stop(Reason) :-
    assertz(stop_requested(Reason)).

%!  run(+Program, :Options) is det.

run(Program, Options0) :-
    meta_options(is_meta, Options0, Options),
    retractall(stop_requested(_)),
    current_theory(Theory),
    forget_initial_values(Theory),
    initial_situation(Theory, S0),
    past(Options, Program, Seed, Entries),
    set_seed(Seed),
    set_random(seed(Seed)),
    findall(D, member(device(D), Options), Devices),
    option(journal(File), Options, none),
    option(on_action(OnAction), Options, none),
    option(max_actions(Max), Options, inf),
    option(deadline(Deadline), Options, none),
    new_facts_only(File, Options, Entries, Skip),
    setup_call_cleanup(
        journal_open(File, Journal),
        ( begin(Skip, Journal, begun(Program, Seed)),
          X = x(Devices, Journal, OnAction, Max, Deadline),
          catch(turn(Program, S0, 0, 0, Entries, Skip, X, S, Outcome),
                Error,
                ended_by(Error, Journal)),
          journal_write(Journal, ended(Outcome)) ),
        journal_close(Journal)),
    situation_history(S, History),
    option(history(History), Options, _),
    option(situation(S), Options, _),
    told(Outcome, Options, Program, S).

is_meta(on_action).

told(Outcome, Options, Program, S) :-
    (   option(outcome(Outcome0), Options)
    ->  Outcome0 = Outcome
    ;   Outcome == final
    ->  true
    ;   situation_history(S, History),
        throw(error(golog(program_ended(Outcome, Program, History)), _))
    ).

ended_by(Error, Journal) :-
    journal_write(Journal, ended(error(Error))),
    throw(Error).

% past(+Options, +Program, -Seed, -Entries): what a resumed run has behind it.
past(Options, Program, Seed, Entries) :-
    (   option(resume(File), Options)
    ->  (   exists_file(File),
            journal_entries(File, begun(Program0, Seed), Entries)
        ->  true
        ;   throw(error(golog(no_journal(File)), _))
        ),
        (   Program0 =@= Program
        ->  true
        ;   throw(error(golog(other_program(File, Program0)), _))
        )
    ;   option(seed(Seed0), Options)
    ->  Seed = Seed0, Entries = []
    ;   Seed is random(1_000_000_000), Entries = []
    ).

% Facts that are in the journal already are not written again.
new_facts_only(File, Options, Entries, Skip) :-
    (   option(resume(Resumed), Options),
        File \== none,
        same_file(File, Resumed)
    ->  length(Entries, Skip)
    ;   Skip = 0
    ).

begin(0, Journal, Begun) =>
    journal_write(Journal, Begun).
begin(_, _, _) =>
    true.


                /* One turn */

% turn(+E, +S, +Turn, +Count, +Entries, +Skip, +X, -FinalSituation, -Outcome)

turn(E, S0, T, Count, Entries0, Skip0, X, S, Outcome) :-
    stop_if_requested,
    arrived(Entries0, T, X, S0, Events, Entries),
    take_in(Events, T, X, S0, S1, Skip0, Skip),
    X = x(_, _, _, Max, _),
    (   next(Entries, T, E, S1, E1, S2)
    ->  situation_length(S1, N1),
        situation_length(S2, N2),
        T1 is T+1,
        (   N1 =:= N2
        ->  turn(E1, S2, T1, Count, Entries, Skip, X, S, Outcome)
        ;   situation_history(S2, [A|_]),
            (   A == wait
            ->  wait_for_events(Entries, X),
                turn(E1, S1, T1, Count, Entries, Skip, X, S, Outcome)
            ;   A == abort
            ->  S = S2, Outcome = aborted
            ;   Count >= Max
            ->  S = S1, Outcome = limit
            ;   do_action(A, T, Entries, Skip, X, S1, S2, S3, Entries1, Skip1),
                Count1 is Count+1,
                turn(E1, S3, T1, Count1, Entries1, Skip1, X, S, Outcome)
            )
        )
    ;   Entries \== []
    ->  Entries = [Entry|_],
        throw(error(golog(journal_differs(Entry, E)), _))
    ;   S = S1,
        (   top_context(C),
            final(E, S1, C)
        ->  Outcome = final
        ;   Outcome = failed
        )
    ).

stop_if_requested :-
    (   retract(stop_requested(Reason))
    ->  throw(stopped(Reason))
    ;   true
    ).

% A step, and while a journal is followed the step that it tells of.
next(Entries, T, E, S, E1, S1) :-
    step(E, S, E1, S1),
    as_told(Entries, T, S, S1),
    !.

as_told([], _, _, _) =>
    true.
as_told([Entry|_], T, S, S1) =>
    situation_length(S, N),
    situation_length(S1, N1),
    (   N =:= N1
    ->  arg(1, Entry, T0),
        T0 > T
    ;   situation_history(S1, [A|_]),
        (   A == wait
        ->  true
        ;   arg(1, Entry, T),
            arg(2, Entry, A)
        )
    ).


                /* Exogenous actions */

arrived([exogenous(T, A)|Entries0], T, X, S, Events, Entries) :-
    !,
    Events = [A|Events1],
    arrived(Entries0, T, X, S, Events1, Entries).
arrived([Entry|Entries], _, _, _, [], [Entry|Entries]) :-
    !.
arrived([], _, X, S, Events, []) :-
    poll(X, S, Events).

poll(x([], _, _, _, _), S, Events) =>
    situation_theory(S, Theory),
    theory_module(Theory, Module),
    (   clause(Module:exog_occurs(_), _),
        Module:exog_occurs(A),
        nonvar(A),
        Module:exog_action(A)
    ->  Events = [A]
    ;   Events = []
    ).
poll(x(Devices, _, _, _, _), _, Events) =>
    events_of(Devices, Events).

events_of([], []).
events_of([D|Ds], Events) :-
    (   current_predicate(D:exogenous/1)
    ->  D:exogenous(Here)
    ;   Here = []
    ),
    append(Here, More, Events),
    events_of(Ds, More).

take_in([], _, _, S, S, Skip, Skip).
take_in([A|As], T, X, S0, S, Skip0, Skip) :-
    situation_theory(S0, Theory),
    theory_module(Theory, Module),
    (   \+ \+ Module:exog_action(A)
    ->  progress(A, S0, S1),
        happened(exogenous(T, A), A, X, S1, Skip0, Skip1)
    ;   print_message(warning, golog(undeclared_event(A))),
        S1 = S0, Skip1 = Skip0
    ),
    take_in(As, T, X, S1, S, Skip1, Skip).

% Write Fact to the journal, unless it came from there, and tell of Action.
happened(Fact, Action, X, S, Skip0, Skip) :-
    X = x(_, Journal, OnAction, _, _),
    (   Skip0 > 0
    ->  Skip is Skip0-1
    ;   Skip = 0,
        journal_write(Journal, Fact)
    ),
    (   OnAction == none
    ->  true
    ;   ignore(call(OnAction, Action, S))
    ).

wait_for_events(Entries, X) :-
    (   Entries \== []
    ->  true
    ;   X = x([], _, _, _, _)
    ->  true                              % exog_occurs/1 itself waits
    ;   sleep(0.01),
        stop_if_requested
    ).


                /* Primitive actions */

%!  internal_action(+Action) is semidet.
%
%   Action is the interpreter's own and not sent to a device.

internal_action(stop_interrupts).
internal_action(set(_)).
internal_action(unset(_)).
internal_action(test(_)).
internal_action(e(_, _)).

% do_action(+A, +Turn, +Entries, +Skip, +X, +S1, +S2, -S3, -Entries1, -Skip1):
% S1 is the situation before A, S2 the one after it, S3 with what was sensed.

do_action(A, T, Entries, Skip, X, S1, S2, S3, Entries1, Skip1) :-
    (   Entries = [Entry|Entries1]
    ->  replayed(Entry, Result)
    ;   Entries1 = [],
        carry_out(A, X, S2, Result)
    ),
    (   Result = failed(Reason)
    ->  progress(failed(A, Reason), S1, S3),
        happened(failed(T, A, Reason), failed(A, Reason), X, S3, Skip, Skip1)
    ;   Result = done(Sensing),
        situation_theory(S2, Theory),
        (   Sensing \== none,
            sensing_action(Theory, A)
        ->  progress(e(A, Sensing), S2, S3)
        ;   S3 = S2
        ),
        happened(executed(T, A, Sensing), A, X, S3, Skip, Skip1)
    ),
    (   Entries == []
    ->  true
    ;   resumed_if_last(Entries1, X, S3)
    ).

replayed(executed(_, _, Sensing), done(Sensing)).
replayed(failed(_, _, Reason), failed(Reason)).

% A device that defines resumed/1 learns that it takes over from here.
resumed_if_last([], x(Devices, _, _, _, _), S) :-
    !,
    forall(( member(D, Devices), current_predicate(D:resumed/1) ),
           D:resumed(S)).
resumed_if_last(_, _, _).

carry_out(A, X, S, Result) :-
    X = x(Devices, _, _, _, Deadline),
    situation_theory(S, Theory),
    catch(( in_time(Deadline, A, executed_by(Devices, Theory, A, Sensing0)),
            sensing(Theory, A, Sensing0, Sensing),
            Result = done(Sensing) ),
          Error,
          failure(Error, A, Theory, Result)).

in_time(none, _, Goal) :-
    !,
    call(Goal).
in_time(Seconds, A, Goal) :-
    catch(call_with_time_limit(Seconds, Goal),
          time_limit_exceeded,
          throw(error(golog(deadline(A, Seconds)), _))).

executed_by(Devices, Theory, A, Sensing) :-
    (   internal_action(A)
    ->  true
    ;   member(D, Devices),
        D:can_execute(A)
    ->  (   D:execute(A, Sensing)
        ->  true
        ;   throw(error(golog(device_failed(D, A)), _))
        )
    ;   Devices \== [], \+ sensing_action(Theory, A)
    ->  true
    ;   theory_module(Theory, Module),
        clause(Module:execute(_, _), _)
    ->  (   Module:execute(A, Sensing)
        ->  true
        ;   throw(error(golog(device_failed(theory, A)), _))
        )
    ;   indigolog_terminal:ask_execute(A, Sensing)
    ).

sensing(Theory, A, Sensing0, Sensing) :-
    (   nonvar(Sensing0)
    ->  Sensing = Sensing0
    ;   sensing_action(Theory, A)
    ->  throw(error(golog(nothing_sensed(A)), _))
    ;   Sensing = none
    ).

% A failed action is an exogenous action if the theory declares it.
failure(Error, A, Theory, Result) :-
    theory_module(Theory, Module),
    (   Error = error(Reason, _),
        \+ \+ Module:exog_action(failed(A, Reason))
    ->  Result = failed(Reason)
    ;   throw(Error)
    ).
