% toggle(N): an effect that is conditional on the fluent it sets.
fun_fluent(fan).
prim_action(toggle).
poss(toggle, true).
causes_val(toggle, fan, on, fan = off).
causes_val(toggle, fan, off, fan = on).
initially(fan, off).

proc(toggle(0), ?(or(fan = on, fan = off))).
proc(toggle(N), [toggle, toggle(M)]) :- integer(N), N > 0, M is N - 1.
