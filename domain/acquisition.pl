% The acquisition theory: what a controller of lights and camera knows and can do.
%
% A strategy is a Golog program over these actions and fluents; see
% controllers/ for examples and docs/controllers.md for how to write one.
% Terms: settings and devices, device.pl; states, qualitative.pl; fixes, merit.pl.

:- use_module(reasoning/device).
:- use_module(reasoning/qualitative).
:- use_module(reasoning/candidates).
:- use_module(reasoning/image_set).
:- use_module(reasoning/instead).
:- use_module(reasoning/merit).
:- use_module(reasoning/outlook).
:- use_module(reasoning/surprises).

% ---------------------------------------------------------------- fluents

fun_fluent(device).             % what camera and lights can do
fun_fluent(threshold).          % merit, in px, under which a pose is trusted
fun_fluent(max_iterations).     % images that may be taken of one pose
fun_fluent(allowed).            % images that may be taken in all by now, however often the target moves
fun_fluent(settings).           % what the next image will be taken under
fun_fluent(iteration).          % images taken so far
fun_fluent(taken).              % images taken of this pose
fun_fluent(candidate).          % the image neither kept nor discarded yet, or none
fun_fluent(statistics).         % of the last image, in the target's region
fun_fluent(applied).            % what the last image was taken under, which may be other than what was chosen
fun_fluent(repeats).            % the earlier image of this scene whose very picture the last image is, or none
fun_fluent(readings).           % reading(Applied, Statistics) of every image of this scene
fun_fluent(tried).              % settings that were chosen for images of this scene, newest first
fun_fluent(image_set).          % kept(Image, State), newest first
fun_fluent(discarded).          % names of discarded images
fun_fluent(unfavourable).       % states that gave nothing
fun_fluent(fix).                % the last estimate, from the set with the candidate
fun_fluent(measured).           % the images of the last estimate
fun_fluent(best).               % the estimate from the kept set
fun_fluent(merit).              % of best, in px; lower is better
fun_fluent(least_merit).        % of any estimate of this pose
fun_fluent(fruitless).          % images since the pose came nearer to being trusted
fun_fluent(rival).              % chance of another pose beside the last estimate's, where it keeps that from trust, or none
fun_fluent(undecided).          % images in a row after which it was that likely
fun_fluent(line_support(_)).    % how much of a model line the last estimate found, 0..1
fun_fluent(outlook).            % adds(Bits, Settings, Line), best first: what was predicted last
fun_fluent(richest_gamma).      % of the image appraised last: below 1 its gradients want more light
fun_fluent(surprise).           % because(Image, Cause) when the last image was not as foreseen, or none
fun_fluent(model_fault).        % wrong(Axis, Share): so much too long along an axis of its own; or none
fun_fluent(doubt).              % a cause for which the last image may not be as foreseen, or none
fun_fluent(tested).             % settings chosen since something was doubted, newest first
fun_fluent(parameter(_)).       % what the vision server was told
fun_fluent(working(_)).         % is this light alive?
fun_fluent(range).              % commanded range of the target in m, or unknown
fun_fluent(holds).              % hold(RangeM, Outcome, Fix) of an approach, newest first
fun_fluent(steps).              % what happened to each image, newest first

initially(device, unknown).
initially(threshold, unknown).
initially(max_iterations, unknown).
initially(allowed, unknown).
initially(settings, unknown).
initially(iteration, 0).
initially(taken, 0).
initially(candidate, none).
initially(statistics, unknown).
initially(applied, unknown).
initially(repeats, none).
initially(readings, []).
initially(tried, []).
initially(image_set, []).
initially(discarded, []).
initially(unfavourable, []).
initially(fix, none).
initially(measured, []).
initially(best, none).
initially(merit, Merit) :- worst_merit(Merit).
initially(least_merit, Merit) :- worst_merit(Merit).
initially(fruitless, 0).
initially(rival, none).
initially(undecided, 0).
initially(line_support(_), 0).
initially(outlook, []).
initially(richest_gamma, 1.0).
initially(surprise, none).
initially(model_fault, none).
initially(doubt, none).
initially(tested, []).
initially(parameter(_), default).
initially(working(_), true).
initially(range, unknown).
initially(holds, []).
initially(steps, []).

% ---------------------------------------------------------------- actions

