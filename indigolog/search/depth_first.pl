:- module(indigolog_depth_first,
          [ depth_first_path/4,       % +Program, +Situation, +Context, -Steps
            bounded_path/5,           % +Program, +Situation, +Context, +Options, -Steps
            deepening_path/5          % +Program, +Situation, +Context, +Options, -Steps
          ]).
/** <module> Search in depth first order */

:- use_module(library(apply), [maplist/3]).
:- use_module('../language/configuration').
:- use_module(memory).
:- use_module(search_options).
:- use_module('../language/semantics', [final/3, trans/5]).
:- use_module('../language/situation').

% Most actions of a plan in search as published, which has no budget.
most_actions(100_000).

%!  depth_first_path(+Program, +Situation, +Context, -Steps) is nondet.
%
%   Search as published: complete executions in the order in which Trans and
%   Final give them.  Configurations from which there is none are remembered, and
%   one that comes again on its own path is not followed: Trans would come to it
%   without end.
%
%   @error golog(search_depth(N)) if an execution goes on for ever

depth_first_path(E, S, C, Steps) :-
    new_memory(E, S, [], Memory),
    most_actions(Most),
    situation_length(S, N),
    Deepest is N+Most,
    step_on(E, S, C, how(Memory, Deepest), Steps).     % a step, even where E is final

path(E, S, C, How, Steps) :-
    How = how(none, _),
    !,
    onward(E, S, C, How, Steps).
path(E, S, C, How, Steps) :-
    How = how(Memory, _),
    configuration_key(E, S, Key),
    \+ ( recalled(Memory, Key, Known), Known \== alive ),     % open or dead
    remember(Memory, Key, open),
    Found = found(false),
    (   onward(E, S, C, How, Steps),
        nb_setarg(1, Found, true)
    ;   ( Found = found(true) -> remember(Memory, Key, alive) ; remember(Memory, Key, dead) ),
        fail
    ).

onward(E, S, C, _, []) :-
    final(E, S, C).
onward(E, S, C, How, Steps) :-
    step_on(E, S, C, How, Steps).

step_on(E, S, C, How, Steps) :-
    trans(E, S, C, E1, S1),
    (   same_situation(S, S1)
    ->  E1 \=@= E,
        onward(E1, S1, C, How, Steps)
    ;   not_too_deep(S1, How),
        Steps = [c(E1, S1)|Steps1],
        path(E1, S1, C, How, Steps1)
    ).

not_too_deep(S, how(_, Deepest)) :-
    situation_length(S, N),
    (   N =< Deepest
    ->  true
    ;   most_actions(Most),
        throw(error(golog(search_depth(Most)), _))
    ).


                /* Branch and bound */

%!  bounded_path(+Program, +Situation, +Context, +Options, -Steps) is nondet.
%
%   The first complete execution in depth first order within the budget; with
%   anytime(true) the cheapest that the budget allows to find.  A configuration
%   is gone through again only at a lower cost.

bounded_path(E, S, C, Options, Steps) :-
    new_budget(Options, Budget),
    new_memory(E, S, Options, Memory),
    (   anytime(Options)
    ->  Best = best(inf, none),
        catch(improve(E, S, C, Memory, Budget, Best, Options), Error, kept(Error, Best)),
        Best = best(_, Actions),
        Actions \== none,
        once(along(Actions, E, S, C, Steps))
    ;   within(E, S, C, 0, inf-_, how(Memory, Budget, Options), Steps, _)
    ).

improve(E, S, C, Memory, Budget, Best, Options) :-
    forall(within(E, S, C, 0, Best-_, how(Memory, Budget, Options), Steps, Cost),
           ( maplist(step_action, Steps, Actions),
             nb_setarg(1, Best, Cost),
             nb_setarg(2, Best, Actions) )).

kept(Error, Best) :-
    (   out_of_budget(Error),
        Best = best(_, Actions),
        Actions \== none
    ->  true
    ;   throw(Error)
    ).

step_action(c(_, S), A) :-
    last_action(S, A).

%!  deepening_path(+Program, +Situation, +Context, +Options, -Steps) is semidet.
%
%   A cheapest complete execution by depth first search up to a bound on cost +
%   estimate, which is raised to the least value that was cut off (IDA*, Korf
%   1985); with the default cost and estimate this is iterative deepening on the
%   number of actions.

deepening_path(E, S, C, Options, Steps) :-
    new_budget(Options, Budget),
    estimate(Options, S, Estimate),
    Estimate < inf,
    deepen(Estimate, E, S, C, Budget, Options, Steps).

deepen(Bound, E, S, C, Budget, Options, Steps) :-
    new_memory(E, S, Options, Memory),
    Next = next(inf),
    (   within(E, S, C, 0, Bound-Next, how(Memory, Budget, Options), Steps, _)
    ->  true
    ;   Next = next(Higher),
        Higher < inf,
        deepen(Higher, E, S, C, Budget, Options, Steps)
    ).

% within(+E, +S, +C, +G, +Limit, +How, -Steps, -Cost): a complete execution from
% (E, S), reached at cost G, that costs Cost in all and stays within Limit, which
% is Bound-Next (Next collects the least value above it) or best(Cost, _)-_ (that
% has to be improved on).

within(E, S, C, G, Limit, How, Steps, Cost) :-
    How = how(Memory, Budget, Options),
    spend(Budget),
    \+ seen(Memory, E, S, G),
    (   ends(E, S, C),
        better(Limit, G),
        Steps = [],
        Cost = G
    ;   after_action(E, S, C, E1, S1),
        last_action(S1, A),
        action_cost(Options, A, S, Step),
        G1 is G+Step,
        estimate(Options, S1, H),
        F is G1+H,
        allowed(Limit, F),
        Steps = [c(E1, S1)|Steps1],
        within(E1, S1, C, G1, Limit, How, Steps1, Cost)
    ).

better(best(Cost, _)-_, G) =>
    G < Cost.
better(_, _) =>
    true.

allowed(best(Cost, _)-_, F) =>
    F < Cost.
allowed(inf-_, F) =>
    F < inf.
allowed(Bound-Next, F) =>
    (   F =< Bound
    ->  true
    ;   arg(1, Next, Least),
        F < Least,
        nb_setarg(1, Next, F),
        fail
    ).
