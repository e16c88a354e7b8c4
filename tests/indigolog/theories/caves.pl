% A cave with something in it, in the style of theories for the published evaluator of
% possible values: causes/4, senses/1, domains asked for by helper predicates.
cache(_) :- fail.
:- dynamic size/1.
size(4).
cell(L) :- size(N), findall(I, between(1, N, I), L).
beside(I, J) :- domain(J, cell), 1 is abs(I - J).
any_order(L) :- cell(L0), shuffle(L0, L).

fun_fluent(here).
fun_fluent(beast).
fun_fluent(calm(I)) :- domain(I, cell).

prim_action(walk(I)) :- domain(I, cell).
prim_action(smell).
prim_action(shoot).
senses(smell).

poss(walk(I), and(beside(here, I), neg(beast = I))).
poss(smell, true).
poss(shoot, some(i, and(beside(here, i), beast = i))).

causes(walk(I), here, I, true).
causes(walk(I), calm(I), true, true).
causes(hunt(I), here, I, true).
causes(shoot, beast, none, true).
rejects(smell, 0, beast, I, beside(here, I)).
rejects(smell, 1, beast, I, neg(beside(here, I))).

initially(here, 1).
initially(beast, I) :- domain(I, [2, 3, 4]).
initially(calm(I), false) :- domain(I, cell), I > 1.
initially(calm(1), true).

proc(hunt(I), [walk(I), smell]).
proc(control, [smell, while(neg(know(beast)), pi((i, cell), [?(calm(i) = false), hunt(i)])), shoot]).
