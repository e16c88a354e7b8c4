:- module(indigolog_executive,
          [ run/2                     % +Program, :Options
          ]).
/** <module> The online executive: a run, from its options to its outcome */

:- use_module(library(option), [option/2, option/3, meta_options/3]).
:- use_module('../language/chance', [with_seed/2]).
:- use_module('../language/patience', [with_patience/2]).
:- use_module('../language/situation').
:- use_module('../language/theory', [renewed_theory/1, while_used/2]).
:- use_module(devices, [close_devices/1, open_devices/4]).
:- use_module(journal).
:- use_module(run_options, [known_options/1]).
:- use_module(runs, [begin_run/2, end_run/1]).
:- use_module(turn).

:- meta_predicate run(+, :).

%!  run(+Program, :Options) is det.

run(Program, Options0) :-
    meta_options(is_meta, Options0, Options),
    known_options(Options),
    option(run(Name), Options, _),
    setup_call_cleanup(begin_run(Name, Run),
                       run(Program, Options, Run),
                       end_run(Run)).

run(Program, Options, Run) :-
    renewed_theory(Theory),
    past(Options, Program, Seed, Entries, Mode, Follow),
    while_used(Theory,
               with_seed(Seed,
                         run_on(Program, Options, Run, Theory, past(Seed, Entries, Mode, Follow), Last, Outcome))),
    turn_situation(Last, S),
    turn_program(Last, Rest),
    situation_history(S, History),
    option(history(History), Options, _),
    option(situation(S), Options, _),
    option(rest(Rest), Options, _),
    told(Outcome, Options, Rest, S).

% run_on(+Program, +Options, +Run, +Theory, +Past, -Last, -Outcome): to the Last turn.

run_on(Program, Options, Run, Theory, past(Seed, Entries, Mode, Follow), Last, Outcome) :-
    initial_situation(Theory, S0),
    option(journal(File), Options, none),
    option(on_action(OnAction), Options, none),
    option(on_fact(OnFact), Options, none),
    option(max_actions(Max), Options, inf),
    option(max_wait(MaxWait), Options, inf),
    told_by(File, Options, Entries, Told),
    setup_call_cleanup(
        opened(Mode, Options, Theory, Run, File-Told, Devices, Journal),
        ( journal_write(Journal, begun(Program, Seed)),
          make_setting([ run(Run), devices(Devices), journal(Journal), on_action(OnAction), on_fact(OnFact),
                         max(Max), max_wait(MaxWait), mode(Mode), follow(Follow), undeclared(told([])) ], X),
          first_turn(Program, S0, Entries, First),
          option(max_silent(Silent), Options, default),
          catch(with_patience(Silent,
                    turn(First, X, Last, Outcome)),
                Error,
                ended_by(Error, Journal)),
          journal_write(Journal, ended(Outcome)) ),
        closed(Devices, Journal)).

is_meta(on_action).
is_meta(follow).
is_meta(on_fact).

opened(replay, _, Theory, Run, _, Devices, Journal) =>
    journal_open(none, 0, Journal),
    open_devices([], Theory, Run, Devices).
opened(live, Options, Theory, Run, File-Told, Devices, Journal) =>
    journal_open(File, Told, Journal),
    catch(open_devices(Options, Theory, Run, Devices), Error,
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

% past(+Options, +Program, -Seed, -Entries, -Mode, -Follow): what a resumed run has behind it, and what is called for
% what a journal that is replayed gets meanwhile: follow(Goal, File, Bytes) or `none`.
past(Options, Program, Seed, Entries, Mode, Follow) :-
    (   option(resume(File), Options)
    ->  Mode = live,
        Follow = none,
        followed(File, Program, Seed, Entries, _)
    ;   option(replay(File), Options)
    ->  Mode = replay,
        followed(File, Program, Seed, Entries, Bytes),
        ( option(follow(Goal), Options) -> Follow = follow(Goal, File, Bytes) ; Follow = none )
    ;   Mode = live,
        Follow = none,
        Entries = [],
        option(seed(Seed0), Options, none),
        ( Seed0 == none -> Seed is random(1_000_000_000) ; Seed = Seed0 )
    ).

followed(File, Program, Seed, Entries, Bytes) :-
    (   exists_file(File),
        journal_entries(File, begun(Program0, Seed), Entries, Bytes)
    ->  true
    ;   throw(error(golog(no_journal(File)), _))
    ),
    (   Program0 =@= Program
    ->  true
    ;   throw(error(golog(other_program(File, Program0)), _))
    ).

% told_by(+File, +Options, +Entries, -Told): the facts that the journal has already, where it is the one that is
% resumed: what was begun, and the entries.
told_by(File, Options, Entries, Told) :-
    (   option(resume(Resumed), Options),
        File \== none,
        same_file(File, Resumed)
    ->  length([_|Entries], Told)
    ;   Told = 0
    ).
