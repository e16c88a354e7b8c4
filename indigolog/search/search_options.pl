:- module(indigolog_search_options,
          [ search_strategy/2,        % +How, -Strategy
            action_cost/4,            % +Options, +Action, +Situation, -Cost
            estimate/3,               % +Options, +Situation, -Estimate
            anytime/1,                % +Options
            new_budget/2,             % +Options, -Budget
            spend/1,                  % +Budget
            out_of_budget/1,          % +Error
            new_memory/4,             % +Program, +Situation, +Options, -Memory
            remember/3,               % +Memory, +Key, +Value
            seen/4,                   % +Memory, +Program, +Situation, +Cost
            superseded/4              % +Memory, +Program, +Situation, +Cost
          ]).
:- use_module(library(error), [must_be/2]).
:- use_module(library(lists), [member/2, memberchk/2]).
:- use_module(library(occurs), [sub_term/2]).
:- use_module(library(option), [option/2, option/3]).
:- use_module('../language/formula', [holds_in/2, evaluate/3]).
:- use_module('../language/situation', [situation_key/2, situation_theory/2]).
:- use_module('../language/theory', [theory_module/2]).

/** <module> What the strategies of search share: options, costs, budgets, memory

Options of search/2:

  * strategy(Strategy)     `depth`, `breadth`, `iterative` (deepening), `best`
    (the estimate alone), `astar` (cost so far + weight * estimate; the default),
    `beam(Width)`
  * cost(Term)             of any action, evaluated before it; 1 by default
  * cost(Action, Term)     of the actions that match Action; the first that
    matches counts
  * heuristic(Term)        estimate of the cost still to come, 0 by default; `inf`
    for a dead end
  * weight(W)              of the estimate in `astar`, 1 by default
  * max_nodes(N), max_seconds(T)   budgets
  * max_mb(M)   memory for the configurations that were met
  * anytime(true)          go on improving the plan until it is the cheapest or
    the budget is used up

Term is a Golog term over fluents, or Variable^Formula: the value that Formula
gives to Variable.
*/

%!  search_strategy(+How, -Strategy) is det.
%
%   How is a list of options; anything else, and the empty list, is the search
%   as published.
%
%   @error golog(search_option(Option))

search_strategy(How, Strategy) :-
    (   How = [_|_]
    ->  (   member(Option, How),
            \+ search_option(Option)
        ->  throw(error(golog(search_option(Option)), _))
        ;   option(strategy(Strategy), How, astar)
        )
    ;   Strategy = published
    ).

search_option(Option) :-
    nonvar(Option),
    option_of_search(Option).

option_of_search(strategy(S)) :-
    ground(S),
    (   memberchk(S, [depth, breadth, iterative, best, astar])
    ;   S = beam(Width), integer(Width), Width > 0
    ),
    !.
option_of_search(heuristic(_)).
option_of_search(cost(_)).
option_of_search(cost(_, _)).
option_of_search(weight(W)) :- number(W), W >= 0.
option_of_search(max_nodes(N)) :- integer(N), N >= 0.
option_of_search(max_seconds(T)) :- number(T), T >= 0.
option_of_search(max_mb(M)) :- number(M), M > 0.
option_of_search(anytime(B)) :- memberchk(B, [true, false]).


                /* Costs */

%!  action_cost(+Options, +Action, +Situation, -Cost) is det.
%
%   What Action costs in Situation, the one before it.
%
%   @error golog(search_value(What, Term, Value)) if it is not a number >= 0

action_cost(Options, A, S, Cost) :-
    (   member(Option, Options),
        copy_term(Option, cost(A0, Term)),
        subsumes_term(A0, A),
        A0 = A
    ->  true
    ;   option(cost(Term), Options, 1)
    ),
    number_value(cost(A), Term, S, Cost).

%!  estimate(+Options, +Situation, -Estimate) is det.

estimate(Options, S, Estimate) :-
    option(heuristic(Term), Options, 0),
    number_value(heuristic, Term, S, Estimate).

number_value(_, N, _, Value), number(N), N >= 0 =>
    Value = N.
number_value(What, Term, S, Value) =>
    (   value(Term, S, V0),
        catch(V is V0, error(type_error(_, _), _), fail),
        V >= 0
    ->  Value = V
    ;   throw(error(golog(search_value(What, Term)), _))
    ).

