:- module(indigolog_turn,
          [ turn/4,                   % +Turn, +Setting, -Last, -Outcome
            first_turn/4,             % +Program, +Situation, +Entries, -Turn
            turn_program/2,           % +Turn, -Program
            turn_situation/2,         % +Turn, -Situation
            make_setting/2            % +Fields, -Setting
          ]).
/** <module> The turns of an online run

Each turn takes in the exogenous actions that have arrived, in their order, and
then makes one step of the program: a step is first looked for, and only a
program that has none may end.  An action of the step is carried to the device
that can execute it before the next turn.

A turn is a record of the program and the situation, the number of steps, the count of actions
so far and of steps since the last, and the entries of a journal that is followed.  The setting stays the same in a run; its mode
is `live`, or `replay` where only a journal is followed; `undeclared` is of warn_once/3.
*/

:- use_module(library(apply), [foldl/4, maplist/2]).
:- use_module(library(record)).
:- use_module('../language/chance', [world_moment/1]).
:- use_module('../language/context', [top_context/1]).
:- use_module('../language/notice', [progress_message/1, warn_once/3]).
:- use_module('../language/patience', [still_patient/3]).
:- use_module('../language/progression', [progress/3]).
:- use_module('../language/semantics', [final/3, step/4]).
:- use_module('../language/sensing', [check_sensing_result/3, sensing_action/2]).
:- use_module('../language/situation').
:- use_module('../language/theory').
:- use_module('../language/unfolding', [unfolded/2]).
:- use_module(devices).
:- use_module(journal).
:- use_module(runs, [requested/2]).
:- use_module(terminal, [ask_in/2]).

:- record turn(program, situation, number=0, count=0, silent=0, entries=[]).
:- record setting(run, devices, journal, on_action, on_fact, max, max_wait, mode, follow, undeclared).

record_goal(Goal) :-
    functor(Goal, Name, Arity),
    (   Arity =:= 2, ( sub_atom(Name, 0, _, _, turn_) ; sub_atom(Name, 0, _, _, setting_) )
    ;   Arity =:= 3, sub_atom(Name, _, _, 0, '_of_turn')
    ),
    !.

goal_expansion(Goal, Unifications) :-
    record_goal(Goal),
    unfolded(indigolog_turn:Goal, Unifications).

%!  first_turn(+Program, +Situation, +Entries, -Turn) is det.

first_turn(E, S, Entries, T) :-
    make_turn([program(E), situation(S), entries(Entries)], T).

%!  turn(+Turn, +Setting, -Last, -Outcome) is det.
%
%   From Turn on, to the Last.

turn(T0, X, T, Outcome) :-
    turn_entries(T0, Entries0),
    setting_run(X, Run),
    (   requested(Run, Request)
    ->  by_request(Request),
        T = T0,
        Outcome = aborted
    ;   Entries0 == [],
        setting_mode(X, replay)
    ->  (   more(X, T0, Entries)
        ->  set_entries_of_turn(Entries, T0, T1),
            turn(T1, X, T, Outcome)
        ;   T = T0,
            Outcome = replayed
        )
    ;   take_in(X, T0, T1),
        turn_entries(T1, Left),
        resumed_if_last(Entries0, X, T1),
        (   Left == [],
            setting_mode(X, replay)
        ->  turn(T1, X, T, Outcome)     % the journal's last event was exogenous
        ;   next(T1, E, S)
        ->  stepped(T1, E, S, X, T, Outcome)
        ;   Left = [Entry|_]
        ->  turn_program(T1, E),
            throw(error(golog(journal_differs(Entry, E)), _))
        ;   T = T1,
            ( may_end(T) -> Outcome = final ; Outcome = failed )
        )
    ).

may_end(T) :-
    turn_program(T, E),
    turn_situation(T, S),
    top_context(C),
    final(E, S, C).

% more(+Setting, +Turn, -Entries): what a journal that is followed has got since it was read last.
more(X, T, Entries) :-
    setting_follow(X, Follow),
    Follow = follow(Goal, File, Bytes0),
    turn_program(T, E),
    turn_situation(T, S),
    \+ \+ call(Goal, E, S),
    journal_added(File, Bytes0, Bytes, Entries),
    nb_setarg(3, Follow, Bytes).

% stepped(+Turn, +E, +S, +Setting, -Last, -Outcome): the step of Turn leads to E and S.
stepped(T0, E, S, X, T, Outcome) :-
    turn_situation(T0, S0),
    turn_number(T0, N0),
    N is N0+1,
    set_program_of_turn(E, T0, T1),
    set_number_of_turn(N, T1, T2),
    (   same_situation(S0, S)
    ->  turn_silent(T0, Silent0),
        Silent is Silent0+1,
        still_patient(Silent, E, S),
        set_situation_of_turn(S, T2, T3),
        set_silent_of_turn(Silent, T3, T4),
        turn(T4, X, T, Outcome)
    ;   set_silent_of_turn(0, T2, T3),
        last_action(S, A),
        (   A == wait
        ->  wait_for_events(T3, N0, X),
            turn(T3, X, T, Outcome)
        ;   A == abort
        ->  set_situation_of_turn(S, T3, T),
            Outcome = aborted
        ;   turn_count(T0, Count),
            setting_max(X, Max),
            Count >= Max
        ->  T = T0,
            Outcome = limit
        ;   do_action(A, N0, S, X, T3, T4),
            turn(T4, X, T, Outcome)
        )
    ).

by_request(stop(Reason)) :-
    throw(stopped(Reason)).
by_request(abort).

