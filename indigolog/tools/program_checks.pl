:- module(indigolog_program_checks,
          [ program_problem/5,        % +Program, +In, +Theory, -Kind, -What
            formula_problem/5,        % +Formula, +In, +Theory, -Kind, -What
            body_problem/5,           % +Body, +In, +Theory, -Kind, -What
            unguarded_call/3,         % +Body, +Theory, -Call
            near_miss/3               % +Theory, +Term, -Indicator
          ]).
:- use_module(library(apply), [maplist/2]).
:- use_module(library(lists), [append/2, list_to_set/2, member/2, memberchk/2]).
:- use_module(library(occurs), [sub_term/2]).
:- use_module('../language/binding').
:- use_module('../language/formula', [meaning/3]).
:- use_module('../language/semantics', [construct/2, program_part/2]).
:- use_module('../language/theory').

/** <module> What is wrong inside programs and formulas

Parts that are unbound until they run are not looked into.  In, where a part stands,
is in(Label, Names): Names are the variables that constructs around it may bind.
*/

%!  body_problem(+Body, +In, +Theory, -Kind, -What) is nondet.
%
%   The body of proc/2 is a program, or a formula that it abbreviates.

body_problem(Body, In, Theory, Kind, What) :-
    (   var(Body)
    ->  fail
    ;   is_formula(Body, Theory)
    ->  formula_problem(Body, In, Theory, Kind, What)
    ;   program_problem(Body, In, Theory, Kind, What)
    ).

is_formula(P, Theory) :-
    callable(P),
    \+ is_list(P),
    (   connective(P, _, _)
    ->  true
    ;   fluent_template(Theory, P, _)
    ->  true
    ;   \+ construct(P, _),
        \+ action_template(Theory, P, _),
        \+ called_procedure(Theory, P),
        goal_exists(P, Theory)
    ).

%!  program_problem(+Program, +In, +Theory, -Kind, -What) is nondet.

program_problem(E, In, Theory, Kind, What) :-
    nonvar(E),
    (   construct(E, Parts)
    ->  (   member(Part, Parts),
            part_problem(Part, In, Theory, Kind, What)
        ;   unused_variable(E, In, Kind, What)
        )
    ;   callable(E)
    ->  In = in(_, Names),
        \+ memberchk(E, Names),           % it stands for a program that is picked
        (   called_procedure(Theory, E)
        ->  no_clause(E, In, Theory),
            Kind = warning,
            What = no_clause(In, E)
        ;   action_template(Theory, E, _)
        ->  no_instance(E, In, Theory),
            Kind = warning,
            What = no_instance(In, E)
        ;   Kind = error,
            What = unknown_call(In, E)
        )
    ;   Kind = error,
        What = no_program(In, E)
    ).

% An action with constant arguments that is not among the declared ones.
no_instance(A, In, Theory) :-
    constant(A, In, Theory),
    theory_module(Theory, Module),
    \+ catch(Module:prim_action(A), _, true),
    \+ catch(Module:exog_action(A), _, true).

% A call that the head of no procedure matches.
no_clause(E, In, Theory) :-
    constant(E, In, Theory),
    theory_module(Theory, Module),
    \+ clause(Module:proc(E, _), _).

% Term is the same whatever the values of fluents and variables.
constant(Term, in(_, Names), Theory) :-
    ground(Term),
    \+ ( sub_term(T, Term),
         callable(T),
         ( memberchk(T, Names) ; fluent_template(Theory, T, _) ) ).

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

domain_problem(V, In, Theory, Kind, What) :-
    nonvar(V),
    (   is_list(V)
    ->  member(V0, V),
        domain_problem(V0, In, Theory, Kind, What)
    ;   V = (_, D),
        nonvar(D),
        \+ is_list(D),
        Kind = error,
        (   callable(D)
        ->  \+ domain_exists(D, Theory),
            \+ fluent_template(Theory, D, _)
        ;   true
        ),
        What = no_domain(In, D)
    ).

domain_exists(D, Theory) :-
    D =.. [Name|Args],
    append([[Name], Args, [_]], Parts),
    Goal =.. Parts,
    goal_exists(Goal, Theory).

goal_exists(Goal, Theory) :-
    theory_module(Theory, Module),
    (   predicate_property(Module:Goal, visible)
    ->  true
    ).

