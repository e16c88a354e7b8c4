:- module(indigolog_chance,
          [ with_seed/2,              % +Seed, :Goal
            world_moment/1,           % +Moment
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
drawn apart from these: otherwise they would draw other numbers the second time.  And it is
drawn anew at each moment, from the seed and the moment alone, so that the world of a
resumed run draws on as it would have.
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
          set_random(seed(Seed)),
          random_property(state(Drawn)),
          start(Drawn, Start),
          nb_setval(indigolog_world_chance, world(0, State, Start)) ),
        Goal,
        ( nb_setval(indigolog_chance, Before),
          nb_setval(indigolog_world_chance, World),
          set_random(state(Others)) )).

%!  world_moment(+Moment) is det.
%
%   What the world draws from here on is what it draws at Moment, a whole number, of this run.

world_moment(Moment) :-
    Call is Moment << 32,
    next_call(Call).

next_call(Call) :-
    world(World),
    (   World == none                   % no run with a seed
    ->  true
    ;   nb_setarg(1, World, Call)
    ).

%!  drawn_apart(:Goal) is semidet.
%
%   Call Goal, which asks the world, once.  Random numbers of Prolog's own that it draws are those of this call, the first,
%   second, ... of its moment, and none of them is missing from those that are drawn around it.

drawn_apart(Goal) :-
    world(World),
    (   World == none
    ->  once(Goal)
    ;   World = world(Call, Seed, Start),
        Next is Call+1,
        mixed(Seed, Next, Mixed),
        generator(Start, Mixed, Generator),
        random_property(state(Around)),
        setup_call_cleanup(
            set_random(Generator),
            once(Goal),
            ( set_random(state(Around)),
              next_call(Next) ))
    ).

% What set_random/1 takes for a call.  To seed a generator costs half a millisecond.  So the words of the one that the run
% began with, a Mersenne Twister, are multiplied, as one number, with the call's own; the index above them stays.

start(State, Start) :-
    Index is State >> 19_968,           % above 624 words of 32 bits
    (   Index =< 624
    ->  Above is Index << 19_968,
        Words is (State - Above) >> 64, % times 64 bits they are below the index
        Start = words(Above, Words)
    ;   Start = other                   % the generator of another Prolog
    ).

generator(words(Above, Words), Mixed, Generator) =>
    State is Above + Words * (Mixed \/ 1),
    Generator = state(State).
generator(other, Mixed, Generator) =>
    Generator = seed(Mixed).

% mixed(+Seed, +Call, -Number): of 64 bits, a round of the generator of Steele, Lea and Flood (2014).
mixed(Seed, Call, Number) :-
    A is (Seed + Call*0x9E3779B97F4A7C15) /\ 0xFFFFFFFFFFFFFFFF,
    Number is ((A xor (A >> 30)) * 0xBF58476D1CE4E5B9) /\ 0xFFFFFFFFFFFFFFFF.

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
