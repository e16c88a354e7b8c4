% Blocks world: reverse a tower, planned by A* over all moves.
%
%   swipl indigolog/run.pl -- examples/blocks_world.pl control

fun_fluent(on(B)) :- block(B).

blocks([b1, b2, b3, b4, b5, b6]).
block(B) :- blocks(Bs), member(B, Bs).

prim_action(move(X, Y)) :- block(X), ( Y = ground ; block(Y), X \== Y ).
poss(move(X, Y), and(clear(X), and(neg(on(X) = Y), or(Y = ground, clear(Y))))).
causes_val(move(X, Y), on(X), Y, true).

% b1 on b2 on ... on the ground, and the other way round.
initially(on(B), Below) :- blocks(Bs), stacked(Bs, B, Below).
wanted(B, Below) :- blocks(Bs0), reverse(Bs0, Bs), stacked(Bs, B, Below).
stacked(Bs, B, Below) :- append(_, [B|Lower], Bs), ( Lower = [Below|_] -> true ; Below = ground ).

proc(clear(X), neg(some(z, on(z) = X))).
proc(goal, forall(wanted(B, Below), on(B) = Below)).

proc(anything, [pi([x, y], [?(prim_action(move(x, y))), move(x, y)])]).

% How many blocks are not yet where they belong: each needs a move at least.
proc(control,
     search(while(neg(goal), anything),
            [ strategy(astar),
              heuristic(N^aggregate_all(count, and(wanted(B, Below), neg(on(B) = Below)), N)) ])).
