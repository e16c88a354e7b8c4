:- module(indigolog_program_checks,
          [ program_problem/5,        % +Program, +In, +Theory, -Kind, -What
            formula_problem/5,        % +Formula, +In, +Theory, -Kind, -What
            body_problem/5,           % +Body, +In, +Theory, -Kind, -What
            unguarded_call/3,         % +Body, +Theory, -Call
            program_part/2,           % +Program, -Part
            near_miss/3               % +Theory, +Term, -Indicator
          ]).
:- use_module(library(apply), [maplist/2]).
:- use_module(library(lists), [append/2, member/2, memberchk/2]).
:- use_module(library(occurs), [sub_term/2]).
:- use_module('../language/binding').
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

%   construct(+Program, -Parts): the parts of a program of the language.

construct([], []).
construct([E|L], [program(E), program(L)]).
construct(?(P), Parts) :-
    (   P == wait_exog_action -> Parts = [] ; Parts = [formula(P)] ).
construct(??(P), [formula(P)]).
construct(Own, []) :- step(Own).
construct(branch(P), [formula(P)]).
construct(ndet(E, F), [program(E), program(F)]).
construct(wndet(E, F), [program(E), program(F)]).
construct(rndet(E, F), [program(E), program(F)]).
construct(if(P, E), [formula(P), program(E)]).
construct(if(P, E, F), [formula(P), program(E), program(F)]).
construct(while(P, E), [formula(P), program(E)]).
construct(star(E), [program(E)]).
construct(star(E, _), [program(E)]).
construct(pi(V, E), [variable(V), program(E)]).
construct(pi(V, D, E), [variable((V, D)), program(E)]).
construct(rpi(V, E), [variable(V), program(E)]).
construct(rpi(V, D, E), [variable((V, D)), program(E)]).
construct(for(V, D, E), [variable((V, D)), program(E)]).
construct(conc(E, F), [program(E), program(F)]).
construct(pconc(E, F), [program(E), program(F)]).
construct(iconc(E), [program(E)]).
construct(rconc(E, F), [program(E), program(F)]).
construct(rconc(Es), [programs(Es)]).
construct(rrobin(Es), [programs(Es)]).
construct(sync(Es), [programs(Es)]).
construct(interrupt(P, E), [formula(P), program(E)]).
construct(interrupt(V, P, E), [variable(V), formula(P), program(E)]).
construct(prioritized_interrupts(Es), [programs(Es)]).
construct(gexec(P, E), [formula(P), program(E)]).
construct(goal(P, E, Q, F), [formula(P), program(E), formula(Q), program(F)]).
construct(atomic(E), [program(E)]).
construct(time(E, _), [program(E)]).
construct(ttime(E, _), [program(E)]).
construct(search(E), [program(E)]).
construct(search(E, _), [program(E)]).
construct(searchc(E), [program(E)]).
construct(searchc(E, _), [program(E)]).
construct(achieve(P), [formula(P)]).
construct(achieve(P, _), [formula(P)]).
construct(achieve(P, _, _), [formula(P)]).
construct(case(_, Branches), [programs(Es)]) :-
    (   is_list(Branches)
    ->  findall(E, member(if(_, E), Branches), Es)
    ;   Es = []
    ).

step(wait).
step(abort).
step(commit).
step(stop_interrupts).
step(set(_)).
step(unset(_)).
step(sim(_)).
step(abort(_)).

%!  program_part(+Program, -Part) is nondet.
%
%   Part is a program that the construct Program is made of.

program_part(E, Part) :-
    construct(E, Parts),
    (   member(program(Part), Parts)
    ;   member(programs(Es), Parts),
        is_list(Es),
        member(Part, Es)
    ).

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
    ;   clause(construct(G, _), _), nonvar(G)
    ;   step(G)
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

connective(true, [], []).
connective(false, [], []).
connective(and(P, Q), [P, Q], []).
connective(and(Ps), Qs, []) :- listed(Ps, Qs).
connective((P, Q), [P, Q], []).
connective(or(P, Q), [P, Q], []).
connective(or(Ps), Qs, []) :- listed(Ps, Qs).
connective((P ; Q), [P, Q], []).
connective((P -> Q), [P, Q], []).
connective(neg(P), [P], []).
connective(\+ P, [P], []).
connective(impl(P, Q), [P, Q], []).
connective(equiv(P, Q), [P, Q], []).
connective(some(_, P), [P], []).
connective(some(_, _, P), [P], []).
connective(all(_, P), [P], []).
connective(all(_, _, P), [P], []).
connective(know(P), [P], []).
connective(kwhether(P), [P], []).
connective(done(_), [], []).
connective(once(P), [P], []).
connective(forall(P, Q), [P, Q], []).
connective(findall(_, P, _), [P], []).
connective(aggregate_all(_, P, _), [P], []).
connective(X = Y, [], [X, Y]).
connective(P, [], [X, Y]) :-
    compound(P),
    P =.. [Name, X, Y],
    arithmetic_comparison(Name).

listed(Ps, Qs) :-
    (   is_list(Ps) -> Qs = Ps ; Qs = [] ).

arithmetic_comparison(<).
arithmetic_comparison(>).
arithmetic_comparison(=<).
arithmetic_comparison(>=).
arithmetic_comparison(=:=).
arithmetic_comparison(=\=).
arithmetic_comparison(is).

comparison(P) :-
    functor(P, Name, 2),
    arithmetic_comparison(Name),
    Name \== is.

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
    ;   construct(E, Parts)
    ->  \+ E = ?(_),
        (   member(program(F), Parts)
        ;   member(programs(Fs), Parts),
            is_list(Fs),
            member(F, Fs)
        ),
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
