:- module(indigolog_best_first,
          [ best_first_path/5,        % +Program, +Situation, +Context, +Options, -Steps
            beam_path/5               % +Program, +Situation, +Context, +Options, -Steps
          ]).
/** <module> Search with a frontier: breadth first, best first, A*, beam

A node is node(E, S, Free, G, H, Path): the program with its free variables, the
situation, the cost so far, the estimate, and the configurations on the way,
newest first, each with its own copy of the free variables.  A configuration
whose program and fluent values were met at no higher cost is not met again.

With anytime(true) the search goes on after a plan is found and drops what
cannot be cheaper (Hansen and Zhou 2007); it ends when nothing is left or the
budget is used up.  Cost + estimate must then never be too high where `astar`
or `beam` is to find the cheapest plan.
*/

:- use_module(library(heaps), [empty_heap/1, add_to_heap/4, get_from_heap/4]).
:- use_module(library(lists), [append/2, append/3, reverse/2]).
:- use_module(library(apply), [foldl/4]).
:- use_module(library(option), [option/3]).
:- use_module('../language/configuration').
:- use_module(memory).
:- use_module(search_options).
:- use_module('../language/progression', [progress/3, stop_interrupts/3, stopped_depth/2]).
:- use_module('../language/situation', [last_action/2]).

%!  best_first_path(+Program, +Situation, +Context, +Options, -Steps) is semidet.
%
%   @error golog(search_budget(Option)) if the budget is used up before there is
%          any plan

best_first_path(E, S, C, Options, Steps) :-
    search_strategy(Options, Strategy),
    start(E, S, Options, Node, Search),
    empty_heap(Empty),
    push(Node, Strategy, Options, 0-Empty, Frontier),
    best(Frontier, Strategy, C, Options, Search, none, Best),
    plan(Best, Node, Steps).

start(E, S, Options, node(E, S, Free, 0, H, []), search(Memory, Budget)) :-
    new_memory(E, S, Options, Memory),
    \+ seen(Memory, E, S, 0),
    new_budget(Options, Budget),
    term_variables(E, Free),
    estimate(Options, S, H).

% plan(+Node, +Start, -Steps): the configurations on the way from Start, whose free variables are those of the search.
plan(node(_, _, Free, _, _, Path), node(_, _, Free, _, _, _), Steps) :-
    reverse(Path, Configurations),
    steps(Configurations, Free, Steps).

% What the end of the plan binds holds all along it.
steps([], _, []).
steps([c(E, S, Free)|Configurations], Free, [c(E, S)|Steps]) :-
    steps(Configurations, Free, Steps).

push(Node, Strategy, Options, N-Heap0, N1-Heap) :-
    Node = node(_, _, _, G, H, _),
    (   H =:= inf
    ->  N1 = N, Heap = Heap0
    ;   rank(Strategy, Options, Node, G, H, Rank),
        N1 is N+1,
        add_to_heap(Heap0, Rank-N1, Node, Heap)
    ).

% The lower rank goes first; of equal ones the one nearer to its end.
rank(breadth, _, node(_, _, _, _, _, Path), _, _, Rank) =>
    length(Path, Rank).
rank(best, _, _, _, H, Rank) =>
    Rank = H.
rank(_, Options, _, G, H, Rank) =>
    option(weight(W), Options, 1),
    F is G+W*H,
    Rank = F-H.

best(Frontier, Strategy, C, Options, Search, Best0, Best) :-
    (   catch(node_to_expand(Frontier, Strategy, Options, Search, Best0, Node, Frontier1),
              Error,
              ( out_of_budget(Error), Best0 \== none -> Node = none ; throw(Error) ))
    ->  (   Node == none
        ->  Best = Best0
        ;   complete(Node, C)
        ->  (   anytime(Options)
            ->  best(Frontier1, Strategy, C, Options, Search, Node, Best)
            ;   Best = Node
            )
        ;   successors(Node, C, Options, Search, Nodes),
            push_all(Nodes, Strategy, Options, Best0, Frontier1, Frontier2),
            best(Frontier2, Strategy, C, Options, Search, Best0, Best)
        )
    ;   Best0 \== none,
        Best = Best0
    ).

node_to_expand(N-Heap0, Strategy, Options, Search, Best, Node, Frontier) :-
    get_from_heap(Heap0, _, Node0, Heap),
    Search = search(Memory, Budget),
    Node0 = node(E, S, _, G, _, _),
    (   ( superseded(Memory, E, S, G) ; cannot_improve(Best, Strategy, Node0) )
    ->  node_to_expand(N-Heap, Strategy, Options, Search, Best, Node, Frontier)
    ;   spend(Budget),
        Node = Node0,
        Frontier = N-Heap
    ).

