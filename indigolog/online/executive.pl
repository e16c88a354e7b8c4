:- module(indigolog_executive,
          [ run/2,                    % +Program, :Options
            request_stop/1,           % +Reason
            request_abort/0
          ]).
:- use_module(library(lists), [member/2, memberchk/2]).
:- use_module(library(option), [option/2, option/3, meta_options/3]).
:- use_module('../language/chance').
:- use_module('../language/context', [top_context/1]).
:- use_module(devices).
:- use_module(journal).
:- use_module('../language/notice', [progress_message/1]).
:- use_module('../language/patience', [still_patient/3, with_patience/2]).
:- use_module('../language/progression', [progress/3]).
:- use_module('../language/sensing', [sensing_action/2]).
:- use_module('../language/situation').
:- use_module(terminal, [ask_in/2]).
:- use_module('../language/theory').
:- use_module('../language/semantics', [final/3, step/4]).

:- meta_predicate run(+, :).

/** <module> The online executive

Each turn takes in the exogenous actions that have arrived, in their order, and
then makes one step of the program: a step is first looked for, and only a
program that has none may end.  An action of the step is carried to the device
that can execute it before the next turn.

What stays the same during a run is x(Devices, Journal, on(OnAction, OnFact), Max,
MaxWait, Mode), Mode being `live`, or `replay` where only a journal is followed.
*/

:- dynamic requested/1.               % stop(Reason) or abort

%!  request_stop(+Reason) is det.
%
%   Make the run end between two steps with stopped(Reason).  May be called
%   from a signal handler, a device or another thread.

request_stop(Reason) :-
    assertz(requested(stop(Reason))).

%!  request_abort is det.
%
%   Make the run end between two steps with outcome `aborted`, as abort/0 in a
%   program does.  May be called as request_stop/1.

request_abort :-
    assertz(requested(abort)).

%!  run(+Program, :Options) is det.

run(Program, Options0) :-
    meta_options(is_meta, Options0, Options),
    known_options(Options),
    retractall(requested(_)),
    renewed_theory(Theory),
    initial_situation(Theory, S0),
    past(Options, Program, Seed, Entries, Mode),
    set_seed(Seed),
    set_random(seed(Seed)),
    option(journal(File), Options, none),
    option(on_action(OnAction), Options, none),
    option(on_fact(OnFact), Options, none),
    option(max_actions(Max), Options, inf),
    option(max_wait(MaxWait), Options, inf),
    new_facts_only(File, Options, Entries, Skip),
    setup_call_cleanup(
        opened(Mode, Options, Theory, File, Devices, Journal),
        ( begin(Skip, Journal, begun(Program, Seed)),
          X = x(Devices, Journal, on(OnAction, OnFact), Max, MaxWait, Mode),
          nb_setval(indigolog_silent, 0),
          option(max_silent(Silent), Options, default),
          catch(with_patience(Silent,
                    turn(Program, S0, 0, 0, Entries, Skip, X, S, Rest, Outcome)),
                Error,
                ended_by(Error, Journal)),
          journal_write(Journal, ended(Outcome)) ),
        closed(Devices, Journal)),
    situation_history(S, History),
    option(history(History), Options, _),
    option(situation(S), Options, _),
    option(rest(Rest), Options, _),
    told(Outcome, Options, Rest, S).

is_meta(on_action).
is_meta(on_fact).

known_options(Options) :-
    (   member(Option, Options),
        \+ known_option(Option)
    ->  throw(error(golog(unknown_option(Option)), _))
    ;   true
    ).

known_option(check(_)).                % done by indigolog/2
known_option(device(_)).
known_option(device(_, _)).
known_option(deadline(_)).
known_option(journal(_)).
known_option(resume(_)).
known_option(replay(_)).
known_option(seed(_)).
known_option(max_actions(_)).
known_option(max_wait(_)).
known_option(max_silent(_)).
known_option(on_action(_)).
known_option(on_fact(_)).
known_option(history(_)).
known_option(situation(_)).
known_option(rest(_)).
known_option(outcome(_)).

opened(replay, _, Theory, _, Devices, Journal) =>
    journal_open(none, Journal),
    open_devices([], Theory, Devices).
opened(live, Options, Theory, File, Devices, Journal) =>
    journal_open(File, Journal),
    catch(open_devices(Options, Theory, Devices), Error,
          ( journal_close(Journal), throw(Error) )).

closed(Devices, Journal) :-
    call_cleanup(close_devices(Devices), journal_close(Journal)).

told(Outcome, Options, Rest, S) :-
    (   option(outcome(Outcome0), Options)
    ->  Outcome0 = Outcome
    ;   ( Outcome == final ; Outcome == replayed )
    ->  true
    ;   situation_history(S, History),
        throw(error(golog(program_ended(Outcome, Rest, History)), _))
    ).

ended_by(Error, Journal) :-
    journal_write(Journal, ended(error(Error))),
    throw(Error).

% past(+Options, +Program, -Seed, -Entries, -Mode): what a resumed run has behind it.
past(Options, Program, Seed, Entries, Mode) :-
    (   option(resume(File), Options)
    ->  Mode = live,
        followed(File, Program, Seed, Entries)
    ;   option(replay(File), Options)
    ->  Mode = replay,
        followed(File, Program, Seed, Entries)
    ;   Mode = live,
        Entries = [],
        option(seed(Seed0), Options, none),
        ( Seed0 == none -> Seed is random(1_000_000_000) ; Seed = Seed0 )
    ).

