:- module(session_thinking,
          [ note_thought/0,
            within_budget/3             % +Controller, +Seconds, :Goal
          ]).
/** <module> How long a strategy may compute between two actions

Loops without actions are found by the interpreter, and sessions without images by run.pl; a test in plain Prolog that
never ends is met here.  What counts is the time of the processor, less what goes by while a server is waited for.
*/

:- use_module(connections, [waits_for_server/0]).
:- use_module(usage, [usage_error/2]).
:- use_module('../bridge/prolog/zmq', [zmq_without_stops/1]).
:- use_module(library(lists), [member/2]).
:- use_module(library(time), [alarm/4, remove_alarm/1]).

:- meta_predicate within_budget(+, +, 0).

looks(12).                              % at a strategy while its budget lasts; chosen by hand

%!  within_budget(+Controller, +Seconds, :Goal) is nondet.
%
%   @error usage_error(Message) where Goal computes for longer than Seconds without note_thought/0

within_budget(Controller, Seconds, Goal) :-
    note_thought,
    nb_setval(session_looks, []),
    setup_call_cleanup(zmq_without_stops(look_later(Controller, Seconds)), Goal, look_no_more). % starts the alarms' thread

%   The look that rings now is removed by the one after it: not before it has rung.
look_later(Controller, Seconds) :-
    nb_getval(session_looks, Looks),
    (   Looks = [Ringing|Rung]
    ->  forall(member(Look, Rung), remove_alarm(Look)),
        Kept = [Ringing]
    ;   Kept = []
    ),
    looks(Count),
    Later is Seconds / Count,
    alarm(Later, session_thinking:look(Controller, Seconds), New, [remove(false)]),
    nb_setval(session_looks, [New|Kept]).

look_no_more :-
    nb_getval(session_looks, Looks),
    nb_setval(session_looks, none),
    forall(member(Look, Looks), remove_alarm(Look)).

%!  note_thought is det.
%
%   An action was done.

note_thought :-
    statistics(cputime, Spent),
    nb_setval(session_thought_at, Spent).

:- public look/2.

look(Controller, Seconds) :-
    ( waits_for_server -> note_thought ; true ),
    nb_getval(session_thought_at, Before),
    statistics(cputime, Spent),
    (   Spent - Before > Seconds
    ->  usage_error("~w: the strategy has computed for ~w s without an action; does one of its tests never end?",
                    [Controller, Seconds])
    ;   nb_getval(session_looks, none)
    ->  true                            % the end came first
    ;   look_later(Controller, Seconds)
    ).