value(Term, S, V) :-
    (   nonvar(Term),
        Term = _^_
    ->  copy_term(Term, V^P),
        once(holds_in(P, S))
    ;   once(evaluate(Term, S, V))
    ).

%!  anytime(+Options) is semidet.

anytime(Options) :-
    option(anytime(true), Options).


                /* Budgets */

%!  new_budget(+Options, -Budget) is det.

new_budget(Options, budget(0, Max, Seconds, End)) :-
    option(max_nodes(Max), Options, inf),
    option(max_seconds(Seconds), Options, inf),
    (   Seconds == inf
    ->  End = inf
    ;   get_time(Now),
        End is Now+Seconds
    ).

%!  spend(+Budget) is det.
%
%   One more configuration is looked at.
%
%   @error golog(search_budget(Option)) if that is one too many

spend(Budget) :-
    Budget = budget(N, Max, Seconds, End),
    (   N < Max
    ->  true
    ;   throw(error(golog(search_budget(max_nodes(Max))), _))
    ),
    (   End == inf
    ->  true
    ;   get_time(Now),
        Now =< End
    ->  true
    ;   throw(error(golog(search_budget(max_seconds(Seconds))), _))
    ),
    N1 is N+1,
    nb_setarg(1, Budget, N1).

%!  out_of_budget(+Error) is semidet.

out_of_budget(error(golog(search_budget(_)), _)).


                /* Memory */

% Megabytes of configurations, where no option says otherwise: what a laptop of 4 GB has to
% spare.  Chosen by hand.
most_megabytes(1000).

% Of a node of a trie, as the process grows: 2.6 million took 220 MB (SWI-Prolog 9.0.4).
node_bytes(85).

%!  new_memory(+Program, +Situation, +Options, -Memory) is det.
%
%   Memory of configurations, by program and fluent values, memory(Trie, MostNodes); `none`
%   where something may ask for the history itself, which tells two situations with equal
%   values apart.

new_memory(E, S, Options, Memory) :-
    (   sees_history(E, S)
    ->  Memory = none
    ;   most_megabytes(Default),
        option(max_mb(Megabytes), Options, Default),
        node_bytes(Bytes),
        Most is floor(Megabytes*1.0e6/Bytes),
        trie_new(Trie),
        Memory = memory(Trie, Most)
    ).

%!  remember(+Memory, +Key, +Value) is det.
%
%   @error golog(search_budget(max_mb(Megabytes, Configurations))) if that is one too many

remember(memory(Trie, Most), Key, Value) :-
    trie_insert(Trie, Key, Value),
    trie_property(Trie, node_count(Nodes)),
    (   Nodes =< Most
    ->  true
    ;   trie_property(Trie, value_count(N)),
        node_bytes(Bytes),
        Megabytes is ceiling(Nodes*Bytes/1.0e6),
        throw(error(golog(search_budget(max_mb(Megabytes, N))), _))
    ).

sees_history(E, _) :-
    asks_history(E),
    !.
sees_history(_, S) :-
    situation_theory(S, Theory),
    theory_module(Theory, Module),
    member(Head, [poss(_, _), proc(_, _), causes_val(_, _, _, _),
                  causes_true(_, _, _), causes_false(_, _, _)]),
    clause(Module:Head, Body),
    asks_history(Head-Body),
    !.

asks_history(Term) :-
    sub_term(T, Term),
    nonvar(T),
    T = done(_).

%!  seen(+Memory, +Program, +Situation, +Cost) is semidet.
%
%   The configuration was met before at no higher cost.  Fails if not, and
%   remembers Cost.

seen(none, _, _, _) :-
    !,
    fail.
seen(Memory, E, S, Cost) :-
    Memory = memory(Trie, _),
    situation_key(S, Key),
    (   trie_lookup(Trie, E-Key, Cost0)
    ->  (   Cost0 =< Cost
        ->  true
        ;   trie_update(Trie, E-Key, Cost),
            fail
        )
    ;   remember(Memory, E-Key, Cost),
        fail
    ).

%!  superseded(+Memory, +Program, +Situation, +Cost) is semidet.
%
%   The configuration has been met at a lower cost.

superseded(Memory, E, S, Cost) :-
    Memory = memory(Trie, _),
    situation_key(S, Key),
    trie_lookup(Trie, E-Key, Cost0),
    Cost0 < Cost.
