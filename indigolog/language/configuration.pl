:- module(indigolog_configuration,
          [ same_situation/2,         % +Situation, +Situation1
            last_action/2,            % +Situation, -Action
            after_action/5,           % +Program, +Situation, +Context, -Program1, -Situation1
            ends/3,                   % +Program, +Situation, +Context
            along/5                   % +Actions, +Program, +Situation, +Context, -Steps
          ]).
:- use_module(patience, [fresh_mark/1, silent_step/4]).
:- use_module(situation).
:- use_module(termination, [final/3]).
:- use_module(transition, [trans/5]).

/** <module> From one action to the next

Steps without an action are gone through at once.  A program that comes again
without an action in between is not followed again: it leads nowhere new.
*/

%!  same_situation(+Situation, +Situation1) is semidet.
%
%   The step from Situation to Situation1 was not an action.

same_situation(s(_, _, _, N, _), s(_, _, _, N, _)).

%!  last_action(+Situation, -Action) is semidet.

last_action(S, A) :-
    situation_history(S, [A|_]).

%!  after_action(+Program, +Situation, +Context, -Program1, -Situation1) is nondet.
%
%   Program can come, by one action, to Program1 in Situation1.

after_action(E, S, C, E1, S1) :-
    fresh_mark(Fresh),
    onward(E, S, C, Fresh, E0, S0, Mark),
    (   Mark == action
    ->  E1 = E0, S1 = S0
    ;   after_action_from(E0, S0, C, Mark, E1, S1)
    ).

after_action_from(E, S, C, Mark, E1, S1) :-
    onward(E, S, C, Mark, E0, S0, Mark1),
    (   Mark1 == action
    ->  E1 = E0, S1 = S0
    ;   after_action_from(E0, S0, C, Mark1, E1, S1)
    ).

%!  ends(+Program, +Situation, +Context) is nondet.
%
%   Program can end without another action.  Nondeterministic where it binds
%   variables of Program.

ends(E, S, C) :-
    fresh_mark(Mark),
    ends(E, S, C, Mark).

ends(E, S, C, _) :-
    final(E, S, C).
ends(E, S, C, Mark) :-
    onward(E, S, C, Mark, E1, S1, Mark1),
    Mark1 \== action,
    ends(E1, S1, C, Mark1).

onward(E, S, C, Mark, E1, S1, Mark1) :-
    trans(E, S, C, E1, S1),
    (   same_situation(S, S1)
    ->  silent_step(Mark, E1, S1, Mark1)
    ;   Mark1 = action
    ).

%!  along(+Actions, +Program, +Situation, +Context, -Steps) is nondet.
%
%   Actions are a complete execution of Program from Situation; Steps are the
%   configurations c(Program, Situation) after each of them.

along([], E, S, C, []) :-
    ends(E, S, C).
along([A|As], E, S, C, [c(E1, S1)|Steps]) :-
    after_action(E, S, C, E1, S1),
    last_action(S1, A1),
    A1 == A,
    along(As, E1, S1, C, Steps).
