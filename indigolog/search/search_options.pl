:- module(indigolog_search_options,
          [ search_strategy/2,        % +How, -Strategy
            search_option/1,          % +Option
            action_cost/4,            % +Options, +Action, +Situation, -Cost
            estimate/3,               % +Options, +Situation, -Estimate
            anytime/1,                % +Options
            new_budget/2,             % +Options, -Budget
            spend/1,                  % +Budget
            out_of_budget/1           % +Error
          ]).
/** <module> What the strategies of search share: options, costs, budgets

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
  * max_mb(M)   memory, see memory.pl
  * anytime(true)          go on improving the plan until it is the cheapest or
    the budget is used up

Term is a Golog term over fluents, or Variable^Formula: the value that Formula
gives to Variable.
*/

:- use_module(library(lists), [member/2, memberchk/2]).
:- use_module(library(option), [option/2, option/3]).
:- use_module('../language/formula', [holds_in/2, evaluate/3]).

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

%!  search_option(+Option) is semidet.

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
%   @error golog(search_value(cost(Action), Term)) if it is not a finite number >= 0

action_cost(Options, A, S, Cost) :-
    (   member(Option, Options),
        copy_term(Option, cost(A0, Term)),
        subsumes_term(A0, A),
        A0 = A
    ->  true
    ;   option(cost(Term), Options, 1)
    ),
    number_value(cost(A), Term, S, Cost),
    ( Cost < inf -> true ; throw(error(golog(search_value(cost(A), Term)), _)) ).

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
