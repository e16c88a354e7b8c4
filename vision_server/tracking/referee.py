"""Whether a pose that came from elsewhere is right, and what pose nearby would be better.

In go images and the pose; out comes a probability by Bayes' rule over the poses around it (`chances`): what
refinement makes of it, what a search finds, and turns of that, each with covariance and evidence.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from geometry.camera import Camera
from geometry.model import Model, about_middle
from geometry.near_symmetries import near_symmetries
from geometry.pose import RIGHT, Pose, PoseError
from geometry.turns import right_turns, turns_about_round_axes
from numerics.arrays import Floats
from numerics.two_cores import each
from vision_server.image_set import ImageSet
from vision_server.pipeline import PipelineSettings, pose_of_segments
from vision_server.pose.covariance import pose_covariance, share_within, uncertainty
from vision_server.pose.line_scales import with_line_scales
from vision_server.pose.observation import PoseProblem
from vision_server.pose.refinement import EXACT_REACH_PX, REACHES_PX, refine
from vision_server.pose.sampling import spacing_for
from vision_server.segments.extraction import extract_segments
from vision_server.tracking.beside import beside
from vision_server.tracking.chances import LEAST_ODDS, Chance, Chances, agreement, of_images, probability
from vision_server.tracking.fitting import Habits, fitted
from vision_server.tracking.following import MOST_PASSES, SETTLED_PX
from vision_server.trust.judgement import Estimate
from vision_server.trust.probability import ERROR_OVER_SD, RIVAL_NATS, confidence, quality
from vision_server.trust.ranking import COARSENING, FINE_REACHES_PX, ONE_BASIN, TURNED_LACK_NATS, refined
from vision_server.trust.spun import spun
from vision_server.trust.support import PoseSupport, evidence_at, support_at

Verdict = Literal["ok", "doubtful", "lost"]


OK_FROM, LOST_BELOW = 0.8, 0.2  # of what is told, by hand: from the first on, below the second
BETTER_FROM = 0.5  # probability of another pose from which on it is told: rather right than wrong
CHI2_99 = 16.81  # of a squared difference of six dimensions in units of its covariance: 1 % are larger
LOOK_ALIKE_DEG = 20.0  # between poses that programs take for each other; nearer is an error of measurement
CONFUSED_ODDS = 1.0 / 3.0  # assumed: how often a pose from elsewhere is at such another one, for once right
UNHELD_TIMES_RIGHT = 1e3  # what refinement is said to move a pose by where nothing holds it, in RIGHT
MOST_TURNS_REFINED = 4  # by hand: each takes as long as the pose itself
DISAGREEING_SUPPORT = 0.25  # of its visible length, below which a line disagrees (by hand)


@dataclass(frozen=True, eq=False)
class Judgement:
    """What is said of a pose.

    Attributes
    ----------
    probability : that it is right to 1 degree and 1 % of the range.
    better : the pose around the given one that explains the images best, where that differs from it by more
        than its covariance (6, 6) allows; None where it does not, or is rather wrong.
    better_probability : that the better one is right, or None.
    difference : of the given pose from the better one, at the model's pivot.
    disagreeing : model lines that should be seen and are not.
    chances : what the probability is of.
    """

    probability: float
    better: Pose | None
    better_probability: float | None
    difference: PoseError | None
    covariance: Floats | None
    disagreeing: tuple[int, ...]
    chances: Chances

    @property
    def state(self) -> Verdict:
        """In one word."""
        if self.probability >= OK_FROM:
            return "ok"
        return "lost" if self.probability < LOST_BELOW else "doubtful"


@dataclass(frozen=True, eq=False)
class Around:
    """A pose that may be the right one: covariance (6, 6), evidence in nats, and how far it is believed."""

    pose: Pose
    covariance: Floats
    nats: float
    quality: float
    believed: float


def judged(
    images: ImageSet,
    names: Sequence[str],
    model: Model,
    camera: Camera,
    pose: Pose,
    settings: PipelineSettings = PipelineSettings(),
    endpoints: Floats | None = None,
    edge_radius_m: float | None = None,
) -> Judgement:
    """Judge a pose by images of one set; ``endpoints`` (N, 4) px of its segments spare finding them again.

    The pose is compared with what refinement makes of it, with what a search around it finds, and with turns
    of that onto near symmetries of the target. ``edge_radius_m`` is that of the target's rounded edges, where
    it is known.

    Raises
    ------
    BadInput
        No images, or an unknown one.
    GeometryError
        A pose behind the camera.
    """
    centred, to_middle = about_middle(model)
    if centred is not model:
        pose = pose.compose(to_middle)
        found = judged(images, names, centred, camera, pose, settings, endpoints, edge_radius_m)
        better = None if found.better is None else found.better.compose(to_middle.inverse())
        return replace(found, better=better)
    images.check(names)
    problem = PoseProblem.at_scale(
        images.gradients(names), model, camera, 0, settings.tone_sd_px, settings.tolerance_m
    )
    problem = with_line_scales(problem, pose)
    given = support_at(problem, pose, spacing_for(model, camera, pose))
    missing = () if given is None else _disagreeing(given)
    if endpoints is None:
        endpoints = extract_segments(images.edge_map(names)).endpoints
    wide = pose_of_segments(endpoints, problem.channels, model, camera, pose, settings)
    around = _poses_around(problem, wide, pose, edge_radius_m)
    if given is None or not around:
        return Judgement(0.0, None, None, None, None, missing, Chances((), UNHELD_TIMES_RIGHT))
    best = around[0]
    chances = Chances(chances_of(around, pose), moved_by(problem, pose))
    differs = squared_difference(pose, best.pose, best.covariance) > CHI2_99
    believed = of_images(chances_of(around, best.pose)) if differs else 0.0
    if believed < BETTER_FROM:
        return Judgement(probability(chances), None, None, None, best.covariance, missing, chances)
    difference = pose.error_to(best.pose)
    return Judgement(probability(chances), best.pose, believed, difference, best.covariance, missing, chances)


def _poses_around(
    problem: PoseProblem, wide: Estimate, pose: Pose, edge_radius_m: float | None
) -> list[Around]:
    """All poses that the given one may be mistaken for or is, the likeliest first; none twice.

    ``wide`` is what a search around the given pose finds.
    """
    found: list[Around] = []
    if wide.pose is not None and wide.support is not None and wide.covariance is not None:
        believed = wide.score * (1.0 + wide.ambiguity)
        own = wide.support.evidence_together
        found.append(Around(wide.pose, wide.covariance, own, quality(wide.support), believed))
        for rival in wide.rivals:
            nats = own + RIVAL_NATS * math.log(max(rival.share, LEAST_ODDS))
            found.append(Around(rival.pose, wide.covariance, nats, 0.0, believed))
    found += _refined(problem, [pose])
    if found:
        found += _turned(problem, max(found, key=lambda one: one.nats))
    distinct: list[Around] = []
    for one in sorted(found, key=lambda one: -one.quality):
        if not any(one.pose.error_to(other.pose).within(*ONE_BASIN) for other in distinct):
            distinct.append(one)
    distinct.sort(key=lambda one: -one.nats)
    worth = [one for one in distinct if one.nats > distinct[0].nats + RIVAL_NATS * math.log(LEAST_ODDS)]
    habits = Habits.of(problem.model, edge_radius_m)
    return sorted((_on_lines(problem, one, habits) for one in worth), key=lambda one: -one.nats)


def _refined(problem: PoseProblem, poses: Sequence[Pose]) -> list[Around]:
    """What refinement makes of poses."""
    found = []
    for pose in poses:
        spacing = spacing_for(problem.model, problem.camera, pose)
        near = refined(problem, pose, (*REACHES_PX, *FINE_REACHES_PX), spacing)
        if near is not None:
            covariance = pose_covariance(near.solution)
            spread = uncertainty(covariance, near.pose.translation)
            believed = confidence(near.support, 0.0, spread)
            nats = near.support.evidence_together
            found.append(Around(near.pose, covariance, nats, near.quality, believed))
    return found


def _on_lines(problem: PoseProblem, one: Around, habits: Habits) -> Around:
    """The pose fitted to whole lines, whose covariance knows what they are off by more than noise.

    Where too few are seen for that, the covariance is that of edge points, and its tails. The evidence is the
    most that it has before and after: of a lattice that differs by ten nats, which tell no poses apart.
    """
    problem = with_line_scales(problem, one.pose)
    spacing = spacing_for(problem.model, problem.camera, one.pose)
    variance = beside(problem, one.pose).variance_px2
    one = replace(one, covariance=ERROR_OVER_SD**2 * one.covariance)
    for _ in range(MOST_PASSES):
        fit = fitted(problem, one.pose, EXACT_REACH_PX, spacing, habits, variance)
        if fit is None:
            break
        one = replace(one, pose=fit.pose, covariance=fit.covariance)
        if fit.moved_px < SETTLED_PX:
            break
    return replace(one, nats=max(one.nats, evidence_at(problem, one.pose, spacing)))


def _turned(problem: PoseProblem, best: Around) -> list[Around]:
    """The best pose turned onto near symmetries of the target or of parts of it, refined where as likely.

    Of a nearly round target it is turned all around, as far as its bolts or lugs tell, and where they do not.
    """
    model, spacing = problem.model, spacing_for(problem.model, problem.camera, best.pose)
    turns = (*near_symmetries(model), *right_turns(model), *turns_about_round_axes(model))
    poses = [best.pose.compose(turn) for turn in dict.fromkeys(turns)]
    least = evidence_at(problem, best.pose, COARSENING * spacing) - TURNED_LACK_NATS
    poses += spun(problem, best.pose, COARSENING * spacing, math.pi)
    seen = zip(each(lambda pose: evidence_at(problem, pose, COARSENING * spacing), poses), poses, strict=True)
    promising = sorted((one for one in seen if one[0] > least), key=lambda one: -one[0])
    return _refined(problem, [pose for _, pose in promising[:MOST_TURNS_REFINED]])


def chances_of(around: Sequence[Around], pose: Pose) -> tuple[Chance, ...]:
    """What speaks for a pose, of each pose around.

    Other programs, too, take one pose for another that looks alike: were the target at the one, the given
    pose might be at the other. Of two that explain as much the given one is believed three quarters at most.
    """
    nats = np.array([one.nats for one in around]) / RIVAL_NATS
    shares = np.exp(nats - nats.max())
    shares /= shares.sum()
    agreements = [agreement(RIGHT, one.pose, one.covariance, pose) for one in around]
    chances = []
    for share, one, own in zip(shares, around, agreements, strict=True):
        alike = CONFUSED_ODDS * sum(
            other.likelihood
            for rival, other in zip(around, agreements, strict=True)
            if rival.pose.error_to(one.pose).rotation_deg > LOOK_ALIKE_DEG
        )
        within = share_within(RIGHT, one.pose, one.covariance, pose)
        told = own._replace(likelihood=own.likelihood + float(alike))
        chances.append(Chance(float(share), one.believed, within, told))
    return tuple(chances)


def moved_by(problem: PoseProblem, pose: Pose) -> float:
    """How far images move a pose that is nearly there, in RIGHT; UNHELD_TIMES_RIGHT where none holds it."""
    spacing = spacing_for(problem.model, problem.camera, pose)
    found = refine(problem, pose, (EXACT_REACH_PX,), spacing)
    if found is None:
        return UNHELD_TIMES_RIGHT
    error = found.pose.error_to(pose)
    return max(error.rotation_deg / RIGHT[0], error.translation_fraction_of_range / RIGHT[1])


def squared_difference(one: Pose, other: Pose, covariance: Floats) -> float:
    """Squared length of the step from the other pose to the one, in units of a covariance (6, 6)."""
    step = one.step_from(other)
    return float(step @ np.linalg.solve(covariance, step))


def _disagreeing(support: PoseSupport) -> tuple[int, ...]:
    return tuple(line.line for line in support.lines if line.support < DISAGREEING_SUPPORT)
