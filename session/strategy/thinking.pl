:- module(session_thinking,
          [ note_thought/0,
            apart_from_thought/1,       % :Goal
            tell_thought/1,             % +When
            within_budget/4             % +Options, +File, +Seconds, :Goal
          ]).
/** <module> How long a strategy may compute between two actions, and what is said of it meanwhile

Loops without actions are found by the interpreter, and sessions without images by run.pl; a test in plain Prolog that
never ends is met here.  What counts is the time of the processor, less what goes by while a server is waited for.  Where
the strategy stands is told by the calls that are open when an alarm rings.
*/

:- use_module('../servers/connections', [waits_for_server/0]).
:- use_module('../display/display', [show/2]).
:- use_module(strategy_file, [strategy_files/2]).
:- use_module('../usage_errors', [usage_error/2]).
:- use_module('../../bridge/prolog/zmq', [zmq_without_stops/1]).
:- use_module('../../indigolog/online/devices', [waits_for_event/0]).
:- use_module(library(lists), [member/2]).
:- use_module(library(time), [alarm/4, remove_alarm/1]).

:- meta_predicate
    within_budget(+, +, +, 0),
    apart_from_thought(0).

looks(12).                              % at least, at a strategy while its budget lasts; chosen by hand
patience_s(1).                          % between two looks, and after which it is said what is waited for; chosen by hand

%!  within_budget(+Options, +File, +Seconds, :Goal) is nondet.
%
%   Goal runs the strategy of File.  What takes longer than a second is shown.
%
%   @error usage_error(Message) where Goal computes for longer than Seconds without note_thought/0

within_budget(Options, File, Seconds, Goal) :-
    strategy_files(File, Files),
    nb_setval(session_thinks, thinks(Options, Files)),
    note_thought,
    nb_setval(session_looks, []),
    setup_call_cleanup(zmq_without_stops(look_later(Seconds)), Goal, look_no_more). % starts the alarms' thread

%   The look that rings now is removed by the one after it: not before it has rung.  A stop waits meanwhile: an alarm that has
%   been removed and is still told of would be removed once more, and the memory that it had is another's by then.
look_later(Seconds) :-
    sig_atomic(set_look(Seconds)).

set_look(Seconds) :-
    nb_getval(session_looks, Looks),
    (   Looks = [Ringing|Rung]
    ->  forall(member(Look, Rung), remove_alarm(Look)),
        Kept = [Ringing]
    ;   Kept = []
    ),
    looks(Count),
    patience_s(Patience),
    Later is min(Patience, Seconds / Count),
    alarm(Later, session_thinking:look(Seconds), New, [remove(false)]),
    nb_setval(session_looks, [New|Kept]).

look_no_more :-
    sig_atomic(remove_looks).

remove_looks :-
    nb_getval(session_looks, Looks),
    nb_setval(session_looks, none),
    nb_setval(session_thinks, none),
    forall(member(Look, Looks), remove_alarm(Look)).

%!  note_thought is det.
%
%   An action was done.

note_thought :-
    statistics(cputime, Spent),
    get_time(Now),
    nb_setval(session_thought_at, at(Spent, Now, unsaid)).

%!  apart_from_thought(:Goal) is semidet.
%
%   Goal is none of the strategy's.

apart_from_thought(Goal) :-
    nb_getval(session_thinks, Thinks),
    setup_call_cleanup(nb_setval(session_thinks, none), once(Goal), ( nb_setval(session_thinks, Thinks), note_thought )).

:- public look/1.

look(Seconds) :-
    ( waits_for_server -> note_thought ; true ),
    nb_getval(session_thought_at, at(Before, _, Said)),
    statistics(cputime, Spent),
    (   Spent - Before > Seconds
    ->  stands_at(Place, Where),
        usage_error("~w: the strategy has computed for ~w s~w without an action; does one of its tests never end?",
                    [Place, Seconds, Where])
    ;   nb_getval(session_looks, none)
    ->  true                            % the end came first
    ;   ( Said == unsaid -> tell_thought(now) ; true ),
        look_later(Seconds)
    ).

%!  tell_thought(+When) is det.
%
%   Say what the strategy does `now`, or did when it was `stopped`, where it has done no action for some time.

tell_thought(When) :-
    (   nb_current(session_thinks, thinks(Options, _)),
        nb_getval(session_thought_at, at(Before, Since, _)),
        \+ waits_for_server,
        get_time(Now),
        patience_s(Patience),
        Now - Since >= Patience
    ->  nb_setval(session_thought_at, at(Before, Since, said)),
        (   waits_for_event
        ->  show(Options, thinking(When, wait))
        ;   stands_at(Place, Where),
            show(Options, thinking(When, computing(Place, Where)))
        )
    ;   true
    ).

%   The innermost call of one of the strategy's own predicates, or its file alone.
stands_at(Place, Where) :-
    nb_getval(session_thinks, thinks(_, Files)),
    (   prolog_current_frame(Frame),
        open_call(Frame, Module:Name/Arity),
        functor(Head, Name, Arity),
        predicate_property(Module:Head, file(File)),
        member(One, Files),
        same_file(One, File)
    ->  predicate_property(Module:Head, line_count(Line)),
        format(atom(Place), "~w:~d", [One, Line]),
        format(atom(Where), " in ~q", [Name/Arity])
    ;   Files = [Place|_],
        Where = ''
    ).

open_call(Frame, Called) :-
    (   prolog_frame_attribute(Frame, predicate_indicator, Called)
    ;   prolog_frame_attribute(Frame, parent, Parent),
        open_call(Parent, Called)
    ).