prim_action(connect).                   % learn what the device can do
prim_action(choose(_)).                 % settings for the next image
prim_action(capture(_, _)).             % take an image under settings
prim_action(estimate(_)).               % the pose from these images together
prim_action(predict(_, _, _)).          % what settings of this device would add to these images, but for these states
prim_action(appraise(_)).               % under which tone curve an image's gradients would be richest
prim_action(keep(_)).                   % the candidate joins the set
prim_action(discard(_, _)).             % forget the candidate, for a reason
prim_action(avoid(_)).                  % remember a state as unfavourable
prim_action(set_parameter(_, _)).       % of the vision server
prim_action(start_over).                % forget all images of this pose
prim_action(advance(_)).                % bring the target to this range
prim_action(hold_done(_)).              % an approach's hold point ends: fixed, reached or aborted

exog_action(light_fault(_)).
exog_action(camera_fault).
exog_action(sun_changed).
exog_action(target_moved).
exog_action(surprise(_, _)).            % an image is not as foreseen, for this cause (reasoning/surprises.pl)
exog_action(doubt(_, _)).               % perhaps for this one

poss(connect, true).
poss(choose(S), and(neg(device = unknown), settings_in_range(device, S))).
poss(capture(_, S), and([candidate = none, neg(S = unknown), settings = S, taken < max_iterations, iteration < allowed])).
poss(estimate(Images), neg(Images = [])).
poss(predict(D, _, _), and(device = D, neg(D = unknown))).
poss(appraise(I), candidate = I).
poss(keep(I), and([candidate = I, neg(I = none), member(I, measured)])).
poss(discard(I, _), and(candidate = I, neg(I = none))).
poss(avoid(_), true).
poss(set_parameter(_, _), true).
poss(start_over, candidate = none).
poss(advance(_), candidate = none).
poss(hold_done(Outcome), member(Outcome, [fixed, reached, aborted])).

% ---------------------------------------------------------------- what sensing tells

senses(connect, session(Device, _, _), device, Device, true).
senses(connect, session(_, Px, _), threshold, Px, true).
senses(connect, session(_, _, N), max_iterations, N, true).
senses(connect, session(_, _, N), allowed, N, true).
senses(capture(_, _), Seen, statistics, Statistics, statistics_seen(Seen, Statistics)).
senses(capture(_, S), Seen, applied, Applied, settings_seen(Seen, S, Applied)).
senses(capture(_, _), Seen, repeats, Image, repetition_seen(Seen, Image)).
senses(capture(_, S), Seen, readings, Readings,
       and([ settings_seen(Seen, S, Applied), statistics_seen(Seen, Statistics),
             Readings = [reading(Applied, Statistics)|readings] ])).
senses(estimate(_), no_pose, fix, none, true).
senses(estimate(_), fix(P, C, Q, L), fix, fix(P, C, Q, L), true).
senses(estimate(_), fix(_, _, _, Lines), line_support(L), Support,
       member(line(L, _, Support, _), Lines)).
senses(appraise(_), Gamma, richest_gamma, Gamma, true).
senses(predict(_, _, _), Outlook, outlook, Outlook, true).

% ---------------------------------------------------------------- effects

causes_val(choose(_), settings, Lit, and(instead(iteration, device, S), lit_settings(device, S, Lit))).  % what if?
causes_val(choose(_), surprise, none, true).
causes_val(choose(_), tested, [], doubt = none).
causes_val(choose(S), tested, Settings, and(neg(doubt = none), Settings = [S|tested])).
causes_val(choose(S), settings, Lit, lit_settings(device, S, Lit)).

causes_val(capture(_, _), iteration, N, N is iteration + 1).
causes_val(capture(_, _), taken, N, N is taken + 1).
causes_val(capture(I, _), candidate, I, true).
causes_val(capture(_, _), doubt, none, true).
causes_val(capture(_, S), tried, Settings, Settings = [S|tried]).

causes_val(estimate(Images), measured, Images, true).

causes_val(keep(_), candidate, none, true).
causes_val(keep(I), image_set, Set,
           and(qualitative_state(device, settings, State), Set = [kept(I, State)|image_set])).
