:- module(indigolog_configuration,
          [ after_action/5,           % +Program, +Situation, +Context, -Program1, -Situation1
            ends/3,                   % +Program, +Situation, +Context
            along/5                   % +Actions, +Program, +Situation, +Context, -Steps
          ]).
/** <module> From one action to the next

Steps without an action are gone through at once.  A program that comes again
without an action in between is not followed again: it leads nowhere new.
*/

:- use_module(patience, [fresh_mark/1, silent_step/4]).
:- use_module(semantics, [final/3, trans/5]).
:- use_module(situation, [last_action/2, same_situation/2]).

%!  after_action(+Program, +Situation, +Context, -Program1, -Situation1) is nondet.
%
%   Program can come, by one action, to Program1 in Situation1.

after_action(E, S, C, E1, S1) :-
    fresh_mark(Fresh),
    after_action(E, S, C, Fresh, E1, S1).

after_action(E, S, C, Mark, E1, S1) :-
    onward(E, S, C, Mark, E0, S0, Mark1),
    (   Mark1 == action
    ->  E1 = E0, S1 = S0
    ;   after_action(E0, S0, C, Mark1, E1, S1)
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
