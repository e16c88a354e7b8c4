:- module(indigolog_conditional,
          [ conditional_plan/4,       % +Program, +Situation, +Context, -Plan
            after_action/4            % +Action, +Situation, :Rest, -Plan
          ]).
/** <module> Plans that branch on what will be sensed

A conditional plan is a program of actions, case(Action, Branches) after a
sensing action, with if(Result, Plan) for each result, and if(P, Plan, Plan)
where branch(P) asked for it.  Whatever is sensed, it leads to the end
(Lakemeyer 1999; Sardina 2001).
*/

:- use_module(library(lists), [member/2]).
:- use_module('../language/knowledge', [known/2]).
:- use_module('../language/progression', [progress/3]).
:- use_module('../language/semantics').
:- use_module('../language/sensing', [sensing_action/1, sensing_results/3]).
:- use_module('../language/situation').
:- use_module('../language/theory').

term_expansion(Clause, Defining) :-
    construct_clause(Clause, Defining).

% Trans(case(a, Branches), S, E', S')  <=>  E' = E & S' = S, for if(R, E) of Branches and the
%                                           last sensing result R of a in S
% Final(case(a, Branches), S)          <=>  False
construct(case(_, Branches), [programs(Es)]) :-
    (   is_list(Branches)
    ->  findall(E, member(if(_, E), Branches), Es)
    ;   Es = []
    ).
trans(case(A, Branches), S, _, E1, S1) =>
    S1 = S,
    situation_history(S, History),
    member(e(A, R), History),
    !,
    member(if(R, E1), Branches),
    !.

% Trans(branch(P), S, E', S')  <=>  E' = [] & S' = do(branch(P), S)
% Final(branch(P), S)          <=>  False
construct(branch(P), [formula(P)]).
trans(branch(P), S, _, E1, S1) =>
    E1 = [],
    progress(branch(P), S, S1).

%!  conditional_plan(+Program, +Situation, +Context, -Plan) is nondet.
%
%   Plan is a conditional plan for a complete execution of Program.

conditional_plan(E, S, C, Plan) :-
    plan_on(E, C, [], S, Plan).

% plan_on(+Program, +Context, +Seen, +Situation, -Plan): Seen are the programs
% met in this situation.
plan_on(E, C, _, S, []) :-
    final(E, S, C).
plan_on(E, C, Seen, S, Plan) :-
    trans(E, S, C, E1, S1),
    (   same_situation(S, S1)
    ->  \+ ( member(E0, [E|Seen]), E0 =@= E1 ),
        plan_on(E1, C, [E|Seen], S1, Plan)
    ;   last_action(S1, A),
        after_step(A, S, S1, plan_on(E1, C, []), Plan)
    ).

:- meta_predicate
    after_step(+, +, +, 2, -),
    after_action(+, +, 2, -).

% after_step(+Action, +Situation, +Situation1, :Rest, -Plan): call(Rest, S, Plan1)
% plans what comes after Action.
after_step(branch(P), S, _, Rest, Plan) =>
    (   ( known(P, S) ; known(neg(P), S) )
    ->  call(Rest, S, Plan)
    ;   assume_formula(P, S, S1, S2),
        Plan = [if(P, Plan1, Plan2)],
        once(call(Rest, S1, Plan1)),
        once(call(Rest, S2, Plan2))
    ).
after_step(test(P), _, S1, Rest, Plan) =>
    Plan = [?(P)|Plan1],
    call(Rest, S1, Plan1).
after_step(A, _, S1, Rest, Plan) =>
    after_action(A, S1, Rest, Plan).

%!  after_action(+Action, +Situation, :Rest, -Plan) is nondet.
%
%   Plan is Action, which led to Situation, and what call(Rest, S, Plan1) plans for
%   after it, or after each of its sensing results.

after_action(A, S, Rest, [A|Plan]) :-
    (   sensing_action(A),
        sensing_results(A, S, Results)
    ->  Plan = [case(A, Branches)],
        branches(Results, A, S, Rest, Branches),
        Branches \== []
    ;   call(Rest, S, Plan)
    ).

% A result that contradicts what is known cannot come.
branches([], _, _, _, []).
branches([R|Rs], A, S, Rest, Branches) :-
    (   catch(progress(e(A, R), S, S1), error(golog(impossible_result(_, _, _)), _), fail)
    ->  Branches = [if(R, Plan)|Branches1],
        once(call(Rest, S1, Plan))
    ;   Branches = Branches1
    ),
    branches(Rs, A, S, Rest, Branches1).

assume_formula(F, S, S1, S2) :-
    callable(F),
    situation_theory(S, Theory),
    fluent_template(Theory, F, rel),
    !,
    progress(e(F, true), S, S1),
    progress(e(F, false), S, S2).
assume_formula(F = V, S, S1, S2) :-
    situation_theory(S, Theory),
    callable(F),
    fluent_template(Theory, F, fun),
    fluent_status(F, S, any(Vs)),
    findall(W, ( member(W, Vs), W \== V ), [W1|Ws]),
    !,
    possible_value([W1|Ws], Others),
    progress(e(F, V), S, S1),
    progress(e(F, Others), S, S2).
assume_formula(P, _, _, _) :-
    throw(error(golog(cannot_branch(P)), _)).