cannot_improve(node(_, _, _, Cost, _, _), Strategy, node(_, _, _, G, H, _)) :-
    (   admissible(Strategy)
    ->  G+H >= Cost
    ;   G >= Cost
    ).

% The strategies that take cost + estimate for a lower bound.
admissible(astar).
admissible(beam(_)).

push_all([], _, _, _, Frontier, Frontier).
push_all([Node|Nodes], Strategy, Options, Best, Frontier0, Frontier) :-
    (   cannot_improve(Best, Strategy, Node)
    ->  Frontier1 = Frontier0
    ;   push(Node, Strategy, Options, Frontier0, Frontier1)
    ),
    push_all(Nodes, Strategy, Options, Best, Frontier1, Frontier).

complete(node(E, S, _, _, _, _), C) :-
    once(ends(E, S, C)).

% successors(+Node, +C, +Options, +Search, -Nodes): what was not met before.
% findall/3 copies, so it collects programs and actions, and the situations are
% made again from the actions, that they may share what does not change.

successors(node(E, S, Free, G, _, Path), C, Options, search(Memory, _), Nodes) :-
    findall(E1-Free-Action, next(E, S, C, E1, Action), Next),
    nodes(Next, S, G, Path, Memory, Options, Nodes).

next(E, S, C, E1, Action) :-
    after_action(E, S, C, E1, S1),
    last_action(S1, A),
    (   A == stop_interrupts
    ->  stopped_depth(S1, Depth),
        Action = stop(Depth)
    ;   Action = do(A)
    ).

nodes([], _, _, _, _, _, []).
nodes([E-Free-Action|Next], S, G, Path, Memory, Options, Nodes) :-
    done(Action, S, S1),
    last_action(S1, A),
    action_cost(Options, A, S, Cost),
    G1 is G+Cost,
    (   seen(Memory, E, S1, G1)
    ->  Nodes = Nodes1
    ;   estimate(Options, S1, H),
        Nodes = [node(E, S1, Free, G1, H, [c(E, S1, Free)|Path])|Nodes1]
    ),
    nodes(Next, S, G, Path, Memory, Options, Nodes1).

done(do(A), S, S1) =>
    progress(A, S, S1).
done(stop(Depth), S, S1) =>
    stop_interrupts(Depth, S, S1).


                /* Beam */

%!  beam_path(+Program, +Situation, +Context, +Options, -Steps) is semidet.
%
%   Layer after layer of executions of equal length, keeping the Width best of
%   each by cost + estimate.  Need not find a plan where there is one.

beam_path(E, S, C, Options, Steps) :-
    search_strategy(Options, Strategy),
    start(E, S, Options, Node, Search),
    layers([Node], Strategy, C, Options, Search, none, Best),
    plan(Best, Node, Steps).

layers([], _, _, _, _, Best, Best) :-
    !,
    Best \== none.
layers(Layer, Strategy, C, Options, Search, Best0, Best) :-
    catch(next_layer(Layer, Strategy, C, Options, Search, Best0, Best1, Next),
          Error,
          ( out_of_budget(Error), Best0 \== none
          -> Next = [], Best1 = Best0
          ;  throw(Error) )),
    (   Best1 \== none,
        \+ anytime(Options)
    ->  Best = Best1
    ;   layers(Next, Strategy, C, Options, Search, Best1, Best)
    ).

next_layer(Layer, Strategy, C, Options, Search, Best0, Best, Next) :-
    foldl(expand(Strategy, C, Options, Search), Layer, Best0-[], Best-Lists),
    append(Lists, Nodes),
    empty_heap(Empty),
    push_all(Nodes, Strategy, Options, Best, 0-Empty, _-Heap),
    Strategy = beam(Width),
    first(Width, Heap, Next).

expand(Strategy, C, Options, Search, Node, Best0-Lists, Best-Lists1) :-
    (   cannot_improve(Best0, Strategy, Node)
    ->  Best = Best0, Lists1 = Lists
    ;   Search = search(_, Budget),
        spend(Budget),
        complete(Node, C)
    ->  Best = Node, Lists1 = Lists
    ;   Best = Best0,
        successors(Node, C, Options, Search, Nodes),
        append(Lists, [Nodes], Lists1)
    ).

first(0, _, Nodes) :-
    !,
    Nodes = [].
first(N, Heap0, Nodes) :-
    (   get_from_heap(Heap0, _, Node, Heap)
    ->  Nodes = [Node|Nodes1],
        N1 is N-1,
        first(N1, Heap, Nodes1)
    ;   Nodes = []
    ).
