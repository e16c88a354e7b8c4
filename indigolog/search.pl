:- module(indigolog_search,
          [ search_step/6,            % +Program, +How, +Situation, +Context, -Program1, -Situation1
            plan_expects/2,           % +Situation, +Situation
            plan_step/8               % +Program, +How, +Expected, +Steps, +Situation, +Context, -Program1, -Situation1
          ]).
:- use_module(library(lists), [member/2, memberchk/2]).
:- use_module(library(occurs), [sub_term/2]).
:- use_module(best_first, [best_first_path/5]).
:- use_module(theory).
:- use_module(transition).
:- use_module(termination).
:- use_module(situation).

/** <module> Search: look ahead to a complete execution before doing anything

A plan is '$plan'(E, How, S, Steps): the program E that remains, the situation S
it expects, and the configurations c(E1, S1) that follow, one an action.
*/

%!  search_step(+Program, +How, +Situation, +Context, -Program1, -Situation1) is nondet.
%
%   First step of a complete execution of Program, on backtracking of the next.

search_step(E, How, S, C, E1, S1) :-
    (   How = [_|_]
    ->  search_options(How),
        best_first_path(E, S, C, How, Steps)
    ;   dead_ends(E, S, Dead),
        find_path(E, S, C, Dead, Steps)
    ),
    follow(Steps, E, How, S, C, E1, S1).

search_options(Options) :-
    forall(member(Option, Options),
           (   search_option(Option)
           ->  true
           ;   throw(error(golog(search_option(Option)), _))
           )).

search_option(strategy(S)) :-
    ground(S),
    memberchk(S, [breadth, best, astar]).
search_option(heuristic(_)).
search_option(cost(_)).
search_option(max_nodes(N)) :-
    integer(N).

% Configurations from which no complete execution was found are remembered by
% program and fluent values, unless something may ask for the history itself.
dead_ends(E, S, Dead) :-
    (   sees_history(E, S)
    ->  Dead = none
    ;   trie_new(Dead)
    ).

sees_history(E, _) :-
    sub_term(T, E),
    nonvar(T), T = done(_),
    !.
sees_history(_, S) :-
    situation_theory(S, Theory),
    theory_module(Theory, Module),
    member(Head, [poss(_, _), proc(_, _), causes_val(_, _, _, _),
                  causes_true(_, _, _), causes_false(_, _, _)]),
    clause(Module:Head, Body),
    sub_term(T, Head-Body),
    nonvar(T), T = done(_),
    !.

% find_path(+E, +S, +C, +Dead, -Steps): the configurations after each action.
find_path(E, S, C, none, Steps) :-
    !,
    path(E, S, C, none, Steps).
find_path(E, S, C, Dead, Steps) :-
    situation_key(S, Key),
    \+ trie_lookup(Dead, E-Key, _),
    Found = found(false),
    (   path(E, S, C, Dead, Steps),
        nb_setarg(1, Found, true)
    ;   Found == found(false),
        trie_insert(Dead, E-Key, true),
        fail
    ).

path(E, S, C, _, []) :-
    final(E, S, C).
path(E, S, C, Dead, Steps) :-
    trans(E, S, C, E1, S1),
    (   same_situation(S, S1)
    ->  path(E1, S1, C, Dead, Steps)
    ;   Steps = [c(E1, S1)|Steps1],
        find_path(E1, S1, C, Dead, Steps1)
    ).

same_situation(S, S1) :-
    situation_length(S, N),
    situation_length(S1, N).

follow([], _, _, S, _, [], S).
follow([c(E1, S1)|Steps], _, How, _, _, '$plan'(E1, How, S1, Steps), S1).

%!  plan_step(+Program, +How, +Expected, +Steps, +Situation, +Context, -Program1, -Situation1) is nondet.

plan_step(E, How, S0, Steps, S, C, E1, S1) :-
    (   plan_expects(S0, S)
    ->  Steps = [c(E1a, S1)|Rest],
        E1 = '$plan'(E1a, How, S1, Rest)
    ;   repaired(Steps, E, S, C, Steps1)
    ->  follow(Steps1, E, How, S, C, E1, S1)
    ;   search_step(E, How, S, C, E1, S1)
    ).

%!  plan_expects(+Expected, +Situation) is semidet.

plan_expects(S0, S) :-
    situation_history(S0, H0),
    situation_history(S, H),
    ( same_term(H0, H) -> true ; H0 == H ).

% The same actions still lead to the end from here.
repaired(Steps, E, S, C, New) :-
    same_actions(Steps, E, S, C, New).

same_actions([], E, S, C, []) :-
    ends(E, S, C).
same_actions([c(_, Sx)|Steps], E, S, C, [c(E1, S1)|New]) :-
    situation_history(Sx, [A|_]),
    next_action(E, S, C, A, E1, S1),
    same_actions(Steps, E1, S1, C, New).

next_action(E, S, C, A, E1, S1) :-
    trans(E, S, C, E0, S0),
    (   same_situation(S, S0)
    ->  next_action(E0, S0, C, A, E1, S1)
    ;   situation_history(S0, [A0|_]),
        A0 == A,
        E1 = E0, S1 = S0
    ).

ends(E, S, C) :-
    final(E, S, C).
ends(E, S, C) :-
    trans(E, S, C, E1, S1),
    same_situation(S, S1),
    ends(E1, S1, C).
