:- module(indigolog_theory,
          [ current_theory/1,         % -Theory
            make_current/2,           % +Theory, +Files
            forget_current/2,         % -Module, -Files
            new_theory/3,             % +Module, +Certainty, -Theory
            renewed_theory/1,         % -Theory
            fluent_template/2,        % +Theory, ?Term
            fluent_template/3,        % +Theory, +Term, -Kind
            called_procedure/2,       % +Theory, +Term
            declared_fluent/2,        % +Theory, ?Fluent
            sensed_template/2,        % +Theory, +Fluent
            uncertain_template/2,     % +Theory, +Fluent
            action_template/3,        % +Theory, +Term, -Kind
            assignment/2,             % +Action, +Theory
            history_mark/1,           % ?Entry
            generalised/2,            % +Term, -Template
            domain_list/3,            % +Theory, +Domain, -Values
            theory_predicate/1        % ?Indicator
          ]).
:- use_module(library(lists), [append/3, member/2]).
:- use_module(representation).
:- reexport(representation,
            [ theory_module/2, instances_module/2, initial_values/2, plain_actions/2, theory_certain/1 ]).

/** <module> Action theories

A theory is one or more plain Prolog files, loaded into a module of its own (loading.pl),
that declare fluents, actions, axioms and procedures.
*/

:- dynamic loaded/2.                  % Theory, Files: at most one fact

%!  theory_predicate(?Indicator) is nondet.
%
%   The predicates a theory may define.

theory_predicate(PI) :-
    member(PI,
           [ prim_fluent/1, fun_fluent/1, rel_fluent/1, prim_action/1, exog_action/1,
             poss/2, causes_val/4, causes_true/3, causes_false/3,
             senses/2, senses/5, settles/5, rejects/5, sensing/2,
             initially/2, proc/2, cache/1, execute/2, exog_occurs/1 ]).

%!  current_theory(-Theory) is det.
%
%   @error golog(no_theory) if none is loaded

current_theory(Theory) :-
    (   loaded(Theory0, _)
    ->  Theory = Theory0
    ;   throw(error(golog(no_theory), _))
    ).

%!  make_current(+Theory, +Files) is det.

make_current(Theory, Files) :-
    assertz(loaded(Theory, Files)).

%!  forget_current(-Module, -Files) is semidet.

forget_current(Module, Files) :-
    retract(loaded(Theory, Files)),
    !,
    theory_module(Theory, Module).

%!  new_theory(+Module, +Certainty, -Theory) is det.

new_theory(Module, Certainty, Theory) :-
    atom_concat(Module, '_instances', Home),
    trie_new(Initial),
    trie_new(Plain),
    make_theory(Module, Home, tries(Initial, Plain), Certainty, Theory).

%!  renewed_theory(-Theory) is det.
%
%   The current theory, without what was remembered of its initial values and declared
%   instances: helper facts may have changed since.  New tries, since SWI-Prolog 9.0.4
%   may crash when it lists one that was emptied.
%
%   @error golog(no_theory) if none is loaded

renewed_theory(Theory) :-
    current_theory(Old),
    theory_module(Old, Module),
    ( theory_certain(Old) -> Certainty = certain ; Certainty = possible ),
    forall(retract(Module:'$instances'(_, Instances)),
           ( Instances = ground(Instance, _) -> retractall(Instance) ; true )),
    forget_current(Module, Files),
    new_theory(Module, Certainty, Theory),
    make_current(Theory, Files).


                /* What is declared */

%!  generalised(+Term, -Template) is semidet.
%
%   Template has the functor of the callable Term, and fresh arguments.

generalised(Term, Template) :-
    callable(Term),
    functor(Term, Name, Arity, Type),
    functor(Template, Name, Arity, Type).

%!  fluent_template(+Theory, ?Term) is nondet.
%!  fluent_template(+Theory, +Term, -Kind) is semidet.
%
%   Term has the functor of a declared fluent; Kind is `rel` or `fun`.

fluent_template(Theory, Term) :-
    theory_module(Theory, Module),
    Module:'$fluent'(Term, _).

fluent_template(Theory, Term, Kind) :-
    theory_module(Theory, Module),
    Module:'$fluent'(Term, Kind),
    !.

%!  sensed_template(+Theory, +Fluent) is semidet.
%
%   Some sensing axiom speaks of the functor of Fluent, so that having no value
%   means that it is not known yet.

sensed_template(Theory, Fluent) :-
    theory_module(Theory, Module),
    Module:'$sensed'(Fluent),
    !.

%!  uncertain_template(+Theory, +Fluent) is semidet.
%
%   A settles/5 or rejects/5 axiom speaks of the functor of Fluent, so that all
%   its initial values are possible ones.

uncertain_template(Theory, Fluent) :-
    theory_module(Theory, Module),
    Module:'$uncertain'(Fluent),
    !.

%!  action_template(+Theory, +Term, -Kind) is nondet.
%
%   Term has the functor of a declared action; Kind is `prim` or `exog`.

action_template(Theory, Term, Kind) :-
    theory_module(Theory, Module),
    Module:'$action'(Term, Kind).

%!  assignment(+Action, +Theory) is semidet.
%
%   Action is the interpreter's set(Fluent) or unset(Fluent), and not an action that the
%   theory declares by that name.

assignment(set(F), Theory) => \+ action_template(Theory, set(F), _).
assignment(unset(F), Theory) => \+ action_template(Theory, unset(F), _).
assignment(_, _) => fail.

%!  history_mark(?Entry) is nondet.
%
%   What else the interpreter enters into histories, so that no theory can have an action
%   of that name.

history_mark(e(_, _)).
history_mark(sim(_)).
history_mark(test(_)).
history_mark(branch(_)).
history_mark(stop_interrupts).

%!  called_procedure(+Theory, +Term) is semidet.
%
%   There is a procedure, or an abbreviation, with the name and arity of Term.

called_procedure(Theory, Term) :-
    theory_module(Theory, Module),
    generalised(Term, G),
    clause(Module:proc(G, _), _),
    !.

%!  declared_fluent(+Theory, ?Fluent) is nondet.

declared_fluent(Theory, Fluent) :-
    theory_module(Theory, Module),
    (   Module:rel_fluent(Fluent)
    ;   Module:fun_fluent(Fluent)
    ;   Module:prim_fluent(Fluent)
    ).

%!  domain_list(+Theory, +Domain, -Values) is det.
%
%   The elements of a domain: a list, or the name of a predicate of the theory
%   whose only argument is that list.

domain_list(Theory, Domain, Values) :-
    (   is_list(Domain)
    ->  Values = Domain
    ;   callable(Domain),
        theory_module(Theory, Module),
        domain_goal(Domain, Values0, Goal),
        catch(Module:Goal, error(existence_error(procedure, _), _), fail),
        is_list(Values0)
    ->  Values = Values0
    ;   throw(error(golog(no_domain(Domain)), _))
    ).

domain_goal(Domain, Values, Goal) :-
    Domain =.. Parts0,
    append(Parts0, [Values], Parts),
    Goal =.. Parts.
