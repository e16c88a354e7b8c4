:- module(indigolog_search,
          [ plan_expects/2            % +Situation, +Situation
          ]).
/** <module> Search: look ahead to a complete execution before doing anything

A plan is '$plan'(E, How, S, Steps): the program E that remains, the situation S
it expects, and the configurations c(E1, S1) that follow, one an action.  While
the world does as expected the plan is followed without looking further, to its end: what
follows its last action without another, such as tests, is its last step.  After
anything else it is tried again from where the world is now, and where it no
longer leads to the end, search begins again there.
*/

:- use_module(library(apply), [maplist/3]).
:- use_module(best_first, [best_first_path/5, beam_path/5]).
:- use_module('../language/configuration', [along/5]).
:- use_module(depth_first, [depth_first_path/4, bounded_path/5, deepening_path/5]).
:- use_module('../language/notice', [progress_message/1]).
:- use_module(search_options, [out_of_budget/1, search_strategy/2]).
:- use_module('../language/semantics').
:- use_module('../language/situation', [last_action/2, situation_history/2]).

term_expansion(Clause, Defining) :-
    construct_clause(Clause, Defining).

% Trans(search(E), S, E', S')  <=>  exists E0, S0: Trans(E, S, E0, S') & Trans*(E0, S', E0', S0)
%                                   & Final(E0', S0) & E' = the plan from E0 on
% Final(search(E), S)          <=>  Final(E, S)                 (De Giacomo and Levesque 1999)
construct(search(E), [program(E)]).
trans(search(E), S, C, E1, S1) =>
    search_step(E, [], S, C, E1, S1).
final(search(E), S, C) :-
    final(E, S, C).

% search(E, Options)  =  search(E), as the options say;  search(E, Message)  =  search(E)
construct(search(E, _), [program(E)]).
trans(search(E, How), S, C, E1, S1) =>
    (   announcement(How)
    ->  search_step(E, [], S, C, E1, S1)
    ;   search_step(E, How, S, C, E1, S1)
    ).
final(search(E, _), S, C) :-
    final(E, S, C).

announcement(How) :-
    (   atomic(How)
    ->  How \== []
    ;   How = [First|_],
        atomic(First)
    ).

construct('$plan'(E, _, _, _), [program(E)]).
shown_as('$plan'(E, _, _, _), search(E)).
trans('$plan'(E, How, S0, Steps), S, C, E1, S1) =>
    plan_step(E, How, S0, Steps, S, C, E1, S1).
final('$plan'(E, _, _, _), S, C) :-
    final(E, S, C).

% search_step(+Program, +How, +Situation, +Context, -Program1, -Situation1) is nondet:
% the first step of a complete execution of Program, on backtracking of the next, where the
% strategy finds more than one.  Fails with a warning where the budget is used up before
% there is a plan.

search_step(E, How, S, C, E1, S1) :-
    search_strategy(How, Strategy),
    catch(path(Strategy, E, S, C, How, Steps), Error, used_up(Error)),
    told(found, Steps),
    follow(Steps, E, How, S, C, E1, S1).

% A budget that is used up is no error of the program: there is no plan.
used_up(Error) :-
    (   out_of_budget(Error)
    ->  Error = error(golog(Budget), _),
        print_message(warning, golog(Budget)),
        fail
    ;   throw(Error)
    ).

path(published, E, S, C, _, Steps) =>
    depth_first_path(E, S, C, Steps).
path(depth, E, S, C, Options, Steps) =>
    bounded_path(E, S, C, Options, Steps).
path(iterative, E, S, C, Options, Steps) =>
    deepening_path(E, S, C, Options, Steps).
path(beam(_), E, S, C, Options, Steps) =>
    beam_path(E, S, C, Options, Steps).
path(_, E, S, C, Options, Steps) =>
    best_first_path(E, S, C, Options, Steps).

follow([], _, _, S, _, [], S).
follow([c(E1, S1)|Steps], _, How, _, _, '$plan'(E1, How, S1, Steps), S1).

told(What, Steps) :-
    maplist(step_action, Steps, Actions),
    progress_message(plan(What, Actions)).

step_action(c(_, S), A) :-
    last_action(S, A).

plan_step(E, How, S0, Steps, S, C, E1, S1) :-
    (   plan_expects(S0, S)
    ->  (   Steps = [c(E1a, S1)|Rest]
        ->  E1 = '$plan'(E1a, How, S1, Rest)
        ;   \+ final(E, S, C),            % the steps without an action that are left
            E1 = [],
            S1 = S
        )
    ;   maplist(step_action, Steps, Actions),
        once(along(Actions, E, S, C, Steps1))
    ->  told(kept, Steps1),
        follow(Steps1, E, How, S, C, E1, S1)
    ;   search_step(E, How, S, C, E1, S1)
    ).

%!  plan_expects(+Expected, +Situation) is semidet.
%
%   Nothing happened in Situation but what the plan did.

plan_expects(S0, S) :-
    situation_history(S0, H0),
    situation_history(S, H),
    ( same_term(H0, H) -> true ; H0 == H ).
