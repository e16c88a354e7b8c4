% One functional fluent and one action; a loop as long as is asked for.

fun_fluent(counter).
prim_action(inc).
poss(inc, true).
causes_val(inc, counter, V, V is counter + 1).
initially(counter, 0).

proc(count(N), while(counter < N, inc)).
