:- module(indigolog_patience,
          [ with_patience/2,          % +Steps, :Goal
            most_calls/1,             % -Count
            still_patient/3           % +Count, +Program, +Situation
          ]).
:- use_module(situation, [situation_history/2]).

:- meta_predicate with_patience(+, 0).

/** <module> How long a program may go on without an action

A loop whose body makes no action, or a procedure that calls itself for ever, is an
error after so many steps.
*/

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
