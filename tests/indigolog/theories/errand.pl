% A parcel is to be delivered inside; the front door may be open or shut, the back door is
% open, the garden gate is locked.
fun_fluent(door(D)) :- door(D).
rel_fluent(inside).
rel_fluent(carrying).
rel_fluent(delivered).

door(D) :- member(D, [front, back, garden]).

prim_action(feel(front)).
prim_action(go(D)) :- door(D).
prim_action(fetch).
prim_action(deliver).
prim_action(sing).
exog_action(slam(D)) :- door(D).
exog_action(rain).
exog_action(lose).
exog_action(recall).
exog_action(unlock).

poss(feel(_), neg(inside)).
poss(go(D), and(neg(inside), door(D) = open)).
poss(fetch, neg(carrying)).
poss(deliver, and(inside, carrying)).
poss(sing, true).

senses(feel(D), door(D)).
sensing(feel(_), [open, shut]).
causes_true(go(_), inside, true).
causes_true(fetch, carrying, true).
causes_true(deliver, delivered, true).
causes_val(slam(D), door(D), shut, true).
causes_val(unlock, door(garden), open, true).
causes_false(lose, carrying, true).
causes_false(recall, delivered, true).

initially(door(back), open).
initially(door(garden), locked).
initially(inside, false).
initially(carrying, true).
initially(delivered, false).

proc(errand,
     [ feel(front),
       ndet([?(door(front) = open), go(front)], go(back)),
       if(carrying, [], fetch),
       deliver ]).

% For achieve.
restrict_actions(by_the_back, _, _, _, true, [go(back), deliver]).
simulator(gardener, door(garden) = locked, unlock).
simulator(for_ever, true, rain).
