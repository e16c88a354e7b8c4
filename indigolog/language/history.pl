:- module(indigolog_history,
          [ history_situation/2,      % +History, -Situation
            remember_situation/1,     % +Situation
            own_step/1                % ?Entry
          ]).
/** <module> Histories, lists of actions, and the situations after them */

:- use_module(library(error), [instantiation_error/1]).
:- use_module(progression, [progress/3]).
:- use_module(situation).
:- use_module(theory).

%!  history_situation(+History, -Situation) is det.
%
%   The situation after History (a list, newest action first).  The last result
%   is remembered, so that stepping through a long history is not quadratic.
%
%   @error golog(unknown_entry(Action)), golog(open_action(Action)) if one of them is not
%          an action of the theory, or has variables in it

history_situation(History, Situation) :-
    current_theory(Theory),
    (   nb_current(indigolog_last_situation, Known0),
        situation_theory(Known0, Theory0),
        Theory0 == Theory
    ->  Known = Known0
    ;   initial_situation(Theory, Known)
    ),
    reach(History, Known, Theory, Situation),
    remember_situation(Situation).

remember_situation(Situation) :-
    b_setval(indigolog_last_situation, Situation).

% The caller's own list is kept as the history, so that same_term/2 finds it again.
reach(History, Known, Theory, Situation) :-
    (   situation_history(Known, Done),
        same_term(Done, History)
    ->  Situation = Known
    ;   var(History)
    ->  instantiation_error(History)
    ;   History == []
    ->  initial_situation(Theory, Situation)
    ;   History = [A|Earlier]
    ->  known_entry(A, Theory),
        reach(Earlier, Known, Theory, Before),
        progress(A, Before, Situation0),
        with_history(History, Situation0, Situation)
    ;   throw(error(type_error(list, History), _))
    ).

known_entry(A, Theory) :-
    (   nonvar(A),
        ( history_mark(A) ; A == wait ; A == abort ; assignment(A, Theory) )
    ->  true
    ;   callable(A),
        action_template(Theory, A, _)
    ->  ( ground(A) -> true ; throw(error(golog(open_action(A)), _)) )
    ;   throw(error(golog(unknown_entry(A)), _))
    ).

%!  own_step(?Entry) is nondet.
%
%   What the interpreter adds to a history, and is no action.

own_step(e(_, _)).
own_step(test(_)).
own_step(wait).
own_step(abort).
