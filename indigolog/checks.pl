:- module(indigolog_checks,
          [ check_theory/0,
            check_program/1,          % +Program
            theory_problems/1,        % -Problems
            program_problems/2        % +Program, -Problems
          ]).
:- use_module(library(lists), [member/2]).
:- use_module(theory).

/** <module> What is wrong with a theory or a program, before it runs

A problem is problem(Kind, File, Line, What); Kind is `error` or `warning`.
*/

%!  check_theory is det.
%
%   Print what is wrong with the current theory.
%
%   @error golog(reported) if any of it is an error

check_theory :-
    theory_problems(Problems),
    reported(Problems).

%!  check_program(+Program) is det.
%
%   @error golog(reported) if Program calls what the theory does not have

check_program(Program) :-
    program_problems(Program, Problems),
    reported(Problems).

reported(Problems) :-
    forall(member(problem(Kind, File, Line, What), Problems),
           print_message(Kind, golog(problem(File, Line, What)))),
    (   member(problem(error, _, _, _), Problems)
    ->  throw(error(golog(reported), _))
    ;   true
    ).

%!  theory_problems(-Problems) is det.

theory_problems(Problems) :-
    current_theory(Theory),
    findall(Problem, theory_problem(Theory, Problem), Problems0),
    sort(2, @=<, Problems0, Problems1),
    sort(0, @<, Problems1, Problems).

theory_problem(Theory, problem(Kind, File, Line, What)) :-
    theory_module(Theory, Module),
    axiom(Module, Head, Ref),
    wrong(Head, Theory, Kind, What),
    place(Ref, File, Line).
theory_problem(Theory, problem(Kind, File, Line, What)) :-
    theory_module(Theory, Module),
    clause(Module:proc(Name, Body), _, Ref),
    wrong_part(Body, Name, Theory, Kind, What),
    place(Ref, File, Line).
theory_problem(Theory, problem(warning, File, Line, no_poss(A))) :-
    theory_module(Theory, Module),
    clause(Module:prim_action(A0), _, Ref),
    nonvar(A0),
    generalised(A0, A),
    \+ clause(Module:poss(A, _), _),
    place(Ref, File, Line).
theory_problem(Theory, problem(warning, File, Line, no_initial(F))) :-
    theory_module(Theory, Module),
    clause(Module:fun_fluent(F0), _, Ref),
    nonvar(F0),
    generalised(F0, F),
    \+ clause(Module:initially(F, _), _),
    \+ sensed_template(Theory, F),
    place(Ref, File, Line).

axiom(Module, Head, Ref) :-
    member(Head, [ poss(_, _), causes_val(_, _, _, _), causes_true(_, _, _),
                   causes_false(_, _, _), senses(_, _), senses(_, _, _, _, _),
                   initially(_, _) ]),
    clause(Module:Head, _, Ref).

place(Ref, File, Line) :-
    (   clause_property(Ref, file(File)),
        clause_property(Ref, line_count(Line))
    ->  true
    ;   File = '?', Line = 0
    ).

generalised(T, G) :-
    callable(T),
    functor(T, Name, Arity, Type),
    functor(G, Name, Arity, Type).

wrong(poss(A, _), T, error, unknown_action(poss, A)) :-
    unknown_action(T, A).
wrong(causes_val(A, _, _, _), T, error, unknown_action(effect, A)) :-
    unknown_action(T, A).
wrong(causes_val(_, F, _, _), T, error, unknown_fluent(effect, F)) :-
    unknown_fluent(T, F).
wrong(causes_true(A, _, _), T, error, unknown_action(effect, A)) :-
    unknown_action(T, A).
wrong(causes_true(_, F, _), T, error, unknown_fluent(effect, F)) :-
    unknown_fluent(T, F).
wrong(causes_false(A, _, _), T, error, unknown_action(effect, A)) :-
    unknown_action(T, A).
wrong(causes_false(_, F, _), T, error, unknown_fluent(effect, F)) :-
    unknown_fluent(T, F).
wrong(senses(A, _), T, error, unknown_action(sensing, A)) :-
    unknown_action(T, A).
wrong(senses(_, F), T, error, unknown_fluent(sensing, F)) :-
    unknown_fluent(T, F).
wrong(senses(A, _, _, _, _), T, error, unknown_action(sensing, A)) :-
    unknown_action(T, A).
wrong(senses(_, _, F, _, _), T, error, unknown_fluent(sensing, F)) :-
    unknown_fluent(T, F).
wrong(initially(F, _), T, error, unknown_fluent(initial, F)) :-
    unknown_fluent(T, F).

unknown_action(Theory, A) :-
    callable(A),
    \+ A = set(_), \+ A = unset(_), \+ A = sim(_),
    generalised(A, G),
    \+ action_template(Theory, G, _).

unknown_fluent(Theory, F) :-
    callable(F),
    \+ F = (_,_),
    generalised(F, G),
    \+ fluent_template(Theory, G, _).

%!  program_problems(+Program, -Problems) is det.

program_problems(Program, Problems) :-
    current_theory(Theory),
    findall(problem(Kind, program, 0, What),
            wrong_part(Program, program, Theory, Kind, What),
            Problems).

% A procedure whose body is a formula is an abbreviation; only bodies that are
% certainly programs are looked into.
wrong_part(Program, In, Theory, error, unknown_call(In, Call)) :-
    ( In == program -> true ; is_program(Program) ),
    called(Program, Call),
    callable(Call),
    generalised(Call, G),
    \+ action_template(Theory, G, _),
    theory_module(Theory, Module),
    \+ clause(Module:proc(G, _), _).

is_program(P) :-
    nonvar(P),
    (   P = [_|_]
    ;   construct(P, _)
    ;   P = ?(_)
    ).

%   called(+Program, -Call): Call stands where an action or a procedure must.

called(P, _) :-
    var(P),
    !,
    fail.
called([], _) :-
    !,
    fail.
called([E|L], Call) :-
    !,
    (   called(E, Call)
    ;   called(L, Call)
    ).
called(P, _) :-
    leaf(P),
    !,
    fail.
called(P, Call) :-
    construct(P, Parts),
    !,
    is_list(Parts),
    member(E, Parts),
    called(E, Call).
called(P, P).

leaf(?(_)).
leaf(??(_)).
leaf(wait).
leaf(abort).
leaf(commit).
leaf(stop_interrupts).
leaf(set(_)).
leaf(unset(_)).
leaf(abort(_)).

construct(ndet(E, F), [E, F]).
construct(wndet(E, F), [E, F]).
construct(rndet(E, F), [E, F]).
construct(if(_, E), [E]).
construct(if(_, E, F), [E, F]).
construct(while(_, E), [E]).
construct(star(E), [E]).
construct(star(E, _), [E]).
construct(pi(_, E), [E]).
construct(pi(_, _, E), [E]).
construct(rpi(_, E), [E]).
construct(rpi(_, _, E), [E]).
construct(for(_, _, E), [E]).
construct(conc(E, F), [E, F]).
construct(pconc(E, F), [E, F]).
construct(iconc(E), [E]).
construct(rconc(E, F), [E, F]).
construct(rconc(Es), Es).
construct(rrobin(Es), Es).
construct(sync(Es), Es).
construct(interrupt(_, E), [E]).
construct(interrupt(_, _, E), [E]).
construct(prioritized_interrupts(Es), Es).
construct(gexec(_, E), [E]).
construct(goal(_, E, _, F), [E, F]).
construct(atomic(E), [E]).
construct(time(E, _), [E]).
construct(ttime(E, _), [E]).
construct(search(E), [E]).
construct(search(E, _), [E]).
