% Long loops: count(N) sets one fluent N times, frame(N) tests one that nothing sets.
fun_fluent(counter).
fun_fluent(flag).
prim_action(inc).
prim_action(noop).
poss(inc, true).
poss(noop, true).
causes_val(inc, counter, V, V is counter + 1).
initially(counter, 0).
initially(flag, off).

proc(count(N), while(counter < N, inc)).
proc(frame(0), []).
proc(frame(N), [?(flag = off), noop, frame(M)]) :- integer(N), N > 0, M is N - 1.
