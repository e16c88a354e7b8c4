% side_by_side(K, N): K concurrent loops of N actions each.
fun_fluent(c(_)).
prim_action(inc(_)).
poss(inc(_), true).
causes_val(inc(I), c(I), V, V is c(I) + 1).
initially(c(_), 0).

proc(side_by_side(K, N), P) :- loops(K, N, P).
loops(1, N, while(c(1) < N, inc(1))) :- !.
loops(K, N, conc(while(c(K) < N, inc(K)), P)) :- K1 is K - 1, loops(K1, N, P).
