:- module(indigolog_devices,
          [ open_devices/4,           % +Options, +Theory, +Run, -Devices
            close_devices/1,          % +Devices
            execute_action/4,         % +Devices, +Theory, +Action, -Sensing
            arrived_events/2,         % +Devices, -Actions
            wait_for_event/3,         % +Devices, +MaxSeconds, :Interrupted
            waits_for_event/0,
            tell_resumed/2            % +Devices, +Situation
          ]).
/** <module> Devices: what executes actions and reports events

A device is a module that defines

    can_execute(+Action)            % semidet: Action is for this device
    execute(+Action, -Sensing)      % det; Sensing is ground, or stays unbound

and, where it needs them,

    exogenous(-Actions)             % det: what happened since the last call, ground
    resumed(+Situation)             % takes over after a journal was followed
    started, stopped                % around a run

Given as device(Module) it is called by the thread that runs the program, as
device(Module, Options) by a thread of its own, so that neither a slow nor a dead
device holds up the program for longer than the deadline.  Events of all
devices, and those that any thread reports with report_exogenous/1, arrive in
one queue, that of the run; none is lost and equal ones stay apart.

The theory's exog_occurs/1 is asked as well, and its execute/2 for what no device
can do: with devices for actions that sense, without one for all.  What neither tells
is asked on the terminal.

Devices here are devices(List, Run, Theory); a member of List is
device(Module, Deadline, Where), Where being `here` or thread(Id, Requests, Replies).
*/

:- use_module(library(lists), [member/2]).
:- use_module(library(option), [option/3]).
:- use_module(library(time), [call_with_time_limit/2]).
:- use_module(device_thread).
:- use_module(run_options, [known_device_options/2]).
:- use_module(runs, [known_event/1]).
:- use_module('../language/chance', [drawn_apart/1]).
:- use_module('../language/sensing', [sensing_action/2]).
:- use_module(terminal).
:- use_module('../language/theory', [assignment/2, history_mark/1, theory_module/2]).

:- meta_predicate wait_for_event(+, +, 0), in_world(+, 0).

% How long a device in a thread has for an action where no deadline is given; chosen by hand.
default_deadline(60).

%!  open_devices(+Options, +Theory, +Run, -Devices) is det.
%
%   Start the devices of Options: device(Module)*, device(Module, DeviceOptions)*,
%   deadline(Seconds).  DeviceOptions are thread(Boolean), `true` by default, and
%   deadline(Seconds).

open_devices(Options, Theory, Run, devices(List, Run, Theory)) :-
    forget_input_ended,
    option(deadline(Deadline), Options, none),
    findall(Module-Own,
            ( member(Option, Options),
              (   Option = device(Module), Own = [thread(false)]
              ;   Option = device(Module, Own)
              ) ),
            Specs),
    open_each(Specs, Deadline, Run, [], List).

open_each([], _, _, _, []).
open_each([Module-Options|Specs], Deadline0, Run, Opened, [Device|List]) :-
    known_device(Module),
    known_device_options(Module, Options),
    option(deadline(Deadline), Options, Deadline0),
    catch(open_device(Module, Options, Deadline, Run, Device), Error,
          ( close_each(Opened), throw(Error) )),
    open_each(Specs, Deadline0, Run, [Device|Opened], List).

known_device(Module) :-
    (   member(PI, [can_execute/1, execute/2]),
        \+ current_predicate(Module:PI)
    ->  throw(error(golog(no_device(Module, PI)), _))
    ;   true
    ).

open_device(Module, Options, Deadline0, Run, device(Module, Deadline, Where)) :-
    (   option(thread(true), Options, true)
    ->  ( Deadline0 == none -> default_deadline(Deadline) ; Deadline = Deadline0 ),
        start_thread(Module, Deadline, Run, Where)
    ;   Deadline = Deadline0,
        Where = here,
        hook(Module, started)
    ).

%!  close_devices(+Devices) is det.
%
%   A thread that does not end in time is left behind with a warning.

close_devices(devices(List, _, _)) :-
    close_each(List).

close_each(List) :-
    forall(member(device(Module, _, Where), List), close_device(Where, Module)).

close_device(here, Module) :-
    hook(Module, stopped).
close_device(Where, Module) :-
    Where = thread(_, _, _),
    stop_thread(Where, Module).


                /* Actions */

% The interpreter's own actions are not sent to a device.
internal_action(A, Theory) :-
    ( history_mark(A) -> true ; assignment(A, Theory) ).

%!  execute_action(+Devices, +Theory, +Action, -Sensing) is det.
%
%   Sensing is `none` for an action that senses nothing.
%
%   @error golog(deadline(Action, Seconds)), golog(device_failed(Device, Action)),
%          golog(nothing_sensed(Action)), golog(open_result(Action)), and whatever a
%          device throws

execute_action(Devices, Theory, A, Sensing) :-
    carried_out(Devices, Theory, A, Sensing0),
    told_result(Sensing0, Theory, A, Sensing).

