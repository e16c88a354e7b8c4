% interrupts(K, N): the last and lowest of K+1 interrupts fires N times.
fun_fluent(counter).
fun_fluent(alarm(_)).
prim_action(inc).
poss(inc, true).
causes_val(inc, counter, V, V is counter + 1).
initially(counter, 0).
initially(alarm(_), off).

proc(interrupts(K, N), prioritized_interrupts(All)) :-
    findall(interrupt(alarm(I) = on, inc), between(1, K, I), Quiet),
    append(Quiet, [interrupt(counter < N, inc)], All).
