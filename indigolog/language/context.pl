:- module(indigolog_context,
          [ top_context/1,            % -Context
            enter/3,                  % +Call, +Context, -Context1
            context_depth/2,          % +Context, -Depth
            interrupts_context/3,     % +Depth, +Context, -Context1
            stopped_context/2,        % +Context, -Context1
            interrupts_running/1,     % +Context
            once_if_ground/2          % +Term, :Goal
          ]).
/** <module> The context of a step

A context c(Depth, Running, Mark, Count) says how many prioritized_interrupts/1
surround the program point, whether the innermost still runs, and how many
procedures were entered without a step since.  A procedure that calls itself
again with the same arguments without a step cannot contribute one (Trans and
Final are least fixpoints), so it fails there; one that does so with ever new
arguments is an error.
*/

:- use_module(patience, [most_calls/1]).

:- meta_predicate once_if_ground(?, 0).

top_context(c(0, false, [], 0)).

context_depth(c(Depth, _, _, _), Depth).

interrupts_context(N, c(_, _, M, K), c(N, true, M, K)).

stopped_context(c(N, _, M, K), c(N, false, M, K)).

interrupts_running(c(_, true, _, _)).

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

%!  once_if_ground(+Term, :Goal) is nondet.

once_if_ground(Term, Goal) :-
    (   ground(Term)
    ->  once(Goal)
    ;   call(Goal)
    ).
