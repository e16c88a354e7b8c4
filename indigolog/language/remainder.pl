:- module(indigolog_remainder,
          [ sequence/3,               % +Program, +List, -Program1
            concurrent/3,             % +Program, +Program, -Program1
            prioritized/3,            % +Program, +Program, -Program1
            around/3,                 % +Part, +Program, -Program1
            around_all/3,             % +Parts, +Program, -Program1
            locked/2,                 % +Program, -Program1
            free/1,                   % +Program
            all_free/1                % +Programs
          ]).
/** <module> What remains of a program after a step

Without empty parts, and with the lock of atomic/1: while a part of a program holds it, the
programs beside that part must wait.  The mark '$locked'(E) says that something in E holds
it, so that looking for it costs nothing; it is made and read only here.
*/

:- use_module(library(lists), [append/3, member/2]).
:- use_module(semantics).

term_expansion(Clause, Defining) :-
    construct_clause(Clause, Defining).

%!  free(+Program) is semidet.
%
%   Nothing in Program holds the lock: what is beside it may step.

free(E) :-
    \+ ( nonvar(E), E = '$locked'(_) ).

% Unfolded where it is called: it is asked at each step of each construct.
:- multifile system:goal_expansion/2.

system:goal_expansion(free(E), \+ ( nonvar(E), E = '$locked'(_) )) :-
    prolog_load_context(module, Module),
    (   Module == indigolog_remainder
    ->  true
    ;   predicate_property(Module:free(_), imported_from(indigolog_remainder))
    ).

% The mark changes nothing about the program itself.
construct('$locked'(E), [program(E)]).
shown_as('$locked'(E), E).
trans('$locked'(E), S, C, E1, S1) =>
    trans(E, S, C, E1, S1).
final('$locked'(E), S, C) :-
    final(E, S, C).

%!  locked(+Program, -Program1) is det.
%
%   Program1 is Program holding the lock.

locked(E, '$locked'(E)).

%!  all_free(+Programs) is semidet.

all_free(Es) :-
    \+ ( member(E, Es), \+ free(E) ).

%!  around(+Part, +Program, -Program1) is det.
%!  around_all(+Parts, +Program, -Program1) is det.
%
%   Program1 is Program, which contains Part, or all of Parts.

around(Part, E0, E) :-
    (   free(Part)
    ->  E = E0
    ;   locked(E0, E)
    ).

around_all(Parts, E0, E) :-
    (   all_free(Parts)
    ->  E = E0
    ;   locked(E0, E)
    ).

%!  sequence(+Program, +List, -Program1) is det.
%
%   Program followed by the programs of List.  A sequence in a sequence becomes one, so that a step need not look for its
%   beginning as deep as procedures have called each other.

sequence([], L, E) =>
    (   L = [E0]
    ->  E = E0
    ;   E = L
    ).
sequence(E0, [], E) =>
    E = E0.
sequence(E0, L, E), E0 = [_|_], is_list(E0) =>
    append(E0, L, E).
sequence(E0, L, E) =>
    around(E0, [E0|L], E).

%!  concurrent(+Program, +Program2, -Program1) is det.
%!  prioritized(+Program, +Program2, -Program1) is det.
%
%   Program1 is conc/2, or pconc/2, of the two.

concurrent(E0, F, E) :-
    beside(E0, F, conc(E0, F), E).

prioritized(E0, F, E) :-
    beside(E0, F, pconc(E0, F), E).

beside([], F, _, E) => E = F.
beside(E0, [], _, E) => E = E0.
beside(E0, F, Both, E) => ( free(E0), free(F) -> E = Both ; locked(Both, E) ).
