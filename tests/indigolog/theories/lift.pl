% A lift in the style of published theories: variables are lower-case atoms, declarations carry
% conditions, the world is asked for on the terminal, directives and caching clauses are left in.
%
% Controllers: control(plain), control(short), control(sensing), control(list), control(reactive).

:- dynamic controller/1.
:- discontiguous prim_fluent/1, rel_fluent/1, proc/2, causes_val/4, prim_action/1, poss/2.

execute(A, R) :- ask_execute(A, R).
exog_occurs(A) :- ask_exog_occurs(A).

cache(_) :- fail.

top(6).
storey(N) :- top(M), between(1, M, N).

prim_fluent(at).
prim_fluent(button(N)) :- storey(N).
prim_fluent(panel).
prim_fluent(heat).
rel_fluent(fan).
rel_fluent(alarm).
rel_fluent(door).

prim_action(up).
prim_action(down).
prim_action(open).
prim_action(close).
prim_action(clear(N)) :- storey(N).
prim_action(feel(N)) :- storey(N).
prim_action(read_panel).
prim_action(toggle).
prim_action(ring).

exog_action(press(N)) :- storey(N).
exog_action(hotter).
exog_action(colder).
exog_action(smoke).
exog_action(reset).

% Simulated events may be planned with.
prim_action(A) :- exog_action(A).
poss(A, true) :- exog_action(A).

poss(up, and(neg(door), neg(at = N))) :- top(N).
poss(down, and(neg(door), neg(at = 1))).
poss(open, true).
poss(close, true).
poss(clear(N), and(at = N, wanted(N))).
poss(feel(_), true).
poss(read_panel, true).
poss(toggle, true).
poss(ring, true).

senses(feel(N), button(N)).
senses(read_panel, panel).

causes_val(up, at, N, N is at + 1).
causes_val(down, at, N, N is at - 1).
causes_val(clear(N), button(N), off, true).
causes_val(press(N), button(N), on, true).
causes_val(clear(N), panel, L, replaced(panel, L, N, 0)).
causes_val(hotter, heat, X, X is heat + 1).
causes_val(colder, heat, X, X is heat - 1).
causes_true(toggle, fan, neg(fan)).
causes_false(toggle, fan, fan).
causes_true(smoke, alarm, true).
causes_false(reset, alarm, true).
causes_true(open, door, true).
causes_false(close, door, true).

initially(at, 3).
initially(heat, 2).
initially(fan, false).
initially(alarm, false).
initially(door, false).
initially(button(N), on) :- member(N, [2, 6]).
initially(button(N), off) :- storey(N), \+ initially(button(N), on).

replaced(L1, L2, N, V) :-
    M is N - 1,
    length(Before, M),
    append(Before, [_|After], L1),
    append(Before, [V|After], L2).

proc(hot, heat > 3).
proc(below(N), at < N).
proc(above(N), at > N).
proc(wanted(N), or(button(N) = on, nth1(N, panel, 1))).
proc(some_wanted, some(n, wanted(n))).

proc(go(N), while(neg(at = N), if(below(N), up, down))).
proc(serve(N), [go(N), open, close, clear(N)]).
proc(serve_some, pi(n, [?(wanted(n)), serve(n)])).
proc(feel_all, L) :- findall(feel(N), storey(N), L).

% Serve whoever comes first, then park.
proc(control(plain), [while(some_wanted, serve_some), go(1), open]).

% The same with as few moves as can be: the bound on moves is raised until there is a plan.
proc(control(short), search(moves(0), "looking for the shortest way")).
proc(moves(M), ndet(within(M), pi(k, [?(k is M + 1), moves(k)]))).
proc(within(M),
     ndet([?(and(neg(some_wanted), M >= at - 1)), go(1), open],
          pi([n, k], [?(and(wanted(n), k is M - abs(at - n))), ?(k >= 0), serve(n), within(k)]))).

% Find out what is wanted by touch, or from the panel.
proc(control(sensing),
     [feel_all, while(or(some_wanted, above(1)), if(some_wanted, serve_some, [down, feel_all]))]).
proc(control(list),
     [read_panel, while(or(member(1, panel), above(1)), if(member(1, panel), serve_some, [down, read_panel]))]).

proc(control(reactive),
     prioritized_interrupts(
         [ interrupt(and(hot, neg(fan)), toggle),
           interrupt(and(neg(hot), fan), toggle),
           interrupt(alarm, ring),
           interrupt(n, wanted(n), serve(n)),
           interrupt(above(1), down) ])).
