"""The last step of a pose: lines as wholes, most of which are off by little, and a few by much.

What a line is off as a whole (`courses`) has a heavy-tailed distribution, Student's t: a few lines that lie a
pixel beside their place, on a shadow's edge, no longer outvote many that agree to a twentieth of one.

A part whose axes are a little longer or shorter than the model's moves all lines, and no line stands out. Two
scales, of its axes against each other, are unknowns too, with a spread that the lines themselves tell: none,
unless they clearly ask for one. So is how round the part is beyond its model's facets (`roundness`).
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from geometry.model import Model
from geometry.pose import RIGHT, Pose
from numerics.arrays import Floats
from vision_server.pose.chords import beyond_chords
from vision_server.pose.courses import BLUR, ROUNDNESS, Courses, courses_of
from vision_server.pose.covariance import about_camera
from vision_server.pose.observation import Observation, observe
from vision_server.pose.refinement import EXACT_REACH_PX, prior_precision
from vision_server.pose.steps import moved
from vision_server.trust.probability import LineAgreement
from vision_server.trust.ranking import Refined
from vision_server.trust.roundness import has_facets, how_round, told_roundness, without_roundness
from vision_server.trust.stretch import BETWEEN_AXES, motion_of_strains
from vision_server.trust.support import support_at
from vision_server.trust.tails import Held, with_tails
from vision_server.trust.tolerance import are_off, of_lines_off, with_tolerance

# By hand where nothing else is said: halved or doubled (`python -m benchmarks.constants`, 27 sets of recorded
# and hard stacks) none up to MOST_STRETCH changes which poses are right or tight, nor errors by more than 7
# percent; with SAME_PART_STRETCH halved three fewer are trusted. Those below were not varied. Degrees of
# freedom of Student's t: between 1 and 3 the tight ones of 350 estimates change by 3 at most.
T_FREEDOM = 1.5
SETTLING_ROUNDS = 2  # of looking and stepping; one makes errors 1.04 times as large, four 0.99 times
MOST_SETTLING_STEPS, SETTLED_SIGMAS = 30, 1e-3  # of reweighting; one no longer than that of an sd is the last
BLUR_PRECISION = 1.0  # of the blur of outlines, whose unit is its own sd
AXES_OF_BETWEEN = np.linalg.pinv(BETWEEN_AXES)  # scales of the axes, from those of one against another
# Of the logarithm of one axis' scale over another's, sd: what is none, and what is tried where that many nats
# speak for it (by hand).
UNSTRETCHED_SD, STRETCH_SDS, STRETCH_NATS = 2e-4, (1e-3, 2e-3, 4e-3, 8e-3, 1.6e-2), 3.0
# Of an axis against another. A part that is off by more than the first is another one, and its lines are
# judged as they lie by so much; up to the second it is nevertheless found where it is seen.
SAME_PART_STRETCH, MOST_STRETCH = 0.015, 0.03
# By hand, from the normalised errors of 846 right poses of drawn scenes and hard stacks: the covariance is so
# many times the lines' scatter over what was foreseen and this more, times that power of the mean spread, px,
# as soft lines are off together. At least this: a tone curve that is not quite known moves all lines alike.
COVARIANCE_PER_SCATTER, SCATTER_ADDED, COVARIANCE_SPREAD_POWER, LEAST_COVARIANCE_FACTOR = 6.7, 0.1, 0.6, 0.6
SCATTER_STEPS, SCATTER_STILL = 60, 1e-3  # of its reweighting, at most and until its logarithm is so still
STRETCH = slice(BLUR + 1, ROUNDNESS)  # which unknowns are stretches
AGREES_CHI2 = 6.0  # squared distance of a line from its place: 95 % of chi-square's of two degrees of freedom


class Settled(NamedTuple):
    """A pose that was settled, and the covariance (6, 6) of a small left-multiplied step (rad, m).

    Of the ``agreement``, the share is that of the visible length on lines that are where the pose has them,
    as far as they may be off, and the scatter how far lines are off, squared, over what was foreseen; None
    for a pose that has not taken this step.
    """

    best: Refined
    covariance: Floats
    agreement: LineAgreement | None = None


class Round(NamedTuple):
    """One look at the images from a pose, and the step it asks for.

    Attributes
    ----------
    pose
        After the step.
    seen, courses
        From before it, and what they say of each line.
    prior : (9,), see `agreed`.
    step, spread : (K,) and (K, K), unknowns and their covariance.
    exact : courses and unknowns of a part that is its model; by these it is judged whether lines agree.
    """

    pose: Pose
    seen: Observation
    courses: Courses
    prior: Floats
    step: Floats
    spread: Floats
    exact: tuple[Courses, Floats]


def _one_round(best: Refined, pose: Pose) -> Round | None:
    """A look from a pose, with the problem of a refined one; None where too little holds it."""
    problem = best.problem
    seen = observe(problem, pose, EXACT_REACH_PX, best.spacing_px)
    strains = motion_of_strains(seen.samples, seen.jacobian, problem.model, pose)[:, :3]
    rounded = beyond_chords(problem.model, pose, seen.samples, seen.jacobian)
    courses = courses_of(problem, seen, np.hstack([strains @ AXES_OF_BETWEEN, rounded]))
    if not len(courses.share):
        return None
    range_m = float(np.linalg.norm(pose.translation))
    prior = np.r_[prior_precision(range_m, best.solution.tone_sd_px), BLUR_PRECISION]
    courses, step, spread = _fitted(courses, prior)
    exact = courses, step
    if (untold_m := problem.untold_tolerance_m) > 0.0 and are_off(courses, step, untold_m, T_FREEDOM):
        courses, step, spread = _fitted(with_tolerance(courses, untold_m), prior)
    pose = moved(pose, step[:6], seen.centre)
    if not np.isfinite(step).all() or not pose.apply(problem.model.vertices)[:, 2].max() > 0:
        return None
    return Round(pose, seen, courses, prior, step, spread, exact)


def last_round(best: Refined, start: Pose) -> Round | None:
    """The last of SETTLING_ROUNDS from a start; None where too little holds one of them."""
    last, pose = None, start
    for _ in range(SETTLING_ROUNDS):
        last = _one_round(best, pose)
        if last is None:
            return None
        pose = last.pose
    return last


def settled(best: Refined) -> Settled | None:
    """A refined pose, moved by the last step; None where too little holds it."""
    last = last_round(best, best.pose)
    if last is None:
        return None
    problem = best.problem
    pose, seen, courses, prior, step, spread, exact = last
    support = support_at(replace(problem, roundness=how_round(step)), pose, best.spacing_px)
    if support is None:
        return None
    best = replace(best, solution=replace(best.solution, pose=pose), support=support)
    visible = np.asarray(np.bincount(seen.samples.line, seen.samples.px), np.float64)
    held, squares = _judged(courses, step, prior)
    agreement = _agreement(courses, squares, visible)
    factor = as_seen(agreement.scatter, courses)
    fixed = len(prior)  # stretches and roundness stay as they are
    place = held.place - held.motion[:, :, fixed:] @ step[fixed:]
    held = held._replace(place=place, motion=held.motion[:, :, :fixed])
    wide = with_tails(factor * spread[:6, :6], limits_of(pose), held, step[:fixed], factor)
    if is_stretched(spread):
        wide += factor * (of_true_range(pose, problem.model, step, spread) - spread[:6, :6])
    if courses is not exact[0]:  # lines have asked for the tolerance
        agreement = _agreement(exact[0], _judged(*exact, prior)[1], visible)
    elif problem.untold_tolerance_m > 0.0:
        wide += of_lines_off(held, step[:fixed], courses, problem.untold_tolerance_m)
    covariance = about_camera(wide, seen.centre)
    best = replace(best, solution=replace(best.solution, pose=of_true_axes(pose, problem.model, step)))
    return Settled(best, covariance, agreement)


def _judged(courses: Courses, step: Floats, prior: Floats) -> tuple[Held, Floats]:
    """What holds the pose, and squared distances (M,) of the lines from where a pose that may be has them."""
    held = _held(courses, prior)
    if _stretch(step) > SAME_PART_STRETCH:
        step = agreed(courses, prior, SAME_PART_STRETCH)[0]
    return held, held.squares(step)


def limits_of(pose: Pose) -> Floats:
    """What makes a pose wrong of each part (6,) of a step: a degree, rad, and 1 % of its range, m."""
    range_m = float(np.linalg.norm(pose.translation))
    return np.array([math.radians(RIGHT[0])] * 3 + [RIGHT[1] * range_m] * 3)


def _fitted(courses: Courses, prior: Floats) -> tuple[Courses, Floats, Floats]:
    """Courses, unknowns and covariance as of `agreed`, those of a part with facets where it has them."""
    step, spread = agreed(courses, prior)
    if has_facets(step, spread):
        courses = without_roundness(courses)
        step, spread = agreed(courses, prior)
    return courses, step, spread


def of_true_axes(pose: Pose, model: Model, step: Floats) -> Pose:
    """The pose at the range at which most axes of a stretched part are as the model has them.

    A scale of all axes is the same as another range. In ``step`` the scales have a mean of none, by which all
    would share what one axis is too long. Where one alone is off, the other two tell the range.
    """
    nearer = math.exp(-float(_true_axis(step) @ step[STRETCH]))
    middle = pose.apply(model.middle[None])[0]
    return Pose(pose.rotation_vector, pose.translation + (nearer - 1.0) * middle)


def of_true_range(pose: Pose, model: Model, step: Floats, spread: Floats) -> Floats:
    """The covariance (6, 6) of a step to `of_true_axes`, from that of unknowns (K, K).

    The range there is as uncertain as is the scale of the axis that it is told by.
    """
    to_range = np.eye(6, len(spread))
    to_range[3:, STRETCH] = -np.outer(pose.apply(model.middle[None])[0], _true_axis(step))
    return np.asarray(to_range @ spread @ to_range.T)


def _true_axis(step: Floats) -> Floats:
    """What makes of the stretches (2,) in unknowns (K,) the scale of the axis that is nearest the model's."""
    axes = AXES_OF_BETWEEN @ step[STRETCH]
    return np.asarray(AXES_OF_BETWEEN[np.argsort(axes)[1]])


