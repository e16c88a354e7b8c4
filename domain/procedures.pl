% The vocabulary that strategies are written in: tests and procedures over the
% fluents and actions of acquisition.pl.

% ---------------------------------------------------------------- tests

% The pose is trusted.
proc(converged, and(neg(best = none), merit < threshold)).

% No more images may be taken.
proc(exhausted, or(taken >= max_iterations, iteration >= allowed)).

% More images would hardly help: eight of them show no likely pose, the last five brought a likely one no nearer to being
% trusted, four in a row left another pose as likely beside it that alone keeps it from trust, as where no line that is
% in sight tells a turn of the target, or the last is the very picture of an earlier one, as a camera that is stuck gives,
% and recorded frames that all were shown.
proc(spent,
     or([and(taken >= 8, neg(likely)), and(likely, fruitless >= 5), undecided >= 4, repeated])).

% The candidate is an earlier image's very picture, which tells nothing more.
proc(repeated, neg(repeats = none)).

% Nothing more is to be done, or nothing more may be.
proc(finished, or(converged, exhausted)).

% More than one image was kept: what one shows, another has confirmed.
proc(confirmed, and(length(image_set, Size), Size >= 2)).

% The set with the candidate is better than without it, by enough to count.
proc(improved, improves(fix, merit)).

% The candidate is worth keeping.  While the kept images show no pose, each of them
% may hold what the others lack: only where there is a pose must one improve it.
proc(worth_keeping, and(neg(repeated), or(best = none, improved))).

% The candidate takes nothing from the pose, as far as can be seen; nothing that counts, where it is trusted with it.
proc(harmless,
     and(neg(repeated),
         or([neg(likely), no_worse(fix, merit), and([merit(fix, With), With < threshold])]))).
% The pose from the kept images is rather right than wrong. One that is not tells nothing to compare an image with, or to
% foresee one.
proc(likely, and(neg(best = none), rather_right(merit))).

% The pose measured last, with the candidate, is rather right than wrong.
proc(likely_now, and([neg(fix = none), merit(fix, With), rather_right(With)])).

% Settings s worth trying next, by search over qualitative states.
proc(promising(S),
     and(kept_states(image_set, Kept),
         most_promising(device, experience(readings, Kept, unfavourable), S, _))).

% Settings s that expose the target well with all lights full.
proc(well_exposed(S),
     and(full_levels(device, Levels), best_exposure(device, readings, Levels, S))).

% Settings s under which the gradients of the image appraised last should be richer; those of now when they are rich.
proc(richer(S), relit(device, settings, richest_gamma, S)).

% The last image may not be as foreseen, and no more than three test images have been taken for that.
proc(doubted, and([neg(doubt = none), length(tested, Asked), Asked =< 3])).

% ---------------------------------------------------------------- settings

% Settings s whose image would tell what is doubted.
proc(telling(S), and(doubt = Cause, telling_settings(device, readings, Cause, tested, S))).

% The settings that were predicted to add most, of those that no image of this scene was taken under.
proc(foremost(S), and(member(adds(_, S, _), outlook), neg(member(S, tried)))).

proc(choose_random,    pi(s, [?(random_settings(device, s)), choose(s)])).
proc(choose_reference, pi(s, [?(reference_settings(device, s)), choose(s)])).
proc(choose_safe,      pi(s, [?(safest(device, s)), choose(s)])).
proc(choose_promising, pi(s, [?(promising(s)), choose(s)])).
proc(choose_telling,   if(some(s, telling(s)), pi(s, [?(telling(s)), choose(s)]), choose_informative)).

% The settings whose image is predicted to add most to the pose, line by line; promising ones while no pose is likely.
proc(choose_informative,
     if(neg(likely),
        choose_promising,
        [ look_ahead,
          if(some(s, foremost(s)), pi(s, [?(foremost(s)), choose(s)]), choose_promising) ])).
proc(look_ahead,
     pi([d, u, images],
        [ ?(and([device = d, unfavourable = u, image_names(none, image_set, images)])),
          predict(d, u, images) ])).

% ---------------------------------------------------------------- images

% Take the next image under the chosen settings.
proc(take_image,
     pi([i, s], [?(and(image_name(iteration, i), settings = s)), capture(i, s)])).

% Estimate the pose from the set and the candidate together.
proc(measure,
     pi(images, [?(image_names(candidate, image_set, images)), estimate(images)])).

proc(keep_image,  pi(i, [?(candidate = i), keep(i)])).
% Where it is a picture that was there before, or the estimate shows no pose, that is the reason, whatever a strategy
% makes of it.
proc(drop_image(Why),
     pi(i, [ ?(candidate = i),
             if(repeated,
                discard(i, 'the same picture again'),
                if(and(fix = none, member(i, measured)), discard(i, 'no pose with it'), discard(i, Why))) ])).

proc(mark_unfavourable,
     pi(state, [?(qualitative_state(device, settings, state)), avoid(state)])).

% ---------------------------------------------------------------- sessions

% One session: learn what there is, then let the strategy work.
proc(session, [connect, control]).
