:- module(indigolog_offline,
          [ complete/3,               % +Program, +Situation, -Situation1
            complete/4,               % +Program, +Situation, +Longest, -Situation1
            bounded_do/4              % +Program, +Max, -History, -LimitMet
          ]).
/** <module> Offline execution

Do(E, S, S1): Trans* from (E, S) to a configuration that is Final, or to the first abort, which ends a run.
*/

:- use_module(context, [top_context/1, once_if_ground/2]).
:- use_module(semantics, [final/3, may_end/2, step/4]).
:- use_module(patience, [fresh_mark/1, silent_step/4]).
:- use_module(situation, [initial_situation/1, last_action/2, situation_history/2, situation_length/2]).

% Steps of an execution that may leave another choice open, where no limit is given: as many as search/1 allows
% actions.  They wait on the stack; a step that leaves none does not count.
most_open(100_000).

% Actions after which a loop that never ends is likely, and goes on for minutes: a power of two, chosen by hand.
long_execution(262_144).

% Share of the stack that an execution may fill; chosen by hand.
most_of_stack(0.5).

%!  complete(+Program, +Situation, -Situation1) is nondet.
%
%   Situation1 is where a complete execution of Program from Situation ends.
%   A configuration that comes again without an action in between is not
%   followed again: it cannot lead to another history.
%
%   @error golog(open_end(Actions, Steps)) if 100 000 Steps have left a choice open before that
%   @error golog(no_end(Actions)) if half of the stack is used up before that

complete(E, S, S1) :-
    going(E, S, inf-_, S1).

%!  complete(+Program, +Situation, +Longest, -Situation1) is nondet.
%
%   As complete/3, where no history on the way is longer than Longest, and any number of choices may be open.

complete(E, S, Longest, S1) :-
    going(E, S, Longest-limit(false), S1).

%!  bounded_do(+Program, +Max, -History, -LimitMet) is semidet.
%
%   History of the first complete execution from the initial situation with at
%   most Max actions (or `inf`).  When it fails, LimitMet is `true` if longer
%   ones were cut off.

bounded_do(E, Max, History, Met) :-
    initial_situation(S),
    Limit = limit(false),
    (   going(E, S, Max-Limit, S1)
    ->  situation_history(S1, History)
    ;   Limit = limit(true)
    ->  Met = true,
        History = none
    ;   fail
    ).

going(E, S, Limit, S1) :-
    fresh_mark(Mark),
    going(E, S, Mark, 0, Limit, S1).

% Open steps on the way have left a choice.
going(E, S, Mark, Open, Limit, S1) :-
    top_context(C),
    (   \+ may_end(E, S)
    ->  onward(E, S, Mark, Open, Limit, S1)
    ;   \+ step(E, S, _, _)
    ->  once_if_ground(E, final(E, S, C)),
        S1 = S
    ;   (   once_if_ground(E, final(E, S, C)),
            S1 = S
        ;   onward(E, S, Mark, Open, Limit, S1)
        )
    ).

onward(E, S, Mark, Open, Limit, S1) :-
    prolog_current_choice(Before),
    step(E, S, E0, S0),
    prolog_current_choice(After),
    ( After == Before -> Open0 = Open ; Open0 is Open+1 ),
    situation_length(S, N),
    (   situation_length(S0, N)
    ->  silent_step(Mark, E0, S0, Mark1),
        going(E0, S0, Mark1, Open0, Limit, S1)
    ;   within_limit(Limit, N, Open0),
        ( N /\ 0xFFF =:= 0 -> within_stack(N) ; true ),
        (   last_action(S0, abort)
        ->  S1 = S0
        ;   fresh_mark(Mark1),
            going(E0, S0, Mark1, Open0, Limit, S1)
        )
    ).

% Looked at every 4096 actions: beyond half of it, Prolog may not find room to tell of an overflow.
within_stack(N) :-
    ( long_execution(N) -> print_message(warning, golog(long_execution(N))) ; true ),
    most_of_stack(Share),
    current_prolog_flag(stack_limit, Limit),
    Most is Share*Limit,
    (   stack_used(Bytes0),
        Bytes0 =< Most
    ->  true
    ;   garbage_collect,
        stack_used(Bytes),
        Bytes =< Most
    ->  true
    ;   throw(error(golog(no_end(N)), _))
    ).

stack_used(Bytes) :-
    statistics(globalused, Global),
    statistics(localused, Local),
    statistics(trailused, Trail),
    Bytes is Global+Local+Trail.

within_limit(Max-Limit, N, Open) :-
    (   Max == inf
    ->  most_open(Most),
        ( Open < Most -> true ; N1 is N+1, throw(error(golog(open_end(N1, Open)), _)) )
    ;   N < Max
    ->  true
    ;   nb_setarg(1, Limit, true),
        fail
    ).