def is_stretched(spread: Floats) -> bool:
    """Whether unknowns of covariance (K, K) are those of a part whose axes may be longer than the model's."""
    return bool(spread[STRETCH, STRETCH].trace() > 2.0 * UNSTRETCHED_SD**2)


def _stretch(step: Floats) -> float:
    """How much one axis is stretched against another by unknowns (K,), as a logarithm."""
    return float(np.ptp(AXES_OF_BETWEEN @ step[STRETCH]))


def agreed(courses: Courses, prior: Floats, most: float = MOST_STRETCH) -> tuple[Floats, Floats]:
    """The likeliest unknowns (K,) and their covariance (K, K).

    Parameters
    ----------
    prior
        (9,), precision of all but roundness and the two stretches, whose spread is the likeliest of
        STRETCH_SDS or none.
    most
        One axis is stretched against another.
    """
    held = _held(courses, prior)
    roundness, pull = told_roundness(courses)
    pull = np.r_[np.zeros(ROUNDNESS), pull]
    best, least = None, np.inf
    for sd in (UNSTRETCHED_SD, *STRETCH_SDS):
        held = held._replace(prior=np.r_[prior, sd**-2.0, sd**-2.0, roundness])
        step, covariance, nats = _at_stretch(held, pull, best)
        if best is not None and _stretch(step) > most:
            break  # another part
        nats += 2.0 * np.log(sd / UNSTRETCHED_SD) - 0.5 * float(np.linalg.slogdet(covariance)[1])
        nats += STRETCH_NATS if sd > UNSTRETCHED_SD else 0.0
        if best is None or nats < least:
            best, least = (step, covariance), nats
    assert best is not None
    return best


