:- module(indigolog_achieve,
          [ plan_for/5                % +Goal, +Situation, +Max, +Options, -Plan
          ]).
/** <module> Conditional plans for a goal

The planner of Levesque that the published interpreter has for achieve/3: depth first
with a growing bound, in forward direction.
*/

:- use_module(library(error), [must_be/2]).
:- use_module(library(lists), [member/2]).
:- use_module(library(option), [option/3]).
:- use_module(library(solution_sequences), [distinct/2]).
:- use_module(conditional, [after_action/4]).
:- use_module('../language/formula', [holds_in/2]).
:- use_module('../language/notice', [progress_message/1]).
:- use_module('../language/progression', [progress/3]).
:- use_module('../language/sensing', [sensing_action/1]).
:- use_module('../language/situation').
:- use_module('../language/theory').

% Most exogenous actions that a simulator may suppose before one action; chosen by hand.
most_supposed(1000).

%!  plan_for(+Goal, +Situation, +Max, +Options, -Plan) is nondet.
%
%   Plan is a conditional plan after which the formula Goal holds and of which no
%   branch has more than Max actions, those with the least longest branch first.
%   Options:
%
%     * actions(List)   the actions that may be used; what their declarations and preconditions
%       leave open of them is bound as it stands there
%     * id(Name)        the name of the problem for restrict_actions/6, Goal by default
%     * simid(Id)       before each action the exogenous actions of simulator(Id,
%       Condition, Action) happen, each while its condition holds
%     * mess(Text)      what to say when planning begins
%
%   restrict_actions(Name, Goal, N, Actions, Condition, Actions1) of the theory replaces
%   Actions by Actions1 where N more actions are allowed and Condition holds.
%
%   @error golog(achieve_option(Option)), golog(simulator_loops(Id))

plan_for(Goal, S, Max, Options, Plan) :-
    planning_options(Options, Known),
    option(mess(Text), Known, none),
    ( Text == none -> true ; progress_message(planning(Text)) ),
    option(id(Name), Known, Goal),
    option(simid(Simulator), Known, none),
    option(actions(Actions), Known, [_]),
    distinct(Plan,                        % a larger bound finds the shorter ones, too
             ( between(0, Max, N),
               reach(problem(Name, Goal, Actions, Simulator), N, S, Plan) )).

% Options of achieve/3, or, as in older theories, the list of actions.
planning_options(Options, Known) :-
    must_be(list, Options),
    (   member(O, Options),
        \+ ( callable(O), planning_option(O) )
    ->  (   Options = [actions(_)|_]
        ->  throw(error(golog(achieve_option(O)), _))
        ;   Known = [actions(Options)]
        )
    ;   Known = Options
    ).

planning_option(actions(L)) :- is_list(L).
planning_option(id(_)).
planning_option(simid(_)).
planning_option(mess(_)).

reach(Problem, N, S, Plan) :-
    Problem = problem(_, Goal, _, Simulator),
    (   \+ \+ holds_in(Goal, S)
    ->  Plan = []
    ;   N > 0,
        N1 is N-1,
        allowed_actions(Problem, N, S, Actions),
        supposed(Simulator, S, S1, Plan, Plan1),
        allowed_action(Actions, S1, A),
        progress(A, S1, S2),
        (   sensing_action(A)
        ->  Rest = reach_soon(Problem, N1)
        ;   Rest = reach(Problem, N1)
        ),
        after_action(A, S2, Rest, Plan1)
    ).

% Each branch of a case is as short as it can be.
reach_soon(Problem, Max, S, Plan) :-
    between(0, Max, N),
    reach(Problem, N, S, Plan).

allowed_actions(problem(Name, Goal, Actions0, _), N, S, Actions) :-
    situation_theory(S, Theory),
    theory_module(Theory, Module),
    (   current_predicate(Module:restrict_actions/6),
        Module:restrict_actions(Name, Goal, N, Actions0, Condition, Actions1),
        holds_in(Condition, S)
    ->  Actions = Actions1
    ;   Actions = Actions0
    ).

allowed_action(Actions, S, A) :-
    situation_theory(S, Theory),
    theory_module(Theory, Module),
    Module:prim_action(A),
    (   ground(A)
    ->  \+ \+ ( member(A, Actions), possible(A, Module, S) )
    ;   distinct(A, ( member(A, Actions), possible(A, Module, S), ground(A) ))
    ).

possible(A, Module, S) :-
    Module:poss(A, P),
    holds_in(P, S).

% supposed(+Simulator, +Situation, -Situation1, -Plan, ?Rest): what the simulator makes
% happen, which stands in the plan as sim(Action).
supposed(none, S, S1, Plan, Rest) =>
    S1 = S,
    Plan = Rest.
supposed(Id, S, S1, Plan, Rest) =>
    most_supposed(Most),
    supposed(Id, Most, S, S1, Plan, Rest).

supposed(Id, Left, S, S1, Plan, Rest) :-
    situation_theory(S, Theory),
    theory_module(Theory, Module),
    (   current_predicate(Module:simulator/3),
        Module:simulator(Id, Condition, A0),
        holds_in(Condition, S)
    ->  (   Left =:= 0
        ->  throw(error(golog(simulator_loops(Id)), _))
        ;   true
        ),
        ( A0 = sim(_) -> A = A0 ; A = sim(A0) ),
        progress(A, S, S2),
        Plan = [A|Plan1],
        Left1 is Left-1,
        supposed(Id, Left1, S2, S1, Plan1, Rest)
    ;   S1 = S,
        Plan = Rest
    ).