% A step, and while a journal is followed the step that it tells of.
next(T, E1, S1) :-
    turn_program(T, E),
    turn_situation(T, S),
    step(E, S, E1, S1),
    as_told(T, S1),
    !.

as_told(T, S1) :-
    turn_entries(T, Entries),
    (   Entries = [Entry|_]
    ->  turn_situation(T, S),
        turn_number(T, N),
        arg(1, Entry, Told),
        (   same_situation(S, S1)
        ->  Told > N
        ;   last_action(S1, A),
            (   A == wait
            ->  true
            ;   Told = N,
                arg(2, Entry, A)
            )
        )
    ;   true
    ).


                /* Exogenous actions */

% What the journal tells of them, or what the devices do.  Those of one turn arrive together: where the journal's last is
% one, the devices were asked in that turn.
take_in(X, T0, T) :-
    turn_entries(T0, Entries),
    turn_number(T0, N),
    (   Entries = [exogenous(N, A)|Entries1]
    ->  set_entries_of_turn(Entries1, T0, T1),
        taken_in(X, A, T1, T2),
        ( Entries1 == [] -> T = T2 ; take_in(X, T2, T) )
    ;   Entries == [],
        setting_mode(X, live)
    ->  asked_moment(N, Moment),
        world_moment(Moment),
        setting_devices(X, Devices),
        arrived_events(Devices, As),
        foldl(taken_in(X), As, T0, T)
    ;   T = T0
    ).

% Each turn is two moments of the world, since a run that is resumed between them does not come to the first.
asked_moment(N, Moment) :-
    Moment is 2*N.
acting_moment(N, Moment) :-
    Moment is 2*N+1.

taken_in(X, A, T0, T) :-
    turn_situation(T0, S0),
    turn_number(T0, N),
    situation_module(S0, Module),
    (   \+ \+ Module:exog_action(A)
    ->  progress(A, S0, S1),
        set_situation_of_turn(S1, T0, T),
        happened(exogenous(N, A), A, X, T)
    ;   setting_undeclared(X, Told),
        ( callable(A) -> generalised(A, Like) ; Like = A ),
        warn_once(Told, Like, golog(undeclared_event(A))),
        T = T0
    ).

% Write Fact to the journal, and tell of Action.
happened(Fact, Action, X, T) :-
    setting_journal(X, Journal),
    journal_write(Journal, Fact),
    progress_message(Fact),
    turn_situation(T, S),
    setting_on_action(X, OnAction),
    setting_on_fact(X, OnFact),
    ( OnAction == none -> true ; ignore(call(OnAction, Action, S)) ),
    ( OnFact == none -> true ; ignore(call(OnFact, Fact, S)) ).

wait_for_events(T, N, X) :-
    (   turn_entries(T, [])
    ->  progress_message(waiting),
        acting_moment(N, Moment),
        world_moment(Moment),
        setting_devices(X, Devices),
        setting_max_wait(X, MaxWait),
        setting_run(X, Run),
        wait_for_event(Devices, MaxWait, requested(Run, _))
    ;   true
    ).


                /* Primitive actions */

% do_action(+A, +Number, +S, +Setting, +Turn, -Turn1): A, of the turn of that Number, leads
% from the situation of Turn to S, and with what was sensed to that of Turn1.

do_action(A, N, S, X, T0, T) :-
    turn_situation(T0, S0),
    turn_entries(T0, Entries0),
    (   Entries0 = [Entry|Entries]
    ->  replayed(Entry, Result)
    ;   Entries = [],
        acting_moment(N, Moment),
        world_moment(Moment),
        carry_out(A, X, S, Result)
    ),
    (   Result = failed(Reason)
    ->  Done = failed(A, Reason),
        Fact = failed(N, A, Reason),
        progress(Done, S0, S1)
    ;   Result = done(Sensing),
        Done = A,
        Fact = executed(N, A, Sensing),
        sensed(A, Sensing, S, S1)
    ),
    turn_count(T0, Count0),
    Count is Count0+1,
    set_situation_of_turn(S1, T0, T1),
    set_count_of_turn(Count, T1, T2),
    set_entries_of_turn(Entries, T2, T),
    happened(Fact, Done, X, T),
    resumed_if_last(Entries0, X, T).

sensed(A, Sensing, S, S1) :-
    situation_theory(S, Theory),
    (   Sensing \== none,
        sensing_action(Theory, A)
    ->  check_sensing_result(Theory, A, Sensing),
        progress(e(A, Sensing), S, S1)
    ;   S1 = S
    ).

replayed(executed(_, _, Sensing), done(Sensing)).
replayed(failed(_, _, Reason), failed(Reason)).

% The devices learn that they take over when the last of Entries has been followed.
resumed_if_last(Entries, X, T) :-
    (   Entries = [_|_],
        turn_entries(T, []),
        setting_mode(X, live)
    ->  setting_devices(X, Devices),
        turn_situation(T, S),
        tell_resumed(Devices, S)
    ;   true
    ).

carry_out(A, X, S, Result) :-
    setting_devices(X, Devices),
    situation_theory(S, Theory),
    catch(( ask_in(S, execute_action(Devices, Theory, A, Sensing)),
            Result = done(Sensing) ),
          Error,
          failure(Error, A, S, Result)).

% A failed action is an exogenous action if the theory declares it.
failure(Error, A, S, Result) :-
    situation_module(S, Module),
    (   Error = error(Reason0, _),
        copy_term(Reason0, Reason),
        term_variables(Reason, Open),
        maplist(=('_'), Open),            % histories are ground
        \+ \+ Module:exog_action(failed(A, Reason))
    ->  Result = failed(Reason)
    ;   throw(Error)
    ).
