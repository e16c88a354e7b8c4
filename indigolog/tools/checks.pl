:- module(indigolog_checks,
          [ check_theory/0,
            check_theory_once/0,
            check_program/1,          % +Program
            theory_problems/1,        % -Problems
            program_problems/2        % +Program, -Problems
          ]).
/** <module> What is wrong with a theory or a program, before it runs

A problem is problem(Kind, File, Line, What); Kind is `error` or `warning`.
*/

:- use_module(library(apply), [maplist/2]).
:- use_module(library(lists), [member/2, memberchk/2]).
:- use_module(library(solution_sequences), [limit/2]).
:- use_module('../language/binding', [bound_names/2]).
:- use_module(captured_values, [captured_value/4, captured_value/5]).
:- use_module(formula_checks, [formula_problem/5, undeclared_instance/3]).
:- use_module(formula_parts, [condition/3]).
:- use_module(loop_variables, [kept_variable/3]).
:- use_module(misspelt_axioms, [misspelt_axiom/3]).
:- use_module(negated_variables, [negated_variable/3]).
:- use_module(program_checks).
:- use_module(undefined_calls, [undefined_call/3]).
:- use_module(unused_clauses, [unused_clause/4]).
:- use_module('../language/semantics', [construct/2]).
:- use_module('../language/theory').

%!  check_theory is det.
%
%   Print what is wrong with the current theory.
%
%   @error golog(reported) if any of it is an error

check_theory :-
    theory_problems(Problems),
    reported(Problems).

:- dynamic checked/1.                 % the module of a theory

%!  check_theory_once is det.
%
%   As check_theory/0, unless it has found no error since the theory was loaded.

check_theory_once :-
    current_theory(Theory),
    theory_module(Theory, Module),
    (   checked(Module)
    ->  true
    ;   check_theory,
        assertz(checked(Module))
    ).

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
%
%   In the order of the files.

theory_problems(Problems) :-
    current_theory(Theory),
    theory_module(Theory, Module),
    findall(File-Line-problem(Kind, File, Line, What),
            ( theory_problem(Theory, Module, Kind, What, Ref),
              place(Ref, File, Line) ),
            Found0),
    sort(Found0, Found),
    findall(Problem, member(_-Problem, Found), Problems).

place(Ref, File, Line) :-
    (   clause_property(Ref, file(File0)),
        clause_property(Ref, line_count(Line0))
    ->  File = File0, Line = Line0
    ;   File = '?', Line = 0
    ).

% theory_problem(+Theory, +Module, -Kind, -What, -Ref): of a theory in Module; Ref is the clause that it is in.

theory_problem(Theory, Module, Kind, What, Ref) :-
    speaks_of(Head, _, _, _),
    clause(Module:Head, _, Ref),
    axiom_problem(Head, Theory, Kind, What).
theory_problem(Theory, Module, Kind, What, Ref) :-
    condition(Head, Label, P),
    clause(Module:Head, _, Ref),
    bound_names(P, Names),
    formula_problem(P, in(Label, Names), Theory, Kind, What).
theory_problem(Theory, Module, Kind, What, Ref) :-
    clause(Module:proc(Name, Body), _, Ref),
    bound_names(Body, Names),
    body_problem(Body, in(Name, Names), Theory, Kind, What).
theory_problem(Theory, Module, warning, unknown_event(A), Ref) :-
    clause(Module:exog_occurs(A0), _, Ref),
    callable(A0),
    generalised(A0, A),
    \+ action_template(Theory, A, exog).
theory_problem(_, Module, warning, no_poss(A), Ref) :-
    clause(Module:prim_action(A0), _, Ref),
    nonvar(A0),
    generalised(A0, A),
    \+ clause(Module:poss(A, _), _).
theory_problem(Theory, Module, warning, What, Ref) :-
    member(F0-Head, [F-fun_fluent(F), F-prim_fluent(F)]),
    clause(Module:Head, Body, Ref),
    nonvar(F0),
    generalised(F0, G),
    \+ sensed_template(Theory, G),
    (   \+ clause(Module:initially(G, _), _)
    ->  What = no_initial(G)
    ;   once(( limit(1000, catch(Module:Body, _, fail)),
               ground(F0),
               \+ Module:initially(F0, _) )),
        What = no_initial_value(F0)
    ).