followed(File, Program, Seed, Entries) :-
    (   exists_file(File),
        journal_entries(File, begun(Program0, Seed), Entries)
    ->  true
    ;   throw(error(golog(no_journal(File)), _))
    ),
    (   Program0 =@= Program
    ->  true
    ;   throw(error(golog(other_program(File, Program0)), _))
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

% turn(+E, +S, +Turn, +Count, +Entries, +Skip, +X, -FinalSituation, -Rest, -Outcome)

turn(E, S0, T, Count, Entries0, Skip0, X, S, Rest, Outcome) :-
    (   requested(Request)
    ->  by_request(Request),
        S = S0, Rest = E, Outcome = aborted
    ;   Entries0 == [],
        X = x(_, _, _, _, _, replay)
    ->  S = S0, Rest = E, Outcome = replayed
    ;   arrived(Entries0, T, X, Events, Entries),
        take_in(Events, T, X, S0, S1, Skip0, Skip),
        resumed_if_last(Entries0, Entries, X, S1),
        (   next(Entries, T, E, S1, E1, S2)
        ->  stepped(E, S1, E1, S2, T, Count, Entries, Skip, X, S, Rest, Outcome)
        ;   Entries \== []
        ->  Entries = [Entry|_],
            throw(error(golog(journal_differs(Entry, E)), _))
        ;   S = S1, Rest = E,
            (   top_context(C),
                final(E, S1, C)
            ->  Outcome = final
            ;   Outcome = failed
            )
        )
    ).

stepped(E, S1, E1, S2, T, Count, Entries, Skip, X, S, Rest, Outcome) :-
    T1 is T+1,
    situation_length(S1, N1),
    situation_length(S2, N2),
    (   N1 =:= N2
    ->  nb_getval(indigolog_silent, Silent),
        Silent1 is Silent+1,
        still_patient(Silent1, E1, S2),
        nb_setval(indigolog_silent, Silent1),
        turn(E1, S2, T1, Count, Entries, Skip, X, S, Rest, Outcome)
    ;   nb_setval(indigolog_silent, 0),
        situation_history(S2, [A|_]),
        X = x(_, _, _, Max, _, _),
        (   A == wait
        ->  wait_for_events(Entries, X),
            turn(E1, S1, T1, Count, Entries, Skip, X, S, Rest, Outcome)
        ;   A == abort
        ->  S = S2, Rest = E1, Outcome = aborted
        ;   Count >= Max
        ->  S = S1, Rest = E, Outcome = limit
        ;   do_action(A, T, Entries, Skip, X, S1, S2, S3, Entries1, Skip1),
            Count1 is Count+1,
            turn(E1, S3, T1, Count1, Entries1, Skip1, X, S, Rest, Outcome)
        )
    ).

by_request(stop(Reason)) :-
    retractall(requested(_)),
    throw(stopped(Reason)).
by_request(abort) :-
    retractall(requested(_)).

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

arrived([exogenous(T, A)|Entries0], T, X, Events, Entries) :-
    !,
    Events = [A|Events1],
    arrived(Entries0, T, X, Events1, Entries).
arrived([Entry|Entries], _, _, [], [Entry|Entries]) :-
    !.
arrived([], _, X, Events, []) :-
    X = x(Devices, _, _, _, _, Mode),
    (   Mode == replay
    ->  Events = []
    ;   arrived_events(Devices, Events)
    ).

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
    X = x(_, Journal, on(OnAction, OnFact), _, _, _),
    (   Skip0 > 0
    ->  Skip is Skip0-1
    ;   Skip = 0,
        journal_write(Journal, Fact)
    ),
    progress_message(Fact),
    ( OnAction == none -> true ; ignore(call(OnAction, Action, S)) ),
    ( OnFact == none -> true ; ignore(call(OnFact, Fact, S)) ).

wait_for_events([_|_], _).
wait_for_events([], x(Devices, _, _, _, MaxWait, _)) :-
    progress_message(waiting),
    wait_for_event(Devices, MaxWait, requested(_)).


                /* Primitive actions */

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
        ->  boolean_if_relational(A, Sensing, Theory),
            progress(e(A, Sensing), S2, S3)
        ;   S3 = S2
        ),
        happened(executed(T, A, Sensing), A, X, S3, Skip, Skip1)
    ),
    resumed_if_last(Entries, Entries1, X, S3).

boolean_if_relational(A, Sensing, Theory) :-
    theory_module(Theory, Module),
    (   Module:senses(A, F),
        fluent_template(Theory, F, rel),
        \+ memberchk(Sensing, [true, false])
    ->  throw(error(golog(not_boolean_result(A, F, Sensing)), _))
    ;   true
    ).

replayed(executed(_, _, Sensing), done(Sensing)).
replayed(failed(_, _, Reason), failed(Reason)).

% The devices learn that they take over when the last entry has been followed.
resumed_if_last([_|_], [], x(Devices, _, _, _, _, live), S) :-
    !,
    tell_resumed(Devices, S).
resumed_if_last(_, _, _, _).

carry_out(A, X, S, Result) :-
    X = x(Devices, _, _, _, _, _),
    situation_theory(S, Theory),
    catch(( ask_in(S, execute_action(Devices, Theory, A, Sensing)),
            Result = done(Sensing) ),
          Error,
          failure(Error, A, S, Result)).

% A failed action is an exogenous action if the theory declares it.
failure(Error, A, S, Result) :-
    situation_theory(S, Theory),
    theory_module(Theory, Module),
    (   Error = error(Reason, _),
        \+ \+ Module:exog_action(failed(A, Reason))
    ->  Result = failed(Reason)
    ;   throw(Error)
    ).
