:- module(indigolog_theory,
          [ current_theory/1,         % -Theory
            make_current/1,           % +Theory
            forget_current/1,         % -Module
            in_theory/2,              % +Theory, :Goal
            new_theory/3,             % +Module, +Certainty, -Theory
            renewed_theory/1,         % -Theory
            while_used/2,             % +Theory, :Goal
            theory_used/1,            % +Module
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
            domain_values/3,          % +Module, +Domain, -Values
            theory_predicate/1        % ?Indicator
          ]).
/** <module> Action theories

A theory is one or more plain Prolog files, loaded into a module of its own (loading.pl),
that declare fluents, actions, axioms and procedures.
*/

:- use_module(library(lists), [append/3, member/2]).
:- use_module(representation).
:- reexport(representation,
            [ theory_module/2, instances_module/2, initial_values/2, plain_actions/2, theory_certain/1 ]).

:- meta_predicate
    in_theory(+, 0),
    while_used(+, 0).

:- dynamic
    common_theory/2,                  % Module, Certainty: at most one fact
    used/2.                           % Module, Home: one fact for each run

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
%   The theory that this thread (or engine) has loaded or was given, else the one that the main
%   thread has loaded.
%
%   @error golog(no_theory) if there is none

current_theory(Theory) :-
    (   nb_current(indigolog_theory, own(Theory0))
    ->  Theory = Theory0
    ;   common_theory(Module, Certainty)
    ->  (   nb_current(indigolog_theory, common(Theory0)),
            theory_module(Theory0, Module)
        ->  Theory = Theory0
        ;   new_theory(Module, Certainty, Theory),
            nb_setval(indigolog_theory, common(Theory))
        )
    ;   throw(error(golog(no_theory), _))
    ).

%!  make_current(+Theory) is det.

make_current(Theory) :-
    nb_setval(indigolog_theory, own(Theory)),
    (   ( thread_self(main) ; \+ common_theory(_, _) )
    ->  theory_module(Theory, Module),
        certainty(Theory, Certainty),
        retractall(common_theory(_, _)),
        assertz(common_theory(Module, Certainty))
    ;   true
    ).

certainty(Theory, Certainty) :-
    ( theory_certain(Theory) -> Certainty = certain ; Certainty = possible ).

%!  forget_current(-Module) is semidet.
%
%   Fails if this thread has no theory of its own.

forget_current(Module) :-
    nb_current(indigolog_theory, own(Theory)),
    theory_module(Theory, Module),
    nb_setval(indigolog_theory, none),
    retractall(common_theory(Module, _)).

%!  in_theory(+Theory, :Goal) is nondet.
%
%   Call Goal while Theory is the current theory of this thread.

in_theory(Theory0, Goal) :-
    theory_module(Theory0, Module),
    (   home(Module, Home),
        instances_module(Theory0, Home)
    ->  Theory = Theory0
    ;   certainty(Theory0, Certainty),    % another thread has loaded it
        new_theory(Module, Certainty, Theory)
    ),
    ( nb_current(indigolog_theory, Before) -> true ; Before = none ),
    b_setval(indigolog_theory, own(Theory)),
    call(Goal),
    b_setval(indigolog_theory, Before).

%!  new_theory(+Module, +Certainty, -Theory) is det.
%
%   Theory has the declarations and axioms of Module, and remembers what they say for this
%   thread alone.  New tries, since SWI-Prolog 9.0.4 may crash when it lists one that was emptied.

new_theory(Module, Certainty, Theory) :-
    home(Module, Home),
    (   used(_, Home)                     % by a run that this one is part of
    ->  true
    ;   dynamic(Home:'$instances'/2),
        forall(retract(Home:'$instances'(_, Instances)),
               ( Instances = ground(Instance, _) -> retractall(Instance) ; true ))
    ),
    trie_new(Initial),
    trie_new(Plain),
    make_theory(Module, Home, tries(Initial, Plain), Certainty, Theory).

% Where this thread keeps the declared instances of Module.
home(Module, Home) :-
    thread_self(Me),
    thread_property(Me, id(N)),
    atomic_list_concat([Module, instances, N], '_', Home).

%!  renewed_theory(-Theory) is det.
%
%   The current theory, without what was remembered of its initial values and declared
%   instances: helper facts may have changed since.
%
%   @error golog(no_theory) if there is none

renewed_theory(Theory) :-
    current_theory(Old),
    theory_module(Old, Module),
    certainty(Old, Certainty),
    new_theory(Module, Certainty, Theory),
    nb_getval(indigolog_theory, Kept),
    functor(Kept, Whose, 1),
    Current =.. [Whose, Theory],
    nb_setval(indigolog_theory, Current).

%!  while_used(+Theory, :Goal) is nondet.
%
%   Call Goal, and meanwhile neither unload Theory nor forget its instances.

while_used(Theory, Goal) :-
    theory_module(Theory, Module),
    instances_module(Theory, Home),
    setup_call_cleanup(assertz(used(Module, Home), Reference), Goal, erase(Reference)).

%!  theory_used(+Module) is semidet.

theory_used(Module) :-
    used(Module, _),
    !.


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
%   The elements of a domain, domain_values/3, of the theory.

domain_list(Theory, Domain, Values) :-
    theory_module(Theory, Module),
    domain_values(Module, Domain, Values).

%!  domain_values(+Module, +Domain, -Values) is det.
%
%   Domain is a list, or names a predicate of Module whose last argument is that list, or is each
%   of its elements in turn: published theories have both.
%
%   @error golog(no_domain(Domain))

domain_values(_, Domain, Values), is_list(Domain) =>
    Values = Domain.
domain_values(Module, Domain, Values) =>
    (   callable(Domain),
        domain_goal(Domain, Value, Goal),
        predicate_property(Module:Goal, visible),
        (   Module:Goal,
            is_list(Value)
        ->  Values = Value
        ;   \+ predicate_property(Module:Goal, built_in),
            findall(Value, Module:Goal, Values),
            ground(Values)
        )
    ->  true
    ;   throw(error(golog(no_domain(Domain)), _))
    ).

domain_goal(Domain, Value, Goal) :-
    Domain =.. Parts0,
    append(Parts0, [Value], Parts),
    Goal =.. Parts.
