:- module(indigolog_best_first,
          [ best_first_path/5         % +Program, +Situation, +Context, +Options, -Steps
          ]).
:- use_module(library(heaps), [empty_heap/1, add_to_heap/4, get_from_heap/4]).
:- use_module(library(lists), [member/2, reverse/2]).
:- use_module(library(option), [option/3]).
:- use_module(context, [once_if_ground/2]).
:- use_module(formula, [evaluate/3]).
:- use_module(situation).
:- use_module(termination, [final/3]).
:- use_module(transition, [trans/5]).

/** <module> Search in order of cost

Configurations are taken in order of g + h: g is what the actions so far cost, h
a term over fluents that estimates what is still to pay.  A configuration whose
program and fluent values were met before, at no higher cost, is not met again.
*/

%!  best_first_path(+Program, +Situation, +Context, +Options, -Steps) is semidet.
%
%   Options:
%
%     * strategy(Strategy)   `breadth`, `best` (h alone) or `astar` (g + h)
%     * heuristic(Term)      h, 0 by default
%     * cost(Term)           of one action, 1 by default, evaluated before it
%     * max_nodes(N)         most configurations to expand
%
%   @error golog(search_budget(N)) if the budget is used up

best_first_path(E, S, C, Options, Steps) :-
    option(strategy(Strategy), Options, astar),
    option(heuristic(H), Options, 0),
    option(cost(Cost), Options, 1),
    option(max_nodes(Max), Options, 1_000_000),
    empty_heap(Empty),
    How = how(Strategy, H, Cost, C, Max),
    push(E, S, 0, [], How, Empty, Heap),
    trie_new(Met),
    expand(Heap, How, Met, 0, Steps0),
    !,
    reverse(Steps0, Steps).

push(E, S, G, Steps, how(Strategy, H, _, _, _), Heap0, Heap) :-
    evaluate(H, S, Term),
    Estimate is Term,
    rank(Strategy, G, Estimate, F),
    add_to_heap(Heap0, F, node(E, S, G, Steps), Heap).

rank(breadth, G, _, G).
rank(best, _, H, H).
rank(astar, G, H, F) :-
    F is G+H.

expand(Heap0, How, Met, N, Steps) :-
    How = how(_, _, _, C, Max),
    (   N < Max
    ->  true
    ;   throw(error(golog(search_budget(Max)), _))
    ),
    get_from_heap(Heap0, _, node(E, S, G, Steps0), Heap1),
    situation_key(S, Key),
    (   trie_lookup(Met, E-Key, G0),
        G0 =< G
    ->  expand(Heap1, How, Met, N, Steps)
    ;   (   trie_update(Met, E-Key, G)
        ->  true
        ;   true
        ),
        (   ends(E, S, C)
        ->  Steps = Steps0
        ;   findall(E1-A, next_action(E, S, C, E1, A), Next),
            price(How, S, G, G1),
            push_all(Next, S, G1, Steps0, How, Heap1, Heap),
            N1 is N+1,
            expand(Heap, How, Met, N1, Steps)
        )
    ).

price(how(_, _, Cost, _, _), S, G, G1) :-
    evaluate(Cost, S, Term),
    G1 is G+Term.

push_all([], _, _, _, _, Heap, Heap).
push_all([E-A|Next], S, G, Steps, How, Heap0, Heap) :-
    progress(A, S, S1),
    push(E, S1, G, [c(E, S1)|Steps], How, Heap0, Heap1),
    push_all(Next, S, G, Steps, How, Heap1, Heap).

% Steps without an action up to the next one.
next_action(E, S, C, E1, A) :-
    trans(E, S, C, E0, S0),
    (   situation_length(S, N),
        situation_length(S0, N)
    ->  next_action(E0, S, C, E1, A)
    ;   situation_history(S0, [A|_]),
        E1 = E0
    ).

ends(E, S, C) :-
    once_if_ground(E, final(E, S, C)).
ends(E, S, C) :-
    trans(E, S, C, E1, S1),
    situation_length(S, N),
    situation_length(S1, N),
    ends(E1, S1, C).
