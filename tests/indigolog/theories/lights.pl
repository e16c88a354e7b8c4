% A small theory for the tests: a counter, three lamps, a door that is sensed.
fun_fluent(counter).
fun_fluent(door).
fun_fluent(mark(_)).
rel_fluent(lit(L)) :- lamp(L).

lamp(L) :- lamps(Ls), member(L, Ls).
lamps([a, b, c]).

prim_action(inc).
prim_action(switch(L)) :- lamp(L).
prim_action(all_off).
prim_action(look).
prim_action(put(_, _)).
prim_action(never).
exog_action(bump).
exog_action(numbered(_)).
exog_action(failed(_, _)).

poss(inc, true).
poss(switch(_), true).
poss(all_off, some(l, lit(l))).
poss(look, true).
poss(put(_, _), true).
poss(never, false).

causes_val(inc, counter, N, N is counter + 1).
causes_val(bump, counter, N, N is counter + 10).
causes_val(put(K, V), mark(K), V, true).
causes_val(failed(_, _), counter, -1, true).
causes_true(switch(L), lit(L), neg(lit(L))).
causes_false(switch(L), lit(L), lit(L)).
causes_false(all_off, lit(_), true).
senses(look, door).

initially(counter, 0).
initially(lit(L), false) :- lamp(L).
initially(mark(_), none).

proc(inc_to(N), while(counter < N, inc)).
proc(count_down(0), []).
proc(count_down(N), [inc, count_down(M)]) :- integer(N), N > 0, M is N - 1.
proc(all_lit, all((l, lamps), lit(l))).
proc(loops, ndet(loops, inc)).