told_result(Sensing0, Theory, A, Sensing) :-
    (   ground(Sensing0)
    ->  Sensing = Sensing0
    ;   sensing_action(Theory, A)
    ->  ( var(Sensing0) -> Error = nothing_sensed(A) ; Error = open_result(A) ),
        throw(error(golog(Error), _))
    ;   Sensing = none
    ).

carried_out(devices(List, _, _), Theory, A, Sensing) :-
    (   internal_action(A, Theory)
    ->  true
    ;   member(device(Module, Deadline, Where), List),
        Module:can_execute(A)
    ->  carried_out_at(Where, Module, Deadline, A, Sensing)
    ;   List \== [],
        \+ sensing_action(Theory, A)
    ->  true
    ;   theory_module(Theory, Module),
        clause(Module:execute(_, _), _)
    ->  in_world(execute(A, _),
                 (   drawn_apart(Module:execute(A, Sensing0))
                 ->  told_result(Sensing0, Theory, A, Sensing)
                 ;   throw(error(golog(device_failed(theory, A)), _))
                 ))
    ;   ask_execute(A, Sensing)
    ).

% What goes wrong in a theory's own world is told with what it was asked.
in_world(Asked, Goal) :-
    catch(Goal, error(Formal, Context),
          ( is_dict(Context)              % of a stack overflow
          ->  throw(error(Formal, Context))
          ;   throw(error(Formal, golog(world(Asked), Context))) )).

carried_out_at(here, Module, Deadline, A, Sensing) :-
    (   Deadline == none
    ->  drawn_apart(executed(Module, A, Result))
    ;   catch(call_with_time_limit(Deadline, drawn_apart(executed(Module, A, Result))),
              time_limit_exceeded,
              throw(error(golog(deadline(A, Deadline)), _)))
    ),
    (   Result = done(Sensing)
    ->  true
    ;   Result = error(Error),
        throw(Error)
    ).
carried_out_at(Where, _, Deadline, A, Sensing) :-
    Where = thread(_, _, _),
    carried_out_by_thread(Where, Deadline, A, Sensing).


                /* Events */

%!  arrived_events(+Devices, -Actions) is det.
%
%   What has arrived since the last call, in order of arrival.

arrived_events(Devices, Actions) :-
    look(Devices),
    Devices = devices(_, Events, _),
    taken(Events, Actions).

taken(Events, Actions) :-
    (   thread_peek_message(Events, _)    % a timeout of 0 would sleep
    ->  thread_get_message(Events, Message),
        (   Message = event(A)
        ->  Actions = [A|More],
            taken(Events, More)
        ;   Message = trouble(Error),
            throw(Error)
        )
    ;   Actions = []
    ).

% What is not told by a thread must be asked for.
look(devices(List, Events, Theory)) :-
    forall(( member(device(Module, _, here), List), current_predicate(Module:exogenous/1) ),
           drawn_apart(poll(Module, Events))),
    theory_module(Theory, Own),
    (   clause(Own:exog_occurs(_), _),
        in_world(exog_occurs(_), drawn_apart(( Own:exog_occurs(A), nonvar(A), known_event(A) )))
    ->  thread_send_message(Events, event(A))
    ;   true
    ).

%!  wait_for_event(+Devices, +MaxSeconds, :Interrupted) is det.
%
%   Return when arrived_events/2 has something to tell, or Interrupted is true.
%   With no device and no exog_occurs/1 the terminal is asked.
%
%   @error golog(nothing_happened(MaxSeconds)), golog(no_answer(wait)) at the end
%          of input

wait_for_event(Devices, Max, Interrupted) :-
    (   Max == inf
    ->  End = inf
    ;   get_time(Now),
        End is Now+Max
    ),
    b_setval(indigolog_waits, true),
    waiting(Devices, End, Max, Interrupted),
    b_setval(indigolog_waits, false).

%!  waits_for_event is semidet.
%
%   The run of this thread does: for a signal that comes meanwhile.

waits_for_event :-
    nb_current(indigolog_waits, true).

waiting(Devices, End, Max, Interrupted) :-
    Devices = devices(List, Events, Theory),
    look(Devices),
    (   thread_peek_message(Events, _)
    ->  true
    ;   call(Interrupted)
    ->  true
    ;   List == [],
        theory_module(Theory, Module),
        \+ clause(Module:exog_occurs(_), _),
        ask_exog_occurs(A)
    ->  thread_send_message(Events, event(A))
    ;   input_ended
    ->  throw(error(golog(no_answer(wait)), _))
    ;   End \== inf,
        get_time(Now),
        Now >= End
    ->  throw(error(golog(nothing_happened(Max)), _))
    ;   poll_interval(Seconds),
        sleep(Seconds),
        waiting(Devices, End, Max, Interrupted)
    ).

%!  tell_resumed(+Devices, +Situation) is det.
%
%   Tell the devices that define resumed/1 that they take over.

tell_resumed(devices(List, _, _), S) :-
    forall(( member(device(Module, _, _), List), current_predicate(Module:resumed/1) ),
           Module:resumed(S)).
