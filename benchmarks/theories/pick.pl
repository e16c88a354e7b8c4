% pick(N): N times the one item of a domain for which the action is possible, which comes last.
% The environment variable SIZE says how large the domain is.
fun_fluent(good(I)) :- item(I).
fun_fluent(counter).
size(D) :- getenv('SIZE', Text), atom_number(Text, D).
item(I) :- size(D), between(1, D, I).
prim_action(use(I)) :- item(I).
poss(use(I), good(I) = yes).
causes_val(use(_), counter, V, V is counter + 1).
initially(good(I), V) :- size(D), between(1, D, I), ( I =:= D -> V = yes ; V = no ).
initially(counter, 0).

proc(pick(N), while(counter < N, pi(x, [?(item(x)), use(x)]))).
