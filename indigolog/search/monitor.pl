:- module(indigolog_monitor,
          [ unplanned/4               % +Program, +Situation, +Context, -Left
          ]).
/** <module> Conditional plans, watched while they are executed

A plan that is being executed is '$conditional'(Monitor, Plan), with the Monitor
monitored(Source, From, Own, Expected): what the plan is for, searchc(Program) or
achieve(Goal, Max, Options); the situation it was made in; the lengths that the history
had after each action of its own; the situation that it expects.  A sensing result for
which it has a branch is expected.  After anything else it is made again, for what is
left to do.
*/

:- use_module(library(error), [must_be/2]).
:- use_module(library(lists), [append/3, member/2, memberchk/2, reverse/2]).
:- use_module(achieve, [plan_for/5]).
:- use_module(conditional, [conditional_plan/4]).
:- use_module('../language/configuration', [after_action/5]).
:- use_module('../language/formula', [holds_in/2]).
:- use_module('../language/notice', [progress_message/1]).
:- use_module(search, [plan_expects/2]).
:- use_module('../language/progression', [progress/3]).
:- use_module('../language/semantics').
:- use_module('../language/situation').

term_expansion(Clause, Defining) :-
    construct_clause(Clause, Defining).

% Trans(searchc(E), S, E', S')  <=>  S' = S & E' = a conditional plan for E in S
% Final(searchc(E), S)          <=>  Final(E, S)
construct(searchc(E), [program(E)]).
trans(searchc(E), S, C, E1, S1) =>
    monitored_plan(searchc(E), S, C, E1, S1).
final(searchc(E), S, C) :-
    final(E, S, C).

% searchc(E, Message)  =  searchc(E)
construct(searchc(E, _), [program(E)]).
trans(searchc(E, _), S, C, E1, S1) =>
    trans(searchc(E), S, C, E1, S1).
final(searchc(E, _), S, C) :-
    final(E, S, C).

% Trans(achieve(P, N, Options), S, E', S')  <=>  S' = S & E' = a conditional plan for P in S
%                                                of at most N actions
% Final(achieve(P, N, Options), S)          <=>  False
construct(achieve(P, _, _), [formula(P)]).
trans(achieve(P, Max, Options), S, C, E1, S1) =>
    must_be(nonneg, Max),
    monitored_plan(achieve(P, Max, Options), S, C, E1, S1).

% achieve(P, N)  =  achieve(P, N, []), achieve(P)  =  achieve(P, 10)
construct(achieve(P, _), [formula(P)]).
trans(achieve(P, Max), S, C, E1, S1) =>
    trans(achieve(P, Max, []), S, C, E1, S1).

construct(achieve(P), [formula(P)]).
trans(achieve(P), S, C, E1, S1) =>
    trans(achieve(P, 10), S, C, E1, S1).

% A plan that is being executed.
construct('$conditional'(_, Plan), [program(Plan)]).
shown_as('$conditional'(_, Plan), Plan).
trans('$conditional'(Monitor, Plan), S, C, E1, S1) =>
    monitored_step(Monitor, Plan, S, C, E1, S1).
final('$conditional'(Monitor, _), S, C) :-
    monitored_final(Monitor, S, C).

% monitored_plan(+Source, +Situation, +Context, -Program1, -Situation1) is nondet.

monitored_plan(Source, S, C, '$conditional'(monitored(Source, S, [], S), Plan), S) :-
    plan(Source, S, C, Plan).

plan(searchc(E), S, C, Plan) :-
    conditional_plan(E, S, C, Plan).
plan(achieve(Goal, Max, Options), S, _, Plan) :-
    plan_for(Goal, S, Max, Options, Plan).

% monitored_step(+Monitor, +Plan, +Situation, +Context, -Program1, -Situation1) is nondet.

monitored_step(monitored(Source, From, Own, Expected), Plan, S, C, E1, S1) :-
    (   Plan == [],
        plan_expects(Expected, S)
    ->  E1 = [],                          % what follows its last action without another
        S1 = S
    ;   as_planned(Plan, Expected, S)
    ->  trans(Plan, S, C, Plan1, S1),
        situation_length(S, N),
        situation_length(S1, N1),
        ( N1 =:= N -> Own1 = Own ; Own1 = [N1|Own] ),
        E1 = '$conditional'(monitored(Source, From, Own1, S1), Plan1)
    ;   left(Source, From, Own, S, C, Source1),
        monitored_plan(Source1, S, C, E1, S1),
        E1 = '$conditional'(_, Plan1),
        progress_message(planned_again(Plan1))
    ).

as_planned(_, Expected, S) :-
    plan_expects(Expected, S),
    !.
as_planned(Plan, Expected, S) :-
    ( Plan = [case(A, Branches)|_] ; Plan = case(A, Branches) ),
    situation_history(S, [e(A, Result)|Before]),
    situation_history(Expected, Before1),
    Before1 == Before,
    \+ \+ member(if(Result, _), Branches),
    !.

% monitored_final(+Monitor, +Situation, +Context) is nondet.

monitored_final(monitored(Source, From, Own, Expected), S, C) :-
    \+ plan_expects(Expected, S),
    left(Source, From, Own, S, C, Left),
    done(Left, S, C).

done(searchc(E), S, C) :-
    final(E, S, C).
done(achieve(Goal, _, _), S, _) :-
    \+ \+ holds_in(Goal, S).

%!  unplanned(+Program, +Situation, +Context, -Left) is semidet.
%
%   Program is a plan under way that did not expect what has happened; Left is what there has to be another plan for.

unplanned('$conditional'(monitored(Source, From, Own, Expected), Plan), S, C, Left) :-
    \+ plan_expects(Expected, S),
    \+ as_planned(Plan, Expected, S),
    once(left(Source, From, Own, S, C, Left)).

% left(+Source, +From, +Own, +Situation, +Context, -Source1): what is left to do in
% Situation, the actions at the lengths Own having been done for it.
left(achieve(Goal, Max, Options), _, _, _, _, achieve(Goal, Max, Options)).
left(searchc(E), From, Own, S, C, searchc(E1)) :-
    situation_length(From, N0),
    situation_length(S, N),
    situation_history(S, History),
    Count is N-N0,
    length(Since, Count),
    append(Since, _, History),
    reverse(Since, Happened),
    follow(Happened, N0, Own, From, C, E, E1).

follow([], _, _, _, _, E, E).
follow([A|As], N, Own, S, C, E, E1) :-
    N1 is N+1,
    (   memberchk(N1, Own)
    ->  (   A = failed(Tried, _)          % its step has been made, as outside of plans, and not its effects
        ->  done_for(E, S, C, Tried, E2, _),
            progress(A, S, S2)
        ;   done_for(E, S, C, A, E2, S2)
        )
    ;   E2 = E,
        progress(A, S, S2)
    ),
    follow(As, N1, Own, S2, C, E2, E1).

% What only marks a test or a branch in the plan is not in the history.
done_for(E, S, C, A, E1, S1) :-
    after_action(E, S, C, E2, S2),
    last_action(S2, A2),
    (   A2 == A
    ->  E1 = E2, S1 = S2
    ;   ( A2 = test(_) ; A2 = branch(_) )
    ->  done_for(E2, S, C, A, E1, S1)
    ).
