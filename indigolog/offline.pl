:- module(indigolog_offline,
          [ complete/3                % +Program, +Situation, -Situation1
          ]).
:- use_module(context, [top_context/1, once_if_ground/2]).
:- use_module(termination, [final/3]).
:- use_module(transition, [step/4]).
:- use_module(situation, [situation_length/2]).

/** <module> Offline execution

Do(E, S, S1): Trans* from (E, S) to a configuration that is Final.
*/

%!  complete(+Program, +Situation, -Situation1) is nondet.
%
%   Situation1 is where a complete execution of Program from Situation ends.
%   A configuration that comes again without an action in between is not
%   followed again: it cannot lead to another history.

complete(E, S, S1) :-
    complete(E, S, none, 1, 1, S1).

% Mark is an earlier program of this situation, set at powers of two.
complete(E, S, _, _, _, S1) :-
    top_context(C),
    once_if_ground(E, final(E, S, C)),
    S1 = S.
complete(E, S, Mark, Count, Next, S1) :-
    step(E, S, E0, S0),
    situation_length(S, N),
    (   situation_length(S0, N)
    ->  E0 \=@= Mark,
        Count1 is Count+1,
        (   Count1 > Next
        ->  Next1 is Next*2,
            complete(E0, S0, E0, Count1, Next1, S1)
        ;   complete(E0, S0, Mark, Count1, Next, S1)
        )
    ;   complete(E0, S0, none, 1, 1, S1)
    ).
