:- module(indigolog_context,
          [ top_context/1,            % -Context
            enter/3,                  % +Call, +Context, -Context1
            context_depth/2,          % +Context, -Depth
            interrupts_context/3,     % +Depth, +Context, -Context1
            stopped_context/2,        % +Context, -Context1
            interrupts_running/1,     % +Context
            interrupts_stopped/3,     % +Depth, +Situation, +Situation1
            stopped_interrupts/2,     % +Program, -Program1
            by_priority/2,            % +Interrupts, -Program
            sequence/3,               % +Program, +List, -Program1
            concurrent/3,             % +Program, +Program, -Program1
            prioritized/3,            % +Program, +Program, -Program1
            for_sequence/5,           % +Variable, +Domain, +Program, +Situation, -Program1
            once_if_ground/2,         % +Term, :Goal
            around/3,                 % +Part, +Program, -Program1
            within/2,                 % +Seconds, :Goal
            in_step/3                 % +Error, +Program, +Situation
          ]).
:- use_module(library(apply), [maplist/4]).
:- use_module(library(error), [must_be/2]).
:- use_module(library(lists), [member/2]).
:- use_module(library(time), [alarm/4, remove_alarm/1]).
:- use_module('../tools/point', [program_point/5]).
:- use_module(patience, [most_calls/1]).
:- use_module(situation).
:- use_module(theory).
:- use_module(formula, [evaluate/3]).
:- use_module(substitution).

:- meta_predicate
    once_if_ground(?, 0),
    within(+, 0).

/** <module> The context of a step, and the remainders of programs

A context c(Depth, Running, Mark, Count) says how many prioritized_interrupts/1
surround the program point, whether the innermost still runs, and how many
procedures were entered without a step since.  A procedure that calls itself
again with the same arguments without a step cannot contribute one (Trans and
Final are least fixpoints), so it fails there; one that does so with ever new
arguments is an error.
*/

top_context(c(0, false, [], 0)).

context_depth(c(Depth, _, _, _), Depth).

%!  enter(+Call, +Context, -Context1) is semidet.
%
%   @error golog(recursion(Call, Count))

enter(Call, c(D, R, Mark, N), c(D, R, Mark1, N1)) :-
    Call \=@= Mark,
    N1 is N+1,
    (   N /\ N1 =:= 0                     % a power of two: mark this call
    ->  Mark1 = Call
    ;   Mark1 = Mark
    ),
    most_calls(Limit),
    (   N1 < Limit
    ->  true
    ;   throw(error(golog(recursion(Call, N1)), _))
    ).


                /* Interrupts */

interrupts_context(N, c(_, _, M, K), c(N, true, M, K)).

stopped_context(c(N, _, M, K), c(N, false, M, K)).

interrupts_running(c(_, true, _, _)).

%!  interrupts_stopped(+Depth, +Situation, +Situation1) is semidet.
%
%   The step from Situation to Situation1 was a stop_interrupts of this depth.

interrupts_stopped(N, S, S1) :-
    situation_history(S1, [stop_interrupts|Before]),
    situation_history(S, Here),
    same_term(Before, Here),
    stopped_depth(S1, N).

stopped_interrupts(E, E1) :-
    (   E == []
    ->  E1 = []
    ;   around(E, '$stopped'(E), E1)
    ).

% Each interrupt over all later ones; when all are blocked, they stop.
by_priority([], stop_interrupts).
by_priority([I|Is], pconc(I, E)) :-
    by_priority(Is, E).


                /* Remainders */

%!  sequence(+Program, +List, -Program1) is det.
%
%   Program followed by the programs of List, without empty parts.

sequence([], L, E) =>
    (   L = [E0]
    ->  E = E0
    ;   E = L
    ).
sequence(E0, [], E) =>
    E = E0.
sequence('$locked'(E0), L, E) =>
    E = '$locked'(['$locked'(E0)|L]).
sequence(E0, L, E) =>
    E = [E0|L].

concurrent([], F, E) => E = F.
concurrent(E0, [], E) => E = E0.
concurrent('$locked'(E0), F, E) => E = '$locked'(conc('$locked'(E0), F)).
concurrent(E0, '$locked'(F), E) => E = '$locked'(conc(E0, '$locked'(F))).
concurrent(E0, F, E) => E = conc(E0, F).

prioritized([], F, E) => E = F.
prioritized(E0, [], E) => E = E0.
prioritized('$locked'(E0), F, E) => E = '$locked'(pconc('$locked'(E0), F)).
prioritized(E0, '$locked'(F), E) => E = '$locked'(pconc(E0, '$locked'(F))).
prioritized(E0, F, E) => E = pconc(E0, F).

%!  around(+Part, +Program, -Program1) is det.
%
%   Program1 is Program, which contains Part.  A part that holds a lock (atomic/1)
%   is marked all the way up, so that no other part may step.

around(Part, E0, E) :-
    (   nonvar(Part),
        Part = '$locked'(_)
    ->  E = '$locked'(E0)
    ;   E = E0
    ).

%!  for_sequence(+Variable, +Domain, +Program, +Situation, -Sequence) is det.

for_sequence(V, D, E, S, Es) :-
    evaluate(D, S, D1),
    situation_theory(S, Theory),
    domain_list(Theory, D1, Values),
    instances(Values, V, E, Es).

instances([], _, _, []).
instances([X|Xs], V, E, [E1|Es]) :-
    substitute(V, X, E, E1),
    instances(Xs, V, E, Es).

once_if_ground(Term, Goal) :-
    (   ground(Term)
    ->  once(Goal)
    ;   call(Goal)
    ).

%!  within(+Seconds, :Goal) is nondet.
%
%   Goal has this solution, if all its solutions are found within Seconds.

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


                /* Errors */

% A test that calls a predicate which the theory does not have.
own_words(Formal, Context, S, Told, Context1) :-
    (   Formal = existence_error(procedure, Module:PI),
        situation_theory(S, Theory),
        theory_module(Theory, Module)
    ->  Told = golog(unknown_formula(PI))
    ;   Told = Formal, Context1 = Context
    ).

%!  in_step(+Error, +Program, +Situation) is failure.
%
%   Rethrow Error with the program and the history it was met in.

in_step(Error, E, S) :-
    (   Error = error(Formal, Context),
        \+ is_dict(Context),              % of a stack overflow
        \+ subsumes_term(golog(_, _), Context)
    ->  situation_history(S, History),
        program_point(Formal, E, S, Point, Bindings),
        own_words(Formal, Context, S, Told, Context1),
        throw(error(Told, golog(at(E, History), point(Point, Bindings, Context1))))
    ;   throw(Error)
    ).
