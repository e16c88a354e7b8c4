% Reverse a tower of SIZE blocks (an environment variable): by iterative deepening written as a
% program, through plain search, and by A* over all moves.
size(K) :- getenv('SIZE', Text), atom_number(Text, K).
block(b(I)) :- size(K), between(1, K, I).
fun_fluent(on(B)) :- block(B).
prim_action(move(X, Y)) :- block(X), ( Y = tbl ; block(Y), X \== Y ).
poss(move(X, Y), and(clear(X), and(neg(on(X) = Y), or(Y = tbl, clear(Y))))).
causes_val(move(X, Y), on(X), Y, true).
initially(on(b(I)), Below) :- size(K), between(1, K, I), ( I =:= K -> Below = tbl ; J is I + 1, Below = b(J) ).

proc(clear(X), neg(some(z, on(z) = X))).
proc(goal, P) :- size(K), reversed(K, P).
reversed(1, on(b(1)) = tbl) :- !.
reversed(I, and(on(b(I)) = b(J), P)) :- J is I - 1, reversed(J, P).
wanted(b(I), Below) :- block(b(I)), ( I =:= 1 -> Below = tbl ; J is I - 1, Below = b(J) ).

move(X, Y) :- prim_action(move(X, Y)).
proc(plan(0), ?(goal)).
proc(plan(M), ndet(?(goal), pi(x, pi(y, [?(move(x, y)), move(x, y), plan(M1)])))) :-
    integer(M), M > 0, M1 is M - 1.
proc(deeper(M), ndet(plan(M), [?(true), deeper(M1)])) :- integer(M), M1 is M + 1.

proc(deepening, search(deeper(0))).
proc(astar,
     search(while(neg(goal), pi([x, y], [?(move(x, y)), move(x, y)])),
            [ strategy(astar),
              heuristic(N^aggregate_all(count, and(wanted(B, W), neg(on(B) = W)), N)) ])).
