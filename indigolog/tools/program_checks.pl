:- module(indigolog_program_checks,
          [ program_problem/5,        % +Program, +In, +Theory, -Kind, -What
            body_problem/5,           % +Body, +In, +Theory, -Kind, -What
            functional_fluent/2,      % +Theory, +Term
            recursion/5,              % +Name, +Body, +Theory, -Kind, -Path
            near_miss/3               % +Theory, +Term, -Indicator
          ]).
/** <module> What is wrong inside programs

Parts that are unbound until they run are not looked into.  In, where a part stands,
is in(Label, Names): Names are the variables that constructs around it may bind.
*/

:- use_module(library(apply), [maplist/2]).
:- use_module(library(lists), [member/2, memberchk/2]).
:- use_module(formula_checks, [constant/3, domain_problem/5, formula_problem/5, undeclared_instance/3, unused_variable/4]).
:- use_module(formula_parts, [connective/3, is_formula/2, procedure_kind/3]).
:- use_module('../language/semantics', [construct/2, program_part/2]).
:- use_module('../language/theory').
:- use_module('../search/search_options', [search_option/1]).

%!  body_problem(+Body, +In, +Theory, -Kind, -What) is nondet.
%
%   The body of proc/2 is a program, or a formula that it abbreviates.

body_problem(Body, In, Theory, Kind, What) :-
    (   var(Body)
    ->  fail
    ;   stands_for_formula(Body, Theory)
    ->  formula_problem(Body, In, Theory, Kind, What)
    ;   program_problem(Body, In, Theory, Kind, What)
    ).

stands_for_formula(E, Theory) :-
    (   is_formula(E, Theory)
    ->  true
    ;   called_procedure(Theory, E)
    ->  procedure_kind(E, Theory, formula)
    ).

%!  program_problem(+Program, +In, +Theory, -Kind, -What) is nondet.

program_problem(E, In, Theory, Kind, What) :-
    nonvar(E),
    (   construct(E, Parts)
    ->  (   member(Part, Parts),
            part_problem(Part, In, Theory, Kind, What)
        ;   unused_variable(E, In, Kind, What)
        ;   argument_problem(E, In, What),
            Kind = error
        ;   assignment_problem(E, In, Theory, Kind, What)
        ;   E == commit,
            Kind = error,
            What = no_commit(In)
        ;   E = while(_, Body),
            idle(Body),
            Kind = warning,
            ( tests(Body) -> What = idle_loop(In, E) ; What = empty_loop(In, E) )
        )
    ;   callable(E)
    ->  In = in(_, Names),
        \+ memberchk(E, Names),           % it stands for a program that is picked
        (   called_procedure(Theory, E)
        ->  (   procedure_kind(E, Theory, formula)
            ->  Kind = error,
                What = formula_run(In, E)
            ;   no_clause(E, In, Theory),
                Kind = warning,
                What = no_clause(In, E)
            )
        ;   action_template(Theory, E, _)
        ->  Kind = warning,
            (   \+ action_template(Theory, E, prim)
            ->  What = exogenous_step(In, E)
            ;   no_instance(E, In, Theory),
                What = no_instance(In, E)
            )
        ;   Kind = error,
            What = unknown_call(In, E)
        )
    ;   Kind = error,
        What = no_program(In, E)
    ).

% An argument that is no program and no formula, and that no construct may put in place of an atom.
argument_problem(E, in(Label, Names), What) :-
    ( E = star(_, A) ; E = achieve(_, A) ; E = achieve(_, A, _) ),
    nonvar(A),
    \+ integer(A),
    \+ memberchk(A, Names),
    What = no_count(in(Label, Names), E, A).
argument_problem(E, in(Label, Names), What) :-
    ( E = time(_, A) ; E = ttime(_, A) ),
    nonvar(A),
    \+ ( number(A), A >= 0 ),
    \+ memberchk(A, Names),
    What = no_seconds(in(Label, Names), E, A).
argument_problem(E, in(Label, Names), What) :-
    ( E = case(_, A) ; E = search(_, A), search_option(A) ; construct(E, [programs(A)]) ),
    nonvar(A),
    \+ A = [_|_],
    \+ is_list(A),
    \+ memberchk(A, Names),
    What = no_list(in(Label, Names), E, A).

% The fluent of set(F), unset(F) or abort(F), where it stands there already.
assignment_problem(E, In, Theory, Kind, What) :-
    ( assignment(E, Theory) -> arg(1, E, F) ; E = abort(F) ),
    nonvar(F),
    In = in(_, Names),
    \+ memberchk(F, Names),
    (   \+ ( callable(F), fluent_template(Theory, F, _) )
    ->  Kind = error,
        What = unknown_assigned(In, E, F)
    ;   functional_fluent(Theory, F)
    ->  Kind = error,
        What = functional_assigned(In, E, F)
    ;   undeclared_instance(F, In, Theory),
        Kind = warning,
        What = undeclared_instance(In, F)
    ).

