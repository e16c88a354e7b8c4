% The vocabulary that strategies are written in: tests and procedures over the
% fluents and actions of acquisition.pl.

% ---------------------------------------------------------------- tests

% The pose is trusted.
proc(converged, and(neg(best = none), merit =< threshold)).

% No more images may be taken.
proc(exhausted, taken >= max_iterations).

% Nothing more is to be done, or nothing more may be.
proc(finished, or(converged, exhausted)).

% More than one image was kept: what one shows, another has confirmed.
proc(confirmed, and(length(image_set, Size), Size >= 2)).

% The set with the candidate is better than without it, by enough to count.
proc(improved, improves(fix, merit)).

% The candidate is worth keeping.  While the kept images show no pose, each of them
% may hold what the others lack: only where there is a pose must one improve it.
proc(worth_keeping, or(best = none, improved)).

% Settings s worth trying next, by search over qualitative states.
proc(promising(S),
     and(kept_states(image_set, Kept),
         most_promising(device, experience(readings, Kept, unfavourable), S, _))).

% Settings s that expose the target well with all lights full.
proc(well_exposed(S),
     and(full_levels(device, Levels), best_exposure(device, readings, Levels, S))).

% ---------------------------------------------------------------- settings

proc(choose_random,    pi(s, [?(random_settings(device, s)), choose(s)])).
proc(choose_reference, pi(s, [?(reference_settings(device, s)), choose(s)])).
proc(choose_promising, pi(s, [?(promising(s)), choose(s)])).

% ---------------------------------------------------------------- images

% Take the next image under the chosen settings.
proc(take_image,
     pi([i, s], [?(and(image_name(iteration, i), settings = s)), capture(i, s)])).

% Estimate the pose from the set and the candidate together.
proc(measure,
     pi(images, [?(image_names(candidate, image_set, images)), estimate(images)])).

proc(keep_image,  pi(i, [?(candidate = i), keep(i)])).
% Where the estimate shows no pose that is the reason, whatever a strategy makes of it.
proc(drop_image(Why),
     pi(i, [ ?(candidate = i),
             if(and(fix = none, member(i, measured)), discard(i, 'no pose with it'), discard(i, Why)) ])).

proc(mark_unfavourable,
     pi(state, [?(qualitative_state(device, settings, state)), avoid(state)])).

% ---------------------------------------------------------------- sessions

% One session: learn what there is, then let the strategy work.
proc(session, [connect, control]).
