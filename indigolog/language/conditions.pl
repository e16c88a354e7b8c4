:- module(indigolog_conditions, []).
/** <module> Conditions on a whole program, and limits on its time */

:- use_module(library(error), [must_be/2]).
:- use_module(library(lists), [member/2]).
:- use_module(library(time), [alarm/4, remove_alarm/1]).
:- use_module(context, [once_if_ground/2]).
:- use_module(formula, [holds_in/2]).
:- use_module(remainder, [around/3]).
:- use_module(semantics).

:- meta_predicate within(+, 0).

term_expansion(Clause, Defining) :-
    construct_clause(Clause, Defining).

% Trans(gexec(P, E), S, E', S')  <=>  exists E0: E' = gexec(P, E0) & P[S] & Trans(E, S, E0, S')
% Final(gexec(P, E), S)          <=>  ~P[S] or Final(E, S)
construct(gexec(P, E), [formula(P), program(E)]).
trans(gexec(P, E), S, C, E1, S1) =>
    once_if_ground(P, holds_in(P, S)),
    trans(E, S, C, E0, S1),
    around(E0, gexec(P, E0), E1).
final(gexec(P, E), S, C) :-
    (   \+ holds_in(P, S)
    ->  true
    ;   final(E, S, C)
    ).

% Trans(goal(P, E, Q, R), S, E', S')  <=>  ~P[S] & Q[S] & Trans(R, S, E', S')
%                 or ~P[S] & ~Q[S] & exists E0: E' = goal(P, E0, Q, R) & Trans(E, S, E0, S')
% Final(goal(P, E, Q, R), S)          <=>  P[S] or Final(E, S)
construct(goal(P, E, Q, R), [formula(P), program(E), formula(Q), program(R)]).
trans(goal(P, E, Q, R), S, C, E1, S1) =>
    \+ holds_in(P, S),
    (   holds_in(Q, S)
    ->  trans(R, S, C, E1, S1)
    ;   trans(E, S, C, E0, S1),
        around(E0, goal(P, E0, Q, R), E1)
    ).
final(goal(P, E, _, _), S, C) :-
    (   holds_in(P, S)
    ->  true
    ;   final(E, S, C)
    ).

% time(E, T)  =  E, if its first step, or that it may end, is found within T seconds
construct(time(E, _), [program(E)]).
trans(time(E, Seconds), S, C, E1, S1) =>
    within(Seconds, trans(E, S, C, E1, S1)).
final(time(E, Seconds), S, C) :-
    within(Seconds, final(E, S, C)).

% ttime(E, T)  =  time(E, T) for each step of E
construct(ttime(E, _), [program(E)]).
trans(ttime(E, Seconds), S, C, E1, S1) =>
    within(Seconds, trans(E, S, C, E0, S1)),
    around(E0, ttime(E0, Seconds), E1).
final(ttime(E, Seconds), S, C) :-
    within(Seconds, final(E, S, C)).

% within(+Seconds, :Goal): Goal has this solution, if all are found within Seconds.
within(Seconds, Goal) :-
    must_be(number, Seconds),
    flag(indigolog_alarm, N, N+1),
    term_variables(Goal, Answer),
    catch(setup_call_cleanup(
              alarm(Seconds, throw(golog_late(N)), Alarm, [remove(false)]),
              findall(Answer, Goal, Answers),
              remove_alarm(Alarm)),
          golog_late(N),
          fail),
    member(Answer, Answers).
