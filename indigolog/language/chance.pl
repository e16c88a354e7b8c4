:- module(indigolog_chance,
          [ with_seed/2,              % +Seed, :Goal
            drawn_apart/1,            % :Goal
            shuffled/2                % +List, -Permutation
          ]).
/** <module> Random choices that can be repeated

Random constructs draw from a generator of their own, so that a run with the
same seed and the same answers from the world makes the same choices, whatever
else in the process draws random numbers.  The state is a 64-bit
linear congruential generator (Knuth's MMIX constants); its upper bits are used.

The tests and helpers of a theory draw from Prolog's generator.  What the world does while
a program runs is not done again when its journal is followed, so what it draws is
drawn apart from these: otherwise they would draw other numbers the second time.
*/

:- use_module(library(apply), [maplist/3]).
:- use_module(library(pairs), [pairs_values/2]).

:- meta_predicate
    with_seed(+, 0),
    drawn_apart(0).

%!  with_seed(+Seed, :Goal) is nondet.
%
%   Call Goal with choices, and random numbers of Prolog's own, that begin at Seed; what is
%   around it goes on as if nothing had been drawn.

with_seed(Seed, Goal) :-
    state(Before),
    world(World),
    random_property(state(Others)),
    setup_call_cleanup(
        ( State is (Seed * 0x9E3779B97F4A7C15 + 0x1234567) /\ 0xFFFFFFFFFFFFFFFF,
          nb_setval(indigolog_chance, State),
          random_fraction(_),
          nb_setval(indigolog_world_chance, seed(State)),
          set_random(seed(Seed)) ),
        Goal,
        ( nb_setval(indigolog_chance, Before),
          nb_setval(indigolog_world_chance, World),
          set_random(state(Others)) )).

%!  drawn_apart(:Goal) is semidet.
%
%   Call Goal, which asks the world, once.  Random numbers of Prolog's own that it draws begin at the seed of the run, too,
%   but none of them is missing from those that are drawn around it.

drawn_apart(Goal) :-
    world(World),
    (   World == none                   % no run with a seed
    ->  once(Goal)
    ;   random_property(state(Around)),
        setup_call_cleanup(
            set_random(World),
            once(Goal),
            ( random_property(state(After)),
              nb_setval(indigolog_world_chance, state(After)),
              set_random(state(Around)) ))
    ).

world(World) :-
    (   nb_current(indigolog_world_chance, World0)
    ->  World = World0
    ;   World = none
    ).

state(State) :-
    (   nb_current(indigolog_chance, State0)
    ->  State = State0
    ;   State = 0x853C49E6748FEA9B
    ).

%   A float in [0, 1).

random_fraction(Fraction) :-
    state(State0),
    State is (State0 * 6364136223846793005 + 1442695040888963407)
             /\ 0xFFFFFFFFFFFFFFFF,
    nb_setval(indigolog_chance, State),
    Fraction is (State >> 11) / 9007199254740992.0.

%!  shuffled(+List, -Permutation) is det.

shuffled(List, Permutation) :-
    maplist(keyed, List, Keyed),
    keysort(Keyed, Sorted),
    pairs_values(Sorted, Permutation).

keyed(X, F-X) :-
    random_fraction(F).
