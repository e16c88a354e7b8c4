% An elevator that serves calls; calls may arrive at any time.
%
%   swipl indigolog/run.pl -- examples/elevator.pl control
%   swipl indigolog/run.pl -- examples/elevator.pl attend --online

fun_fluent(floor).
rel_fluent(light(N)) :- fl(N).

fl(N) :- between(1, 6, N).

prim_action(up).
prim_action(down).
prim_action(open).
prim_action(close).
prim_action(turn_off(N)) :- fl(N).
exog_action(call(N)) :- fl(N).

poss(up, floor < 6).
poss(down, floor > 1).
poss(open, true).
poss(close, true).
poss(turn_off(N), and(floor = N, light(N))).

causes_val(up, floor, N, N is floor + 1).
causes_val(down, floor, N, N is floor - 1).
causes_true(call(N), light(N), true).
causes_false(turn_off(N), light(N), true).

initially(floor, 3).
initially(light(N), true) :- memberchk(N, [2, 5]).
initially(light(N), false) :- fl(N), \+ memberchk(N, [2, 5]).

proc(go_to(N), while(neg(floor = N), if(floor < N, up, down))).
proc(serve(N), [go_to(N), turn_off(N), open, close]).
proc(serve_any, pi(n, [?(light(n)), serve(n)])).

% The shortest way to serve every call and park at the ground floor.
proc(control,
     search([while(some(n, light(n)), serve_any), go_to(1), open],
            [strategy(breadth)])).

% Serve the calls as they come, park in between.
proc(attend,
     prioritized_interrupts(
         [ interrupt(n, light(n), serve(n)),
           interrupt(floor > 1, down) ])).

exog_occurs(Call) :- ask_exog_occurs(Call).