theory_problem(Theory, Module, warning, two_values(F, V, First), Ref) :-
    clause(Module:initially(F, V0), Body, Ref),
    ground(F),
    \+ uncertain_template(Theory, F),
    catch(Module:Body, _, fail),
    V = V0,
    once(Module:initially(F, First)),
    First \=@= V.
theory_problem(_, Module, warning, open_value(F, Shown), Ref) :-
    clause(Module:initially(F, V), Body, Ref),
    ground(F),
    once(( catch(Module:Body, _, fail), \+ ground(V) )),
    copy_term_nat(V, Shown),
    term_variables(Shown, Variables),
    maplist(=('$VAR'('_')), Variables).
theory_problem(_, Module, error, two_kinds(F), Ref) :-
    clause(Module:rel_fluent(F0), _, Ref),
    nonvar(F0),
    generalised(F0, F),
    member(Head, [fun_fluent(F), prim_fluent(F)]),
    clause(Module:Head, _),
    \+ \+ ( clause(Module:Head, _, Other), Other \== Ref ).
theory_problem(Theory, Module, warning, two_uses(Name), Ref) :-
    clause(Module:proc(Name, _), _, Ref),
    nonvar(Name),
    ( action_template(Theory, Name, prim) -> true ; fluent_template(Theory, Name, _) ).
theory_problem(_, Module, Kind, What, Ref) :-
    member(Head-A, [prim_action(A)-A, exog_action(A)-A, proc(A, _)-A]),
    clause(Module:Head, _, Ref),
    nonvar(A),
    generalised(A, G),
    (   Head \= proc(_, _),
        history_mark(G)
    ->  Kind = error, What = reserved(G)
    ;   Head \= exog_action(_),
        construct(G, _),
        \+ ( Head = prim_action(_), assigning(G) )
    ->  Kind = warning, What = hidden(G)
    ).
theory_problem(_, Module, error, axiom_arity(Name/Arity, Expected), Ref) :-
    current_predicate(Module:Name/Arity),
    \+ theory_predicate(Name/Arity),
    theory_predicate(Name/_),
    functor(Head, Name, Arity),
    \+ predicate_property(Module:Head, imported_from(_)),
    findall(Name/N, theory_predicate(Name/N), Expected),
    clause(Module:Head, _, Ref).
theory_problem(Theory, _, warning, captured_value(none, Name, clause(Where, Line)), Ref) :-
    captured_value(Theory, Ref, Name, Value),
    place(Ref, File, _),
    place(Value, File1, Line),
    ( File1 == File -> Where = same ; Where = File1 ).
theory_problem(_, Module, warning, unused_clause(in(Head, []), First), Ref) :-
    unused_clause(Module, Head, Ref, First).
theory_problem(_, Module, warning, misspelt(Name/Arity, Meant), Ref) :-
    misspelt_axiom(Module, Name/Arity, Meant),
    functor(Head, Name, Arity),
    once(clause(Module:Head, _, Ref)).
theory_problem(Theory, _, warning, undefined_call(PI), Ref) :-
    undefined_call(Theory, PI, Ref).
theory_problem(_, Module, warning, negated_variable(in(Label, []), V, Negation), Ref) :-
    ( condition(Head, Label, Term) ; Head = proc(Label, Term) ),
    clause(Module:Head, _, Ref),
    negated_variable(Term, V, Negation).
theory_problem(_, Module, warning, kept_variable(in(Name, []), Part), Ref) :-
    clause(Module:proc(Name, Body), Condition, Ref),
    once(kept_variable(Body, Name-Body-Condition, Part)).
theory_problem(Theory, Module, warning, recursion(Kind, Name, Path), Ref) :-
    clause(Module:proc(Name, Body), true, Ref),
    nonvar(Name),
    recursion(Name, Body, Theory, Kind, Path).

