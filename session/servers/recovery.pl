:- module(session_recovery,
          [ open_recovery/2,            % +Options, +StartArgs
            look_after/3,               % +Name, +Op, +Seconds
            brought_back/3,             % +Name, +Op, +Error
            missed/3,                   % +Name, +Endpoint, +Seconds
            server_started/0,
            take_over/1,                % +Situation
            begin_action/0,
            end_action/1,               % +Action
            came_with/1,                % +Result
            new_events/1                % -Events
          ]).
/** <module> A server that dies, or does not answer, is brought back to where the session is

The vision server gets its images from the run folder, and what it was told from the last situation, as when a session
is resumed; an image server that draws is what it was by its seed and by what it has done so far.  Then the request
is made again, and the session goes on as if nothing had been.  Events of the image server are handed over here, since
one that was lost with a server, or is told again, is no second one.
*/

:- use_module(connections).
:- use_module('../display/display', [show/2, show_address/0]).
:- use_module(restoration, [known_again/2]).
:- use_module('../folder/resumption', [missed_events/3]).
:- use_module('../display/live_table', [pulse/2, table_is_live/0]).
:- use_module(servers).
:- use_module('../../indigolog/indigolog', [situation_history/2]).
:- use_module(library(lists), [member/2, memberchk/2, nth1/3, reverse/2]).

most_times(5).                          % in a session; chosen by hand
patience_s(1).                          % after which it is said what is waited for; chosen by hand

:- dynamic
    started_with/2,                     % Options, StartArgs
    times/1,                            % how often a server was brought back
    so_far/1,                           % started: the vision server has answered `start` or `restore`; said: what is
                                        % waited for; renewed: what the image server did in the present action may
                                        % not be all it told
    event/2,                            % Event, and its stage: it came since the present action began, the reply to
                                        % that told of it, or it is pending, to be met
    told_number/2.                      % Sequence, Name: of an event that a reply told of before it arrived

%!  open_recovery(+Options, +StartArgs) is det.
%
%   StartArgs are those of the vision server's `start`.

open_recovery(Options, StartArgs) :-
    forall(member(Fact, [started_with(_, _), times(_), so_far(_), event(_, _), told_number(_, _)]), retractall(Fact)),
    assertz(started_with(Options, StartArgs)),
    assertz(times(0)).

%!  server_started is det.
%
%   The vision server knows of the session.

server_started :-
    note(started).

note(What) :-
    ( so_far(What) -> true ; assertz(so_far(What)) ).

                /*******************************
                *       WHILE ONE WAITS        *
                *******************************/

%!  look_after(+Name, +Op, +Seconds) is det.
%
%   Look after the servers while one waits for the answer of one of them.  An image server that dies while the vision
%   server works is started again at once: who waits for it asks again.
%
%   @error server_died(Name, Status, LastLine, LogFile)

look_after(Name, Op, Seconds) :-
    check_server(Name),
    (   Name == vision_server
    ->  catch(check_server(image_server), Error, image_server_again(Error))
    ;   true
    ),
    started_with(Options, _),
    show_address,
    pulse(Op, Seconds),
    patience_s(Patience),
    (   Seconds < Patience
    ->  retractall(so_far(said))
    ;   table_is_live                   % it says so itself
    ->  true
    ;   so_far(said)                    % once: this is called ten times a second
    ->  true
    ;   note(said),
        show(Options, waiting(Name, Op))
    ).

%!  missed(+Name, +Endpoint, +Seconds) is det.
%
%   Nobody listens any more where a server of the user's was; it may come back within these seconds.

missed(Name, Endpoint, Seconds) :-
    started_with(Options, _),
    show(Options, missed(Name, Endpoint, Seconds)).

image_server_again(Error) :-
    ( died(Error, image_server) -> true ; throw(Error) ),
    counted(Error),
    start_again(image_server),
    hold_back,
    listen_again,
    note(renewed).

                /*******************************
                *       NO ANSWER CAME         *
                *******************************/

%!  brought_back(+Name, +Op, +Error) is semidet.
%
%   Where a request to a server came to Error because that server, or the one behind it, died or did not answer:
%   bring back what is lost, so that the request can be made again.
%
%   @error Error, where that has happened too often

brought_back(Name, Op, Error) :-
    lost(Error, Name, Lost),
    counted(Error),
    bring_back(Lost, Name, Op),
    note(renewed).

lost(Error, Name, died(Dead)) :-
    died(Error, Dead),
    memberchk(Name, [Dead, vision_server]),
    !.
lost(error(server_error(timeout, _, _), _), vision_server, slow) :-
    so_far(started).
lost(error(server_error(no_session, _, _), _), vision_server, forgotten) :-
    so_far(started).

