:- module(indigolog_formula_checks,
          [ formula_problem/5,        % +Formula, +In, +Theory, -Kind, -What
            undeclared_instance/3,    % +Fluent, +In, +Theory
            domain_problem/5,         % +Variables, +In, +Theory, -Kind, -What
            unused_variable/4,        % +Construct, +In, -Kind, -What
            constant/3,               % +Term, +In, +Theory
            known_beforehand/2,       % +Term, +Clause
            known_within/2            % +Term, +Around
          ]).
/** <module> What is wrong inside formulas

In, where a part stands, is in(Label, Names): Names are the variables that constructs around
it may bind.
*/

:- use_module(library(lists), [append/2, member/2, memberchk/2]).
:- use_module(library(occurs), [sub_term/2]).
:- use_module(formula_parts, [connective/3, goal_exists/2, procedure_kind/3]).
:- use_module('../language/binding').
:- use_module('../language/theory').

%!  formula_problem(+Formula, +In, +Theory, -Kind, -What) is nondet.

formula_problem(P, In, Theory, Kind, What) :-
    nonvar(P),
    \+ stands_for_another(P, In),
    (   connective(P, Ps, Terms)
    ->  (   member(Q, Ps),
            formula_problem(Q, In, Theory, Kind, What)
        ;   member(T, Terms),
            \+ compared_record(T, P, In, Theory),
            term_problem(T, In, Theory, Kind, What)
        ;   calculated(P, Ts),
            member(T, Ts),
            number_problem(T, In, Theory, Kind, What)
        ;   unused_variable(P, In, Kind, What)
        ;   result_problem(P, In, Theory, What),
            Kind = warning
        ;   P = (X = Y),
            equality_problem(X, Y, In, Theory, What),
            Kind = warning
        ;   ( P = some(V, _) ; P = all(V, _) ),
            domain_problem(V, In, Theory, Kind, What)
        )
    ;   ( \+ callable(P) ; P == [] ; P = [_|_] )
    ->  Kind = error,
        What = no_formula(In, P)
    ;   fluent_template(Theory, P, _)
    ->  term_problem(P, In, Theory, Kind, What)
    ;   called_procedure(Theory, P)
    ->  procedure_kind(P, Theory, program),
        Kind = error,
        What = procedure_tested(In, P)
    ;   goal_exists(P, Theory)
    ->  argument_problem(P, In, Theory, Kind, What)
    ;   Kind = error,
        What = unknown_formula(In, P)
    ).

% A construct that binds the name puts a formula, or a domain, in its place.
stands_for_another(Name, in(_, Names)) :-
    memberchk(Name, Names).

% Term, a side of the equality P, has the name of a fluent and another number of arguments, as values have, too; it is
% compared with a fluent or a variable, and not with a constant.
compared_record(Term, X = Y, In, Theory) :-
    ( Term == X -> Other = Y ; Other = X ),
    compound(Term),
    \+ fluent_template(Theory, Term, _),
    \+ constant(Other, In, Theory),
    \+ ( arg(_, Term, A), term_problem(A, In, Theory, _, _) ).

% Neither side is, or has in it, anything that can change; or a relational fluent is
% compared with what is no truth value.
equality_problem(X, Y, In, Theory, What) :-
    (   constant(X = Y, In, Theory)
    ->  \+ term_problem(X = Y, In, Theory, error, _),
        What = constant_equality(In, X = Y)
    ;   member(F-V, [X-Y, Y-X]),
        callable(F),
        fluent_template(Theory, F, rel),
        constant(V, In, Theory),
        \+ memberchk(V, [true, false])
    ->  What = never_equal(In, F, V)
    ).

% calculated(+Formula, -Terms): the sides of a comparison of numbers, or what is/2 evaluates.
calculated(P, Ts) :-
    compound(P),
    P =.. [Name|Sides],
    (   memberchk(Name, [<, >, =<, >=, =:=, =\=])
    ->  Ts = Sides
    ;   Name == (is)
    ->  Sides = [_|Ts]
    ).

argument_problem(P, In, Theory, Kind, What) :-
    compound(P),
    arg(_, P, A),
    term_problem(A, In, Theory, Kind, What).

