:- module(indigolog_memory,
          [ new_memory/4,             % +Program, +Situation, +Options, -Memory
            configuration_key/3,      % +Program, +Situation, -Key
            recalled/3,               % +Memory, +Key, -Value
            remember/3,               % +Memory, +Key, +Value
            seen/4,                   % +Memory, +Program, +Situation, +Cost
            superseded/4              % +Memory, +Program, +Situation, +Cost
          ]).
/** <module> The configurations that a search has met

By program, constraints on its variables, and fluent values.  A memory is memory(Slots, Count, Table, MostBytes, BytesBefore,
NextLook), a hash table with open addressing that backtracking leaves alone: of each
configuration the SHA-1 of its program and values, an atom, and an atomic value; 150 bytes or so.
*/

:- use_module(library(lists), [member/2]).
:- use_module(library(occurs), [sub_term/2]).
:- use_module(library(option), [option/3]).
:- use_module('../language/situation', [situation_key/2, situation_theory/2]).
:- use_module('../language/theory', [theory_module/2]).

% Megabytes of a search, where no option says otherwise: half of the stack that Prolog has by default.
most_megabytes(500).

% Configurations between two looks at how much memory is used; chosen by hand.
look_interval(1000).

%!  new_memory(+Program, +Situation, +Options, -Memory) is det.
%
%   `none` where something may ask for the history itself, which tells two situations with equal
%   values apart.

new_memory(E, S, Options, Memory) :-
    (   sees_history(E-Options, S)
    ->  Memory = none
    ;   most_megabytes(Default),
        option(max_mb(Megabytes), Options, Default),
        Most is ceiling(Megabytes*1.0e6),
        room_on_stack(Most),
        used_bytes(Before),
        Slots = 256,
        Cells is 2*Slots,
        functor(Table, table, Cells),
        look_interval(Look),
        Memory = memory(Slots, 0, Table, Most, Before, Look)
    ).

% What a search is allowed to use it must be able to: twice as much while the garbage in it is collected.
room_on_stack(Most) :-
    current_prolog_flag(stack_limit, Limit),
    (   Limit < 2*Most
    ->  Higher is 2*Most,
        set_prolog_flag(stack_limit, Higher)
    ;   true
    ).

used_bytes(Bytes) :-
    statistics(globalused, Global),
    statistics(localused, Local),
    statistics(trailused, Trail),
    Bytes is Global+Local+Trail.

sees_history(E, _) :-
    asks_history(E),
    !.
sees_history(_, S) :-
    situation_theory(S, Theory),
    theory_module(Theory, Module),
    member(Head, [poss(_, _), proc(_, _), causes_val(_, _, _, _),
                  causes_true(_, _, _), causes_false(_, _, _)]),
    clause(Module:Head, Body),
    asks_history(Head-Body),
    !.

asks_history(Term) :-
    sub_term(T, Term),
    nonvar(T),
    T = done(_).

%!  configuration_key(+Program, +Situation, -Key) is det.

configuration_key(E, S, Key) :-
    situation_key(S, Values),
    (   term_attvars(E, [])
    ->  variant_sha1(E-Values, Key)
    ;   copy_term(E, E1, Constraints),
        variant_sha1(E1-Values-Constraints, Key)
    ).

%!  recalled(+Memory, +Key, -Value) is semidet.

recalled(memory(Slots, _, Table, _, _, _), Key, Value) :-
    place(Key, Slots, Table, I),
    arg(I, Table, A),
    nonvar(A),
    V is I+1,
    arg(V, Table, Value).

%!  remember(+Memory, +Key, +Value) is det.
%
%   @error golog(search_budget(max_mb(Megabytes, Configurations))) if that is one too many

remember(Memory, Key, Value) :-
    Memory = memory(Slots, N, Table, _, _, Look),
    place(Key, Slots, Table, I),
    arg(I, Table, A),
    (   nonvar(A)
    ->  set_slot(I, Table, Key, Value)
    ;   set_slot(I, Table, Key, Value),
        N1 is N+1,
        nb_setarg(2, Memory, N1),
        ( N1*3 > Slots*2 -> doubled(Memory) ; true ),
        ( N1 >= Look -> within_bounds(Memory) ; true )
    ).

set_slot(I, Table, Key, Value) :-
    V is I+1,
    nb_setarg(I, Table, Key),
    nb_setarg(V, Table, Value).

% place(+Key, +Slots, +Table, -I): where Key is, or where it would be, which is unbound.
place(Key, Slots, Table, I) :-
    term_hash(Key, Hash),
    Slot is Hash /\ (Slots-1),
    probe(Slot, Key, Slots, Table, I).

probe(Slot, Key, Slots, Table, I) :-
    I0 is 2*Slot+1,
    arg(I0, Table, A),
    (   ( var(A) ; A == Key )
    ->  I = I0
    ;   Slot1 is (Slot+1) /\ (Slots-1),
        probe(Slot1, Key, Slots, Table, I)
    ).

doubled(Memory) :-
    Memory = memory(Slots0, _, Table0, _, _, _),
    Slots is 2*Slots0,
    Cells is 2*Slots,
    functor(Table, table, Cells),
    Last is Slots0-1,
    forall(( between(0, Last, Slot), I is 2*Slot+1, arg(I, Table0, Key), nonvar(Key) ),
           ( V is I+1,
             arg(V, Table0, Value),
             place(Key, Slots, Table, I1),
             set_slot(I1, Table, Key, Value) )),
    nb_setarg(1, Memory, Slots),
    nb_setarg(3, Memory, Table).

% Garbage does not count.
within_bounds(Memory) :-
    Memory = memory(_, N, _, Most, Before, _),
    look_interval(Interval),
    Look is N+Interval,
    nb_setarg(6, Memory, Look),
    (   used_bytes(Bytes0),
        Bytes0-Before =< Most
    ->  true
    ;   garbage_collect,
        used_bytes(Bytes),
        Bytes-Before =< Most
    ->  true
    ;   Megabytes is ceiling(Most/1.0e6),
        throw(error(golog(search_budget(max_mb(Megabytes, N))), _))
    ).

%!  seen(+Memory, +Program, +Situation, +Cost) is semidet.
%
%   The configuration was met before at no higher cost.  Fails if not, and
%   remembers Cost.

seen(Memory, E, S, Cost) :-
    Memory \== none,
    configuration_key(E, S, Key),
    (   recalled(Memory, Key, Cost0),
        Cost0 =< Cost
    ->  true
    ;   remember(Memory, Key, Cost),
        fail
    ).

%!  superseded(+Memory, +Program, +Situation, +Cost) is semidet.
%
%   The configuration has been met at a lower cost.

superseded(Memory, E, S, Cost) :-
    Memory \== none,
    configuration_key(E, S, Key),
    recalled(Memory, Key, Cost0),
    Cost0 < Cost.
