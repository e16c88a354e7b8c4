:- module(indigolog_patience,
          [ with_patience/2,          % +Steps, :Goal
            most_calls/1,             % -Count
            still_patient/3,          % +Count, +Program, +Situation
            fresh_mark/1,             % -Mark
            silent_step/4             % +Mark, +Program, +Situation, -Mark1
          ]).
/** <module> How long a program may go on without an action

A loop whose body makes no action, or a procedure that calls itself for ever, is an
error after so many steps.
*/

:- use_module(situation, [situation_history/2]).

:- meta_predicate with_patience(+, 0).

% Steps without an action in between; as many would be seconds of work.
patience(Steps) :-
    (   nb_current(indigolog_patience, Steps0)
    ->  Steps = Steps0
    ;   Steps = 100_000
    ).

%!  with_patience(+Steps, :Goal) is nondet.
%
%   Run Goal with another number of steps without an action, or `default`.

with_patience(default, Goal) :-
    !,
    call(Goal).
with_patience(Steps, Goal) :-
    patience(Before),
    setup_call_cleanup(nb_setval(indigolog_patience, Steps),
                       Goal,
                       nb_setval(indigolog_patience, Before)).

%!  most_calls(-Count) is det.
%
%   Most calls of procedures before a single step.  They nest, so they are fewer.

most_calls(Count) :-
    patience(Steps),
    Count is min(Steps, 20_000).

%!  still_patient(+Count, +Program, +Situation) is det.
%
%   @error golog(silent(Most)) if Count steps without an action are too many

still_patient(Count, E, S) :-
    patience(Most),
    (   Count =< Most
    ->  true
    ;   situation_history(S, History),
        throw(error(golog(silent(Most)), golog(at(E, History), _)))
    ).

%!  fresh_mark(-Mark) is det.
%
%   The mark of a program that has just made an action, for silent_step/4.

fresh_mark(mark('$none', 1, 1)).

%!  silent_step(+Mark, +Program, +Situation, -Mark1) is semidet.
%
%   A step without an action led to Program.  Fails if that is an earlier program
%   of this situation: going on from there leads nowhere new.  The mark holds an
%   earlier program, set at powers of two, so that every cycle is met.
%
%   @error golog(silent(Most)) if there were too many such steps

silent_step(mark(Earlier, Count, Next), E, S, Mark) :-
    E \=@= Earlier,
    Count1 is Count+1,
    still_patient(Count1, E, S),
    (   Count1 > Next
    ->  Next1 is Next*2,
        Mark = mark(E, Count1, Next1)
    ;   Mark = mark(Earlier, Count1, Next)
    ).