causes_val(keep(_), best, Fix, Fix = fix).
causes_val(keep(_), merit, Merit, merit(fix, Merit)).
causes_val(keep(I), steps, Steps, and(remark(surprise, doubt, Why), step(I, keep, Why, 1, Steps))).
causes_val(surprise(Image, Cause), surprise, because(Image, Cause), true).
causes_val(surprise(_, model_wrong(Axis, Share)), model_fault, wrong(Axis, Share), true).
causes_val(doubt(_, Cause), doubt, Cause, true).
% Light goes together with settings in another way: of what was learnt of that, the last image is true.
causes_val(surprise(_, light_dead(Light)), readings, [reading(Unlit, Statistics)],
           and(readings = [reading(Lit, Statistics)|_], unlit(device, Light, Lit, Unlit))).
causes_val(surprise(_, Cause), readings, [Last], and(light_changed(Cause), readings = [Last|_])).
causes_val(surprise(_, Cause), tried, [], light_changed(Cause)).
causes_val(surprise(_, Cause), unfavourable, [], light_changed(Cause)).
causes_val(surprise(_, light_dead(Light)), working(Light), false, true).
causes_val(surprise(_, light_dead(Light)), device, Device, without_light(device, Light, Device)).

causes_val(Judged, least_merit, Merit, and(improves(fix, least_merit), merit(fix, Merit))) :- judged(Judged).
causes_val(Judged, fruitless, 0, improves(fix, least_merit)) :- judged(Judged).
causes_val(Judged, fruitless, N, N is fruitless + 1) :- judged(Judged).
causes_val(Judged, rival, Ambiguity, held_back(fix, threshold, Ambiguity)) :- judged(Judged).
causes_val(Judged, rival, none, true) :- judged(Judged).
causes_val(Judged, undecided, N, and(still_held_back(fix, threshold, rival), N is undecided + 1)) :- judged(Judged).
causes_val(Judged, undecided, 1, held_back(fix, threshold, _)) :- judged(Judged).
causes_val(Judged, undecided, 0, true) :- judged(Judged).
judged(keep(_)).
judged(discard(_, _)).

causes_val(discard(_, _), candidate, none, true).
causes_val(discard(I, _), discarded, Images, Images = [I|discarded]).
causes_val(discard(I, Why), steps, Steps, step(I, discard, Why, 0, Steps)).

causes_val(avoid(State), unfavourable, States, States = [State|unfavourable]).
causes_val(set_parameter(Name, Value), parameter(Name), Value, true).

% A step is step(Iteration, Image, Settings, State, Decision, Reason, SetSize, Fix, RangeM).
proc(step(Image, Decision, Reason, Joins, Steps),
     and([ qualitative_state(device, applied, State),
           length(image_set, Before),
           Size is Before + Joins,
           Steps = [step(iteration, Image, applied, State, Decision, Reason, Size, fix, range)|steps] ])).

% Another scene: the images taken so far do not go with those to come.
new_scene(sun_changed).
new_scene(Event) :- new_pose(Event).
causes_val(Event, image_set, [], true) :- new_scene(Event).
causes_val(Event, repeats, none, true) :- new_scene(Event).
causes_val(Event, readings, [], true) :- new_scene(Event).
causes_val(Event, tried, [], true) :- new_scene(Event).
causes_val(Event, unfavourable, [], true) :- new_scene(Event).

% Another pose, or a fresh look at it: nothing is known of it yet.
new_pose(advance(_)).
new_pose(target_moved).
new_pose(surprise(_, target_moved)).
new_pose(start_over).
causes_val(Event, taken, 0, true) :- new_pose(Event).
causes_val(Event, best, none, true) :- new_pose(Event).
causes_val(Event, merit, Merit, true) :- new_pose(Event), worst_merit(Merit).
causes_val(Event, least_merit, Merit, true) :- new_pose(Event), worst_merit(Merit).
causes_val(Event, fruitless, 0, true) :- new_pose(Event).
causes_val(Event, rival, none, true) :- new_pose(Event).
causes_val(Event, undecided, 0, true) :- new_pose(Event).
causes_val(advance(Range), range, Range, true).
causes_val(advance(_), allowed, N, N is iteration + 2 * max_iterations).     % a look, and a fresh one
causes_val(hold_done(Outcome), holds, Holds, Holds = [hold(range, Outcome, best)|holds]).

causes_val(light_fault(Light), working(Light), false, true).
causes_val(light_fault(Light), device, Device, without_light(device, Light, Device)).