%!  functional_fluent(+Theory, +Term) is semidet.
%
%   Term has the functor of a fluent that is declared functional only: prim_fluent/1 leaves it open.

functional_fluent(Theory, F) :-
    theory_module(Theory, Module),
    generalised(F, G),
    clause(Module:fun_fluent(G), _),
    \+ clause(Module:rel_fluent(G), _),
    !.

% An action with constant arguments that is not among the declared ones.
no_instance(A, In, Theory) :-
    constant(A, In, Theory),
    theory_module(Theory, Module),
    \+ catch(Module:prim_action(A), _, true),
    \+ catch(Module:exog_action(A), _, true).

% No step of the program is an action, whatever happens.
idle(E) :-
    nonvar(E),
    construct(E, _),
    functor(E, Name, _),
    memberchk(Name, ['[|]', [], ?, if, ndet, wndet, rndet, while, star, pi, rpi, conc, pconc]),
    E \== ?(wait_exog_action),
    \+ ( program_part(E, Part), \+ idle(Part) ).

% Of an idle program: without a test in it, it may always end as it stands.
tests(?(_)).
tests(E) :-
    program_part(E, Part),
    tests(Part),
    !.

% A call that the head of no procedure matches.
no_clause(E, In, Theory) :-
    constant(E, In, Theory),
    theory_module(Theory, Module),
    \+ clause(Module:proc(E, _), _).

part_problem(program(E), In, Theory, Kind, What) :-
    program_problem(E, In, Theory, Kind, What).
part_problem(programs(Es), In, Theory, Kind, What) :-
    is_list(Es),
    member(E, Es),
    program_problem(E, In, Theory, Kind, What).
part_problem(formula(P), In, Theory, Kind, What) :-
    formula_problem(P, In, Theory, Kind, What).
part_problem(variable(V), In, Theory, Kind, What) :-
    domain_problem(V, In, Theory, Kind, What).

%!  near_miss(+Theory, +Term, -Indicator) is semidet.
%
%   An action, fluent, procedure or construct has the name of Term, and another
%   number of arguments.

near_miss(Theory, Term, Name/Arity) :-
    functor(Term, Name, Arity0),
    (   action_template(Theory, G, _)
    ;   theory_module(Theory, Module),
        (   Module:'$fluent'(G, _)
        ;   clause(Module:proc(G, _), _), nonvar(G)
        )
    ;   construct(G, _)
    ),
    functor(G, Name, Arity),
    Arity =\= Arity0,
    !.

%!  recursion(+Name, +Body, +Theory, -Kind, -Path) is nondet.
%
%   The procedure Name may come from Body, a `program` or a `formula`, back to itself before an action or a test, by the
%   calls in Path.

recursion(Name, Body, Theory, Kind, Path) :-
    ( stands_for_formula(Body, Theory) -> Kind = formula ; Kind = program ),
    unguarded_call(Body, Theory, Call),
    comes_back(Call, Name, Theory, [Name], Path).

% comes_back(+Call, +Name, +Theory, +Before, -Path): without an action in between,
% and through procedures whose clauses have no condition.
comes_back(Call, Name, _, Before, [Call|Before]) :-
    functor(Call, F, N),
    functor(Name, F, N),
    !.
comes_back(Call, Name, Theory, Before, Path) :-
    \+ ( member(Earlier, Before),
         functor(Earlier, F, N),
         functor(Call, F, N) ),
    theory_module(Theory, Module),
    clause(Module:proc(Call, Body), true),
    unguarded_call(Body, Theory, Next),
    comes_back(Next, Name, Theory, [Call|Before], Path).

% unguarded_call(+Body, +Theory, -Call): a procedure call that Body may come to before an action or a test.

unguarded_call(E, Theory, Call) :-
    nonvar(E),
    (   E = [F|L]
    ->  (   unguarded_call(F, Theory, Call)
        ;   may_be_empty(F),
            unguarded_call(L, Theory, Call)
        )
    ;   is_formula(E, Theory)
    ->  formula_call(E, Theory, Call)
    ;   construct(E, _)
    ->  \+ E = ?(_),
        program_part(E, F),
        unguarded_call(F, Theory, Call)
    ;   called_procedure(Theory, E),
        Call = E
    ).

formula_call(P, Theory, Call) :-
    nonvar(P),
    (   connective(P, Ps, _)
    ->  member(Q, Ps),
        formula_call(Q, Theory, Call)
    ;   callable(P),
        called_procedure(Theory, P),
        Call = P
    ).

may_be_empty(E) :-
    nonvar(E),
    (   E == []
    ->  true
    ;   E = [_|_]
    ->  maplist(may_be_empty, E)
    ;   E = star(_) ; E = star(_, _) ; E = while(_, _) ; E = if(_, _) ; E = iconc(_)
    ).