% A term that has the name of a fluent and another number of arguments.
term_problem(T, In, Theory, error, fluent_arity(In, S, Name/Arity)) :-
    sub_term(S, T),
    compound(S),
    \+ S = [_|_],
    \+ fluent_template(Theory, S, _),
    theory_module(Theory, Module),
    functor(S, Name, _),
    Module:'$fluent'(F, _),
    functor(F, Name, Arity),
    \+ action_template(Theory, S, _).

term_problem(T, In, Theory, warning, undeclared_instance(In, F)) :-
    sub_term(F, T),
    compound(F),
    undeclared_instance(F, In, Theory).

%!  undeclared_instance(+Fluent, +In, +Theory) is semidet.
%
%   Fluent has the functor of a declared fluent and constant arguments for which it is not
%   declared.

undeclared_instance(F, In, Theory) :-
    fluent_template(Theory, F, _),
    F =.. [_|Arguments],
    constant(Arguments, In, Theory),
    \+ catch(declared_fluent(Theory, F), _, true).

% An atom in the place of a result, which is none.
result_problem(P, In, Theory, no_result(In, P, R)) :-
    ( P = findall(_, _, R) ; P = aggregate_all(_, _, R) ; P = (R is _) ),
    atom(R),
    R \== [],
    In = in(_, Names),
    \+ memberchk(R, Names),
    \+ fluent_template(Theory, R, _).

% An atom that is neither a fluent nor a variable of a construct around it.
number_problem(T, In, Theory, error, no_number(In, T)) :-
    atom(T),
    In = in(_, Variables),
    \+ memberchk(T, Variables),
    \+ fluent_template(Theory, T, _),
    \+ current_arithmetic_function(T).
number_problem(T, In, Theory, Kind, What) :-
    compound(T),
    \+ fluent_template(Theory, T, _),
    current_arithmetic_function(T),
    arg(_, T, A),
    number_problem(A, In, Theory, Kind, What).

%!  domain_problem(+Variables, +In, +Theory, -Kind, -What) is nondet.

domain_problem(V, In, Theory, Kind, What) :-
    nonvar(V),
    (   is_list(V)
    ->  member(V0, V),
        domain_problem(V0, In, Theory, Kind, What)
    ;   ( V = (V0, _) -> true ; V0 = V ),
        \+ may_be_bound(V0),
        Kind = error,
        What = no_variable(In, V0)
    ;   V = (_, D),
        nonvar(D),
        \+ is_list(D),
        \+ stands_for_another(D, In),
        Kind = error,
        (   callable(D)
        ->  \+ domain_exists(D, Theory),
            \+ fluent_template(Theory, D, _)
        ;   true
        ),
        What = no_domain(In, D)
    ).

% A Prolog variable, or an atom that stands for one; in random order.
may_be_bound(V) :-
    (   ( var(V) ; atom(V) )
    ->  true
    ;   V = r(V0),
        may_be_bound(V0)
    ).

domain_exists(D, Theory) :-
    D =.. [Name|Args],
    append([[Name], Args, [_]], Parts),
    Goal =.. Parts,
    goal_exists(Goal, Theory).

%!  unused_variable(+Construct, +In, -Kind, -What) is nondet.
%
%   A variable that is bound and then not used is a slip of the pen.
unused_variable(E, In, warning, unused(In, Name, V)) :-
    binder(E, V0, Body),
    functor(E, Name, _),
    bound_variables(V0, Vs),
    member(V, Vs),
    atom(V),
    \+ ( sub_term(T, Body), T == V ).

%!  constant(+Term, +In, +Theory) is semidet.
%
%   Term is the same whatever the values of fluents and variables.
constant(Term, in(_, Names), Theory) :-
    ground(Term),
    \+ ( sub_term(T, Term),
         callable(T),
         ( memberchk(T, Names) ; fluent_template(Theory, T, _) ) ).

%!  known_beforehand(+Term, +Clause) is semidet.
%
%   Term, which stands in Clause, is the same whatever the values of fluents and of variables that constructs there bind.

known_beforehand(Term, Clause) :-
    bound_names(Clause, Names),
    known_among(Term, Names).

%!  known_within(+Term, +Around) is semidet.
%
%   The same of a Term around which there are these constructs (program_parts.pl).

known_within(Term, Around) :-
    names_bound_around(Around, Names),
    known_among(Term, Names).

known_among(Term, Names) :-
    current_theory(Theory),
    constant(Term, in(_, Names), Theory).
