:- module(indigolog_formula_parts,
          [ condition/3,              % ?Axiom, -Label, -Formula
            connective/3,             % +Formula, -Formulas, -Terms
            is_formula/2,             % +Term, +Theory
            procedure_kind/3,         % +Call, +Theory, -Kind
            goal_exists/2             % +Goal, +Theory
          ]).
/** <module> Which axioms have a formula, what formulas are made of, and what is one

Of procedures, some abbreviate formulas.
*/

:- use_module(library(lists), [list_to_set/2, member/2]).
:- use_module('../language/formula', [meaning/3]).
:- use_module('../language/semantics', [construct/2]).
:- use_module('../language/theory').

%!  condition(?Axiom, -Label, -Formula) is nondet.
%
%   Axiom applies where Formula holds; Label names the kind of axiom and the action.
condition(poss(A, P), of(poss, A), P).
condition(causes_val(A, _, _, P), of(effect, A), P).
condition(causes_true(A, _, P), of(effect, A), P).
condition(causes_false(A, _, P), of(effect, A), P).
condition(senses(A, _, _, _, P), of(sensing, A), P).
condition(settles(A, _, _, _, P), of(sensing, A), P).
condition(rejects(A, _, _, _, P), of(sensing, A), P).

%!  connective(+Formula, -Formulas, -Terms) is semidet.
%
%   Formula begins with a connective, and these are what its truth depends on.
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

%!  is_formula(+Term, +Theory) is semidet.
%
%   Term, the body of a procedure, begins as a formula does, and not as a program.

is_formula(P, Theory) :-
    callable(P),
    \+ is_list(P),
    \+ ( prolog_part(P, E), acts(E, Theory) ),
    (   connective(P, _, _)
    ->  true
    ;   fluent_template(Theory, P, _)
    ->  true
    ;   \+ construct(P, _),
        \+ action_template(Theory, P, _),
        \+ called_procedure(Theory, P),
        goal_exists(P, Theory)
    ).

% prolog_part(+Goal, -Part): Prolog's own conjunctions and choices may have been written for those of programs.
prolog_part(Goal, Part) :-
    nonvar(Goal),
    ( Goal = (A, B) ; Goal = (A ; B) ; Goal = (A -> B) ),
    ( member(Part, [A, B]) ; prolog_part(A, Part) ; prolog_part(B, Part) ).

% What surely is no formula: an action, a construct, or the procedure of one.
acts(E, Theory) :-
    callable(E),
    (   acting(E, Theory)
    ->  true
    ;   theory_module(Theory, Module),
        generalised(E, G),
        clause(Module:proc(G, Body), _),
        callable(Body),
        acting(Body, Theory)
    ->  true
    ).

acting(E, Theory) :-
    (   construct(E, _)
    ->  \+ connective(E, _, _)
    ;   action_template(Theory, E, _)
    ).

%!  procedure_kind(+Call, +Theory, -Kind) is semidet.
%
%   All clauses of the procedure are programs, or all are formulas. Fails where that cannot be told.

procedure_kind(Call, Theory, Kind) :-
    procedure_kind(Call, Theory, [], Kind).

procedure_kind(Call, Theory, Before, Kind) :-
    generalised(Call, G),
    \+ ( member(Earlier, Before), Earlier =@= G ),
    theory_module(Theory, Module),
    findall(Kind0,
            ( clause(Module:proc(G, Body), _),
              ( body_kind(Body, Theory, [G|Before], Kind1) -> Kind0 = Kind1 ; Kind0 = unknown ) ),
            Kinds),
    sort(Kinds, [Kind]).

body_kind(Body, Theory, Before, Kind) :-
    callable(Body),
    (   is_formula(Body, Theory)
    ->  Kind = formula
    ;   called_procedure(Theory, Body)
    ->  procedure_kind(Body, Theory, Before, Kind)
    ;   ( construct(Body, _) ; action_template(Theory, Body, _) )
    ->  Kind = program
    ).

%!  goal_exists(+Goal, +Theory) is semidet.

goal_exists(Goal, Theory) :-
    theory_module(Theory, Module),
    (   predicate_property(Module:Goal, visible)
    ->  true
    ).
