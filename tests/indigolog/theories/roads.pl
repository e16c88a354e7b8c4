% Towns and roads of different lengths; some may close, and a toll is sensed.
fun_fluent(at).
rel_fluent(closed(X, Y)) :- road(X, Y, _).
fun_fluent(toll).

% The way through b has fewer roads, the one through c and d is shorter.
road(a, b, 7).
road(b, z, 7).
road(a, c, 3).
road(c, d, 3).
road(d, z, 3).
road(c, a, 3).
road(d, c, 3).
way(X, Y) :- road(X, Y, _).
towns([a, b, c, d, z]).
town(X) :- towns(Xs), member(X, Xs).

prim_action(drive(X, Y)) :- road(X, Y, _).
prim_action(ask).
exog_action(close(X, Y)) :- road(X, Y, _).
exog_action(rain).

poss(drive(X, Y), and(at = X, neg(closed(X, Y)))).
poss(ask, true).
causes_val(drive(_, Y), at, Y, true).
causes_true(close(X, Y), closed(X, Y), true).
causes_val(ask, toll, none, true).
senses(ask, toll).

initially(at, a).
initially(closed(X, Y), false) :- road(X, Y, _).

distance(X, Y, L) :- road(X, Y, L).
left(a, 9).
left(b, 7).
left(c, 6).
left(d, 3).
left(z, 0).

% The same estimates, too high on the way through c: what finds a plan first does not find the best.
misled(a, 9).
misled(b, 0).
misled(c, 9).
misled(d, 9).
misled(z, 0).

proc(travel, while(neg(at = z), pi([x, y], [?(and(at = x, way(x, y))), drive(x, y)]))).
proc(in_circles, [star([drive(a, c), drive(c, a)]), ?(false)]).
proc(for_ever(N), [drive(a, c), drive(c, a), for_ever(M)]) :- integer(N), M is N + 1.
