% A treasure lies in one of three boxes; what the agent knows of it are possible values.
fun_fluent(at).
fun_fluent(treasure).
rel_fluent(rich).
rel_fluent(lamp).

box(B) :- member(B, [1, 2, 3]).

prim_action(go(B)) :- box(B).
prim_action(knock).                     % hollow, dull: is it under this one?
prim_action(open).
prim_action(peek).
prim_action(look).
prim_action(shake).
exog_action(thief).

poss(go(B), neg(at = B)).
poss(knock, true).
poss(open, treasure = at).
poss(peek, true).
poss(look, true).
poss(shake, true).

causes_val(go(B), at, B, true).
causes_true(open, rich, at = treasure).
causes_val(thief, treasure, none, at = treasure).
causes_val(shake, treasure, 3, treasure = 2).

rejects(knock, hollow, treasure, B, B = at).
settles(knock, dull, treasure, B, B = at).
settles(peek, B, treasure, B, true).
senses(look, lamp).

initially(at, 1).
initially(treasure, B) :- box(B).
initially(rich, false).
