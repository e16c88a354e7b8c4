% A lift that knows its floor and not its load; the procedures are wrong in ways that only show when they run.
fun_fluent(floor).
fun_fluent(load).
prim_action(up).
prim_action(carry(_)).
prim_action(listen).
rel_fluent(noisy).
rel_fluent(tidy(N)) :- member(N, [1, 2]).
prim_action(sweep(_)).

poss(up, floor < 4).
poss(carry(_), true).
poss(listen, true).
poss(sweep(N), neg(tidy(N))).
senses(listen, noisy).

causes_val(up, floor, N, N is floor + 1).

initially(floor, 1).

proc(lift(N), [?(load > N), up]).
proc(fall(2), []).
proc(spin, while(true, ?(true))).
proc(deeper(N), deeper(s(N))).
proc(growing(N), [?(M is N + 1), growing(M)]).
