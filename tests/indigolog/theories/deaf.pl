% A world of its own: actions are done, and nothing ever happens.
prim_action(act).
exog_action(knock).
poss(act, true).
execute(_, _).
exog_occurs(_) :- fail.