def _held(courses: Courses, prior: Floats) -> Held:
    """The courses, in units of how far off they may be as wholes."""
    white = np.linalg.inv(np.linalg.cholesky(courses.variance))
    place = np.einsum("mij,mj->mi", white, courses.place)
    return Held(place, white @ courses.motion, courses.share, prior, T_FREEDOM)


def _agreement(courses: Courses, squares: Floats, visible: Floats) -> LineAgreement:
    """How far lines agree of which ``squares`` (M,) are told, of a visible length (L,)."""
    agree = np.where(squares < AGREES_CHI2, courses.share, 0.0)
    share = float(agree @ visible[courses.line] / visible.sum())
    return LineAgreement(share, scatter_of(squares, courses.share))


def scatter_of(squares: Floats, share: Floats) -> float:
    """The likeliest factor on the variances that courses were foreseen to have.

    Parameters
    ----------
    squares, share
        (M,), see `Held.squares`, and what each counts. Iteratively reweighted, for Student's t.
    """
    scatter = 1.0
    for _ in range(SCATTER_STEPS):
        weight = (T_FREEDOM + 2.0) / (T_FREEDOM + squares / scatter)
        before, scatter = scatter, max(float(share @ (weight * squares)) / (2.0 * float(share.sum())), 1e-6)
        if abs(math.log(scatter / before)) < SCATTER_STILL:
            break
    return scatter


def as_seen(scatter: float, courses: Courses) -> float:
    """The factor on a pose's covariance, by what its lines are off, and by how far off they may be."""
    spread = math.exp(float(np.average(np.log(courses.spread), weights=courses.share)))
    return max(
        LEAST_COVARIANCE_FACTOR,
        COVARIANCE_PER_SCATTER * (scatter + SCATTER_ADDED) * float(spread**COVARIANCE_SPREAD_POWER),
    )


def _at_stretch(
    held: Held, pull: Floats, start: tuple[Floats, Floats] | None
) -> tuple[Floats, Floats, float]:
    """Unknowns, covariance, and -ln of what is likely, by iteratively reweighted least squares.

    ``pull`` (K,) is the prior's precision times its mean.
    """
    step = np.zeros(len(pull)) if start is None else start[0]
    for _ in range(MOST_SETTLING_STEPS):
        squares = held.squares(step)
        normal, right = held.equations(squares)
        before, step = step, np.asarray(np.linalg.solve(normal, right + pull), np.float64)
        if (step - before) @ normal @ (step - before) < SETTLED_SIGMAS**2:
            break
    return step, np.asarray(np.linalg.inv(normal), np.float64), held.nats(squares, step) - float(step @ pull)
