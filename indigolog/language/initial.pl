:- module(indigolog_initial,
          [ initial_status/3,         % +Theory, +Fluent, -Status
            declared_instance/3,      % +Theory, ?Fluent, -Instances
            ground_instances/4        % +Theory, ?Fluent, -Instance, -Status
          ]).
/** <module> Initial values, and the ground instances of fluents

Both are asked of the theory once and then remembered (renewed_theory/1 forgets them).
*/

:- use_module(library(lists), [append/3, list_to_set/2]).
:- use_module(library(apply), [maplist/2]).
:- use_module(theory).

%!  initial_status(+Theory, +Fluent, -Status) is det.
%
%   What the theory says of a ground Fluent in the initial situation: v(Value),
%   any(Values) if it has several possible values, `unknown` if it is declared and has no
%   value, `undeclared` if this instance is not declared.

initial_status(Theory, Fluent, Status) :-
    initial_values(Theory, Trie),
    (   trie_lookup(Trie, Fluent, Status0)
    ->  Status = Status0
    ;   find_initial_status(Theory, Fluent, Status),
        trie_insert(Trie, Fluent, Status)
    ).

find_initial_status(Theory, Fluent, Status) :-
    theory_module(Theory, Module),
    (   \+ declared_fluent(Theory, Fluent)
    ->  Status = undeclared
    ;   uncertain_template(Theory, Fluent)
    ->  findall(Value, Module:initially(Fluent, Value), Values0),
        list_to_set(Values0, Values),
        values_status(Values, Status)
    ;   Module:initially(Fluent, Value)
    ->  Status = v(Value)
    ;   Status = unknown
    ).

values_status([], unknown) :- !.
values_status([Value], v(Value)) :- !.
values_status(Values, any(Values)).

%!  declared_instance(+Theory, ?Fluent, -Instances) is nondet.
%
%   Fluent is a declared instance and Instances is `ground`, or Instances is
%   `open` when the declaration leaves arguments free.

declared_instance(Theory, Fluent, Instances) :-
    (   ground_instances(Theory, Fluent, Instance, _)
    ->  Instances = ground,
        call(Instance)
    ;   Instances = open
    ).

%!  ground_instances(+Theory, ?Fluent, -Instance, -Status) is semidet.
%
%   All declared instances of Fluent are ground: call(Instance) enumerates them, with
%   the initial Status of each.

ground_instances(Theory, Fluent, Instance, Status) :-
    instances_module(Theory, Home),
    (   Home:'$instances'(Fluent, Instances)
    ->  true
    ;   with_mutex(indigolog_instances, index_instances(Theory, Fluent)),
        Home:'$instances'(Fluent, Instances)
    ),
    Instances = ground(Instance, Status).

index_instances(Theory, Fluent) :-    % unless another thread has done it by now
    instances_module(Theory, Home),
    Home:'$instances'(Fluent, _),
    !.
index_instances(Theory, Fluent) :-
    instances_module(Theory, Home),
    generalised(Fluent, Template),
    findall(Template, declared_fluent(Theory, Template), All0),
    list_to_set(All0, All),
    (   ground(All)
    ->  Instances = ground(Home:Instance, Status),
        instance_fact(Template, Status, Instance),
        functor(Instance, Name, Arity),
        dynamic(Home:Name/Arity),
        maplist(assert_instance(Theory), All)
    ;   Instances = open
    ),
    assertz(Home:'$instances'(Template, Instances)).

assert_instance(Theory, Fluent) :-
    instances_module(Theory, Home),
    initial_status(Theory, Fluent, Status),
    instance_fact(Fluent, Status, Instance),
    assertz(Home:Instance).

% The arguments stay apart, so that each is indexed.
instance_fact(Fluent, Status, Instance) :-
    (   atom(Fluent)
    ->  Instance =.. [Fluent, Status]
    ;   compound_name_arguments(Fluent, Name, Arguments),
        append(Arguments, [Status], Arguments1),
        compound_name_arguments(Instance, Name, Arguments1)
    ).
