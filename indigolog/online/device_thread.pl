:- module(indigolog_device_thread,
          [ start_thread/4,           % +Module, +Deadline, +Run, -Thread
            stop_thread/2,            % +Thread, +Module
            carried_out_by_thread/4,  % +Thread, +Deadline, +Action, -Sensing
            executed/3,               % +Module, +Action, -Result
            poll/2,                   % +Module, +Events
            poll_interval/1,          % -Seconds
            hook/2                    % +Module, +Hook
          ]).
/** <module> A device in a thread of its own

thread(Id, Requests, Replies) takes execute(Id, Action) and `stop` from its queue
Requests and puts reply(Id, Result) into Replies; in between it asks the device
for events and puts event(Action) into the queue of the run.
*/

:- use_module(library(lists), [member/2]).
:- use_module(runs, [in_run/1]).

% Seconds a device has to end its thread; chosen by hand.
closing_time(1.0).

%!  poll_interval(-Seconds) is det.
%
%   Between two looks for events; chosen by hand.

poll_interval(0.01).

%!  start_thread(+Module, +Deadline, +Run, -Thread) is det.

start_thread(Module, Deadline, Run, Thread) :-
    message_queue_create(Requests),
    message_queue_create(Replies),
    thread_create(work(Module, Requests, Replies, Run), Id),
    Thread = thread(Id, Requests, Replies),
    answer(Thread, started, Deadline, started, done(_)).

%!  stop_thread(+Thread, +Module) is det.
%
%   A thread that does not end in time is left behind with a warning.

stop_thread(thread(Id, Requests, Replies), Module) :-
    closing_time(Seconds),
    thread_send_message(Requests, stop),
    (   thread_get_message(Replies, stopped, [timeout(Seconds)])
    ->  thread_join(Id, _),
        message_queue_destroy(Requests),
        message_queue_destroy(Replies)
    ;   catch(thread_signal(Id, throw(device_closed)), error(_, _), true),
        (   thread_get_message(Replies, stopped, [timeout(Seconds)])
        ->  thread_join(Id, _)
        ;   thread_detach(Id),
            print_message(warning, golog(device_left(Module)))
        )
    ).

%!  carried_out_by_thread(+Thread, +Deadline, +Action, -Sensing) is det.
%
%   @error golog(deadline(Action, Deadline)), golog(device_failed(Module, Action)),
%          and whatever the device throws

carried_out_by_thread(Thread, Deadline, A, Sensing) :-
    Thread = thread(_, Requests, _),
    flag(indigolog_request, Id, Id+1),
    thread_send_message(Requests, execute(Id, A)),
    answer(Thread, Id, Deadline, A, done(Sensing)).

work(Module, Requests, Replies, Events) :-
    in_run(Events),
    catch(( hook(Module, started),
            thread_send_message(Replies, reply(started, done(none))),
            keep_serving(Module, Requests, Replies, Events) ),
          Error,
          trouble(Error, Module, Replies, Events)),
    catch(hook(Module, stopped), _, true),
    thread_send_message(Replies, stopped).

trouble(device_closed, _, _, _) :-
    !.
trouble(Error, _, Replies, Events) :-
    thread_send_message(Replies, reply(started, error(Error))),
    thread_send_message(Events, trouble(Error)).

% What is done too late is broken off, wherever it is by then.
keep_serving(Module, Requests, Replies, Events) :-
    catch(( serve(Module, Requests, Replies, Events),
            Ended = true ),
          too_late,
          Ended = false),
    (   Ended == true
    ->  true
    ;   keep_serving(Module, Requests, Replies, Events)
    ).

serve(Module, Requests, Replies, Events) :-
    (   current_predicate(Module:exogenous/1)
    ->  poll_interval(Seconds),
        (   thread_get_message(Requests, Request, [timeout(Seconds)])
        ->  true
        ;   Request = none
        )
    ;   thread_get_message(Requests, Request)
    ),
    (   Request == stop
    ->  true
    ;   done(Request, Module, Replies),
        poll(Module, Events),
        serve(Module, Requests, Replies, Events)
    ).

done(none, _, _).
done(execute(Id, A), Module, Replies) :-
    catch(executed(Module, A, Result), Error, ours(Error, Result)),
    thread_send_message(Replies, reply(Id, Result)).

ours(Error, Result) :-
    (   ( Error == device_closed ; Error == too_late )
    ->  throw(Error)
    ;   Result = error(Error)
    ).

% answer(+Where, +Id, +Deadline, +Action, -Result): the reply to request Id.

answer(thread(Id, _, Replies), Request, Deadline, A, Result) :-
    get_time(Now),
    End is Now+Deadline,
    (   reply(Replies, Request, End, Result0)
    ->  (   Result0 = error(Error)
        ->  throw(Error)
        ;   Result = Result0
        )
    ;   catch(thread_signal(Id, throw(too_late)), error(_, _), true),    % it may have ended
        throw(error(golog(deadline(A, Deadline)), _))
    ).

% In short waits, so that signals are seen.
reply(Replies, Request, End, Result) :-
    get_time(Now),
    Wait is min(0.1, End-Now),
    Wait > 0,
    (   thread_get_message(Replies, reply(Request0, Result0), [timeout(Wait)]),
        Request0 == Request               % and not one that came too late
    ->  Result = Result0
    ;   reply(Replies, Request, End, Result)
    ).


                /* What a device is asked, in whatever thread */

%!  hook(+Module, +Hook) is det.
%
%   Call Hook of a device that defines it.

hook(Module, Hook) :-
    (   current_predicate(Module:Hook/0)
    ->  ignore(Module:Hook)
    ;   true
    ).

%!  executed(+Module, +Action, -Result) is det.
%
%   Result is done(Sensing), or error(Error) where execute/2 fails.

executed(Module, A, Result) :-
    (   Module:execute(A, Sensing)
    ->  Result = done(Sensing)
    ;   Result = error(error(golog(device_failed(Module, A)), _))
    ).

%!  poll(+Module, +Events) is det.
%
%   Put into the queue Events what has happened at a device.
%
%   @error golog(no_events(Module, Reported)) if it reports anything but a list of ground
%          actions; Reported is `nothing` where exogenous/1 fails

poll(Module, Events) :-
    (   current_predicate(Module:exogenous/1)
    ->  ( Module:exogenous(Actions) -> true ; Actions = nothing ),
        (   is_list(Actions),
            ground(Actions)
        ->  forall(member(A, Actions), thread_send_message(Events, event(A)))
        ;   throw(error(golog(no_events(Module, Actions)), _))
        )
    ;   true
    ).