% A variable that is bound and then not used is a slip of the pen.
unused_variable(E, In, warning, unused(In, Name, V)) :-
    binder(E, V0, Body),
    functor(E, Name, _),
    bound_variables(V0, Vs),
    member(V, Vs),
    atom(V),
    \+ ( sub_term(T, Body), T == V ).

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

%!  formula_problem(+Formula, +In, +Theory, -Kind, -What) is nondet.

formula_problem(P, In, Theory, Kind, What) :-
    nonvar(P),
    (   connective(P, Ps, Terms)
    ->  (   member(Q, Ps),
            formula_problem(Q, In, Theory, Kind, What)
        ;   member(T, Terms),
            term_problem(T, In, Theory, Kind, What)
        ;   comparison(P),
            member(T, Terms),
            number_problem(T, In, Theory, Kind, What)
        ;   unused_variable(P, In, Kind, What)
        ;   ( P = some(V, _) ; P = all(V, _) ),
            domain_problem(V, In, Theory, Kind, What)
        )
    ;   \+ callable(P)
    ->  Kind = error,
        What = no_formula(In, P)
    ;   fluent_template(Theory, P, _)
    ->  argument_problem(P, In, Theory, Kind, What)
    ;   called_procedure(Theory, P)
    ->  fail
    ;   goal_exists(P, Theory)
    ->  argument_problem(P, In, Theory, Kind, What)
    ;   Kind = error,
        What = unknown_formula(In, P)
    ).

% connective(+Formula, -Formulas, -Terms): Formula begins with a connective, and these are
% what its truth depends on.
connective(P, Ps, Terms) :-
    (   meaning(P, _, Goal)
    ->  asked(Goal, Ps0, [], Terms0, []),
        list_to_set(Ps0, Ps),
        list_to_set(Terms0, Terms)
    ;   ( P = and(L) ; P = or(L) ),
        \+ is_list(L),                    % not known before it runs
        Ps = [], Terms = []
    ).

% asked(+Goal, -Formulas, ?Formulas1, -Terms, ?Terms1)
asked(true_in(P, _), Ps, Ps1, Ts, Ts1) => Ps = [P|Ps1], Ts = Ts1.
asked(instance(_, P, _, _), Ps, Ps1, Ts, Ts1) => Ps = [P|Ps1], Ts = Ts1.
asked(known(P, _), Ps, Ps1, Ts, Ts1) => Ps = [P|Ps1], Ts = Ts1.
asked(known_whether(P, _), Ps, Ps1, Ts, Ts1) => Ps = [P|Ps1], Ts = Ts1.
asked(value_in(T, _, _), Ps, Ps1, Ts, Ts1) => Ps = Ps1, Ts = [T|Ts1].
asked(findall(_, G, _), Ps, Ps1, Ts, Ts1) => asked(G, Ps, Ps1, Ts, Ts1).
asked(aggregate_all(_, G, _), Ps, Ps1, Ts, Ts1) => asked(G, Ps, Ps1, Ts, Ts1).
asked(G, Ps, Ps1, Ts, Ts1), control(G, Gs) => asked_of_each(Gs, Ps, Ps1, Ts, Ts1).
asked(_, Ps, Ps1, Ts, Ts1) => Ps = Ps1, Ts = Ts1.

asked_of_each([], Ps, Ps, Ts, Ts).
asked_of_each([G|Gs], Ps, Ps1, Ts, Ts1) :-
    asked(G, Ps, Ps0, Ts, Ts0),
    asked_of_each(Gs, Ps0, Ps1, Ts0, Ts1).

control((A, B), [A, B]).
control((A ; B), [A, B]).
control((A -> B), [A, B]).
control(\+ A, [A]).
control(once(A), [A]).

comparison(P) :-
    compound(P),
    P =.. [Name, _, _],
    memberchk(Name, [<, >, =<, >=, =:=, =\=]).

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

% An atom that is neither a fluent nor a variable of a construct around it.
number_problem(T, In, Theory, error, no_number(In, T)) :-
    atom(T),
    In = in(_, Variables),
    \+ memberchk(T, Variables),
    \+ fluent_template(Theory, T, _),
    \+ current_arithmetic_function(T).

%!  unguarded_call(+Body, +Theory, -Call) is nondet.
%
%   Call is a procedure call that Body may come to before an action or a test.

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