assigning(set(_)).
assigning(unset(_)).

% speaks_of(?Axiom, -Name, -Action, -Fluent): `none` where it does not.
speaks_of(poss(A, _), precondition, A, none).
speaks_of(causes_val(A, F, _, _), effect, A, F).
speaks_of(causes_true(A, F, _), effect, A, F).
speaks_of(causes_false(A, F, _), effect, A, F).
speaks_of(senses(A, F), sensing, A, F).
speaks_of(senses(A, _, F, _, _), sensing, A, F).
speaks_of(settles(A, _, F, _, _), sensing, A, F).
speaks_of(rejects(A, _, F, _, _), sensing, A, F).
speaks_of(sensing(A, _), sensing, A, none).
speaks_of(initially(F, _), initial, none, F).

axiom_problem(Axiom, Theory, Kind, What) :-
    speaks_of(Axiom, Name, A, F),
    (   unknown_action(Theory, A),
        (   called_procedure(Theory, A)
        ->  Kind = warning, What = axiom_of_procedure(Name, A)
        ;   Kind = error, What = unknown_action(Name, A)
        )
    ;   unknown_fluent(Theory, F),
        Kind = error,
        What = unknown_fluent(Name, F)
    ).
axiom_problem(Axiom, Theory, error, not_relational(F)) :-
    ( Axiom = causes_true(_, F, _) ; Axiom = causes_false(_, F, _) ),
    callable(F),
    functional_fluent(Theory, F).
axiom_problem(initially(F, V), Theory, error, not_boolean(F, V)) :-
    callable(F),
    nonvar(V),
    \+ memberchk(V, [true, false]),
    theory_module(Theory, Module),
    generalised(F, G),
    clause(Module:rel_fluent(G), _),
    \+ clause(Module:fun_fluent(G), _),
    !.

axiom_problem(Axiom, Theory, error, not_boolean(F, V)) :-
    ( Axiom = causes_val(_, F, V, _) ; Axiom = senses(_, _, F, V, _) ),
    callable(F),
    nonvar(V),
    \+ memberchk(V, [true, false]),
    fluent_template(Theory, F, Kind),
    Kind == rel.
axiom_problem(Axiom, Theory, warning, undeclared_instance(in(of(Name, Of), []), F)) :-
    speaks_of(Axiom, Name0, A, F),
    compound(F),
    ( A == none -> Name = 'initial value', Of = F ; Name = Name0, Of = A ),
    undeclared_instance(F, in(axiom, []), Theory).
axiom_problem(Axiom, Theory, warning, impossible_value(F, V)) :-
    ( Axiom = settles(_, _, F, V, _) ; Axiom = rejects(_, _, F, V, _) ),
    ground(F-V),
    theory_module(Theory, Module),
    \+ Module:initially(F, V),
    generalised(F, G),
    \+ clause(Module:causes_val(_, G, _, _), _).

unknown_action(Theory, A) :-
    callable(A),
    A \== none,
    \+ A = sim(_),
    generalised(A, G),
    \+ action_template(Theory, G, _).

unknown_fluent(Theory, F) :-
    callable(F),
    F \== none,
    \+ F = (_,_),
    generalised(F, G),
    \+ fluent_template(Theory, G, _).

%!  program_problems(+Program, -Problems) is det.

program_problems(Program, Problems) :-
    current_theory(Theory),
    bound_names(Program, Names),
    findall(problem(Kind, program, 0, What),
            (   program_problem(Program, in(program, Names), Theory, Kind, What)
            ;   Kind = warning,
                What = kept_variable(in(program, Names), Part),
                once(kept_variable(Program, Program, Part))
            ;   Kind = warning,
                What = captured_value(in(Where, Names), Name, Place),
                captured_value(Theory, Program, Where, Name, Value),
                ( Value == program -> Place = program ; Place = clause(File, Line), place(Value, File, Line) )
            ;   Kind = warning,
                What = negated_variable(in(program, Names), V, Negation),
                negated_variable(Program, V, Negation)
            ),
            Problems).
