% count(N) beside ten thousand ground fluents, each of which some action sets.
fun_fluent(counter).
fun_fluent(cell(I)) :- index(I).
index(I) :- between(1, 10000, I).
prim_action(inc).
prim_action(mark(_)).
poss(inc, true).
poss(mark(_), true).
causes_val(inc, counter, V, V is counter + 1).
causes_val(mark(I), cell(I), V, V is cell(I) + 1).
initially(counter, 0).
initially(cell(I), 0) :- index(I).

proc(count(N), while(counter < N, inc)).
proc(mark_all, while(counter < 10000, [inc, mark(counter)])).