%   One that ends with a complaint before it has ever served would do so again.
died(error(server_died(Name, Status, _, _), _), Name) :-
    Status \== exit(2),
    (   Status = killed(_)
    ;   Status == gone
    ;   has_answered(Name)
    ),
    !.

counted(Error) :-
    retract(times(Times0)),
    Times is Times0 + 1,
    assertz(times(Times)),
    most_times(Most),
    (   Times > Most
    ->  throw(Error)
    ;   started_with(Options, _),
        show(Options, brought_back(Error, Times, Most))
    ).

bring_back(died(image_server), image_server, _) =>
    start_again(image_server),
    hold_back,
    drop_changes,                       % of a move that is made again
    listen_again.
bring_back(died(Dead), vision_server, _) =>
    (   Dead == image_server            % died again while it was started: let go of what waits for it
    ->  start_again(image_server),
        kill_server(vision_server)
    ;   true
    ),
    start_again(vision_server),
    restore_if_started,
    image_server_as_before.
bring_back(forgotten, _, _) =>
    restore_if_started,
    image_server_as_before.
bring_back(slow, _, _) =>
    ask(image_server, describe, _{}, _),        % waits until what was asked before is done
    image_server_as_before.

restore_if_started :-
    (   so_far(started)
    ->  nb_getval(session_situation, Situation),
        restore(Situation)
    ;   true
    ).

%   Without what the action that is made again has changed already.
image_server_as_before :-
    (   own_server(image_server),
        asked_as_in_the_past(_)
    ->  drop_changes,
        listen_again
    ;   true
    ).

%   Events are those that came with the last thing that it did; fails for a device that does not draw.
asked_as_in_the_past(Events) :-
    image_server_past(Args),
    catch(ask(image_server, restart, Args, Result), error(server_error(unsupported, _, _), _), fail),
    Events = Result.events.

                /*******************************
                *       ACTIONS, EVENTS        *
                *******************************/

%!  begin_action is det.
%!  end_action(+Action) is det.
%
%   Between them the servers do an action of the session.

begin_action :-
    hold_back,
    all_pending.

end_action(Action) :-
    add_to_past(Action),
    ( retract(so_far(renewed)) -> image_server_as_before ; true ).

%!  came_with(+Result) is det.
%
%   The events in a reply of the image server, which came with what was asked: they are published too, and may arrive
%   later than the reply.

came_with(Result) :-
    (   is_list(Result.get(events))
    ->  forall(member(Event, Result.events), assertz(event(Event, told)))
    ;   true
    ).

%   Those that came unasked.
hold_back :-
    arrived(Events),
    forall(( member(Event, Events), \+ told_already(Event) ), assertz(event(Event, since))).

told_already(Event) :-
    told_number(Event.sequence, Event.event).

all_pending :-
    forall(retract(event(Event, told)),
           ( assertz(event(Event, pending)),
             assertz(told_number(Event.sequence, Event.event)) )),
    forall(( retract(event(Event, since)), \+ told_already(Event) ), assertz(event(Event, pending))).

drop_changes :-
    hold_back,
    retractall(told_number(_, _)),      % another server may count anew
    forall(( event(Event, since), change(Event) ), retract(event(Event, since))).

change(Event) :-
    memberchk(Event.event, ["sun_changed", "target_moved"]).

%!  new_events(-Events) is det.
%
%   What has arrived since the last call, in order.

new_events(Events) :-
    hold_back,
    all_pending,
    findall(Event, retract(event(Event, pending)), Events).

                /*******************************
                *      A RESUMED SESSION       *
                *******************************/

%!  take_over(+Situation) is det.
%
%   Take over a session that was interrupted in Situation: the vision server gets its images back, and with them what
%   its best estimate, seed pose and parameters came from; the image server is as it was, and what it said last
%   is heard now where it is not in the journal.

take_over(Situation) :-
    restore(Situation),
    situation_history(Situation, Newest),
    (   own_server(image_server)
    ->  (   asked_as_in_the_past(Told)
        ->  missed_events(Newest, Told, Events),
            forall(member(Event, Events), assertz(event(Event, pending)))
        ;   true
        )
    ;   findall(RangeM, member(advance(RangeM), Newest), Ranges),
        reverse(Ranges, Oldest),
        move_again(Oldest)
    ).

%   An image server of the user's that has not moved its target as often as it was asked to does so.
move_again([]) :-
    !.
move_again(Ranges) :-
    ask(image_server, describe, _{}, _),        % as above
    ask(image_server, health, _{}, Health),
    ( integer(Health.get(moves)) -> Done = Health.moves ; Done = 0 ),
    forall(( nth1(N, Ranges, RangeM), N > Done ), ask(image_server, move, _{range_m:RangeM}, _)).

restore(Situation) :-
    started_with(_, StartArgs),
    known_again(Situation, Known),
    ask(vision_server, restore, StartArgs.put(Known), _),
    server_started.
