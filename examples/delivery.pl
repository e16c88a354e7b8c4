% A robot that carries a parcel through rooms; a door may turn out to be shut.
%
%   swipl indigolog/run.pl -- examples/delivery.pl control
%   swipl indigolog/run.pl -- examples/delivery.pl control --online

fun_fluent(at).                 % the room the robot is in
fun_fluent(parcel).             % a room, robot or delivered
fun_fluent(passage(X, Y)) :- door(X, Y).        % open, shut or untried

door(X, Y) :- wall(X, Y).
door(X, Y) :- wall(Y, X).
wall(lab, corridor).
wall(corridor, office).
wall(lab, store).
wall(store, office).

prim_action(go(X, Y)) :- door(X, Y).
prim_action(try(X, Y)) :- door(X, Y).
prim_action(pick_up).
prim_action(hand_over).

poss(try(X, _), at = X).
poss(go(X, Y), and(at = X, passage(X, Y) = open)).
poss(pick_up, parcel = at).
poss(hand_over, and(parcel = robot, at = office)).

% Plans hope that a door opens; trying it tells.
causes_val(try(X, Y), passage(X, Y), open, true).
causes_val(go(_, Y), at, Y, true).
causes_val(pick_up, parcel, robot, true).
causes_val(hand_over, parcel, delivered, true).
senses(try(X, Y), passage(X, Y)).

initially(at, corridor).
initially(parcel, lab).
initially(passage(X, Y), untried) :- door(X, Y).

% A result that breaks the plan makes search find another one from there.
proc(control, search([reach(lab), pick_up, reach(office), hand_over],
                     [strategy(breadth)])).
proc(reach(Room),
     while(neg(at = Room),
           pi([x, y], [ ?(and(at = x, and(door(x, y), neg(passage(x, y) = shut)))),
                        if(passage(x, y) = open, go(x, y), try(x, y)) ]))).
