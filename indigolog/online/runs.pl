:- module(indigolog_runs,
          [ begin_run/2,              % ?Name, -Run
            end_run/1,                % +Run
            in_run/1,                 % +Run
            current_run/1,            % -Name
            requested/2,              % +Run, -Request
            request_stop/1,           % +Reason
            request_stop/2,           % +Name, +Reason
            request_abort/0,
            request_abort/1,          % +Name
            report_exogenous/1,       % +Action
            report_exogenous/2,       % +Name, +Action
            known_event/1             % +Action
          ]).
/** <module> The runs that are going on in this process, and messages to them

A Run is the message queue in which its events arrive.  The run of a thread is the one that
it began last and that has not ended, or that it is a device of.
*/

:- use_module(library(lists), [member/2]).

:- dynamic
    running/3,                        % Run, Name, Around: the run around it in its thread, or `none`
    request/2.                        % Run, stop(Reason) or abort

%!  begin_run(?Name, -Run) is det.
%
%   Name, if it is not given, is Run itself.
%
%   @error golog(run_exists(Name))

begin_run(Name, Run) :-
    ( own_run(Around) -> true ; Around = none ),
    with_mutex(indigolog_runs, begin_run(Name, Around, Run)),
    in_run(Run).

begin_run(Name, Around, Run) :-
    (   nonvar(Name),
        running(_, Name, _)
    ->  throw(error(golog(run_exists(Name)), _))
    ;   message_queue_create(Run),
        ( var(Name) -> Name = Run ; true ),
        assertz(running(Run, Name, Around))
    ).

%!  end_run(+Run) is det.

end_run(Run) :-
    retract(running(Run, _, Around)),
    !,
    retractall(request(Run, _)),
    in_run(Around),
    message_queue_destroy(Run).

%!  in_run(+Run) is det.
%
%   From here on Run is the run of this thread.

in_run(Run) :-
    nb_setval(indigolog_run, Run).

own_run(Run) :-
    nb_current(indigolog_run, Run),
    Run \== none.

%!  current_run(-Name) is semidet.
%
%   The run of this thread: so that one device can serve many.

current_run(Name) :-
    own_run(Run),
    running(Run, Name, _).

%!  requested(+Run, -Request) is nondet.

requested(Run, Request) :-
    request(Run, Request).

%!  request_stop(+Reason) is det.
%!  request_stop(+Name, +Reason) is det.
%
%   Make a run end between two steps with stopped(Reason): the run of this thread, all runs
%   if it has none, or the one of that Name.  May be called from a signal handler, a device or
%   another thread.
%
%   @error golog(no_run(Name))

request_stop(Reason) :-
    request_of_all(stop(Reason)).

request_stop(Name, Reason) :-
    request_of(Name, stop(Reason)).

%!  request_abort is det.
%!  request_abort(+Name) is det.
%
%   As request_stop, with outcome `aborted`, as abort/0 in a program has.

request_abort :-
    request_of_all(abort).

request_abort(Name) :-
    request_of(Name, abort).

request_of(Name, Request) :-
    (   running(Run, Name, _)
    ->  assertz(request(Run, Request))
    ;   throw(error(golog(no_run(Name)), _))
    ).

request_of_all(Request) :-
    (   own_run(Run)
    ->  assertz(request(Run, Request))
    ;   forall(running(Run, _, _), assertz(request(Run, Request)))
    ).

%!  report_exogenous(+Action) is det.
%!  report_exogenous(+Name, +Action) is det.
%
%   Tell a run of an exogenous action: the run of this thread, the only one if it has none,
%   or the one of that Name.  May be called from any thread.
%
%   @error golog(nothing_runs(Action)), golog(several_runs(Action)), golog(open_event(Action)),
%          golog(no_event(Action))

report_exogenous(Action) :-
    (   own_run(Run)
    ->  report(Run, Action)
    ;   findall(Run, running(Run, _, _), Runs),
        (   Runs = [_, _|_]
        ->  throw(error(golog(several_runs(Action)), _))
        ;   member(Run, Runs)
        ->  report(Run, Action)
        ;   throw(error(golog(nothing_runs(Action)), _))
        )
    ).

report_exogenous(Name, Action) :-
    (   running(Run, Name, _)
    ->  report(Run, Action)
    ;   throw(error(golog(nothing_runs(Action)), _))
    ).

report(Run, Action) :-
    known_event(Action),
    catch(thread_send_message(Run, event(Action)),
          error(existence_error(_, _), _),     % it has just ended
          throw(error(golog(nothing_runs(Action)), _))).

%!  known_event(+Action) is det.
%
%   @error golog(open_event(Action)) if Action is not ground: what happened is not known then;
%          golog(no_event(Action)) if it is a list or a number, which no action is

known_event(Action) :-
    (   \+ ground(Action)
    ->  throw(error(golog(open_event(Action)), _))
    ;   callable(Action),
        \+ is_list(Action)
    ->  true
    ;   throw(error(golog(no_event(Action)), _))
    ).
