:- module(indigolog_context,
          [ top_context/1,            % -Context
            enter/3,                  % +Call, +Context, -Context1
            enter_final/3,            % +Call, +Context, -Context1
            context_depth/2,          % +Context, -Depth
            interrupts_context/3,     % +Depth, +Context, -Context1
            stopped_context/2,        % +Context, -Context1
            interrupts_running/1,     % +Context
            once_if_ground/2          % +Term, :Goal
          ]).
/** <module> The context of a step

A context c(Depth, Running, Mark, Count, Mark, Count) says how many
prioritized_interrupts/1 surround the program point, whether the innermost still
runs, and how many procedures were entered without a step since, and one of them:
where Trans was asked, and where Final was.

A procedure that comes to itself again with the same arguments is not entered
again, as that would go on for ever; one that does so with ever new arguments is
an error.  For Final that is its least fixpoint.  For Trans it is less, where
something follows the inner call, is beside it or around it: of proc(r, ndet([], [r, up])),
which may do any number of up, the first step is found where the inner r is final,
and not where it makes a step.  The whole of Trans is infinite there, a first step for each
number of up that it may leave, and what asks for all steps, as a search that is to fail,
would not end.  proc(r, ndet([], [up, r])) is found whole.
*/

:- use_module(patience, [most_calls/1]).

:- meta_predicate once_if_ground(?, 0).

top_context(c(0, false, [], 0, [], 0)).

context_depth(c(Depth, _, _, _, _, _), Depth).

interrupts_context(N, c(_, _, M, K, FM, FK), c(N, true, M, K, FM, FK)).

stopped_context(c(N, _, M, K, FM, FK), c(N, false, M, K, FM, FK)).

interrupts_running(c(_, true, _, _, _, _)).

%!  enter(+Call, +Context, -Context1) is semidet.
%!  enter_final(+Call, +Context, -Context1) is semidet.
%
%   Trans, or Final, of the procedure Call is asked for that of its body.
%
%   @error golog(recursion(Call, Count))

enter(Call, c(D, R, M, K, FM, FK), c(D, R, M1, K1, FM, FK)) :-
    entered(Call, M, K, M1, K1).

enter_final(Call, c(D, R, M, K, FM, FK), c(D, R, M, K, FM1, FK1)) :-
    entered(Call, FM, FK, FM1, FK1).

entered(Call, Mark, N, Mark1, N1) :-
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
