"""Whether a pose that came from elsewhere is right, and what pose nearby would be better."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera
from geometry.model import Model
from geometry.near_symmetries import near_symmetries
from geometry.pose import Pose
from vision_server.image_set import ImageSet
from vision_server.pipeline import PipelineSettings, estimate_pose
from vision_server.pose.covariance import pose_covariance, uncertainty
from vision_server.pose.line_scales import line_scales
from vision_server.pose.observation import PoseProblem
from vision_server.pose.ranking import FINE_REACHES_PX, refined
from vision_server.pose.refinement import REACHES_PX
from vision_server.pose.sampling import spacing_for
from vision_server.pose.support import PoseSupport, support_at
from vision_server.pose.trust import confidence, quality

Floats = NDArray[np.float64]
Verdict = Literal["ok", "doubtful", "lost"]

OK, LOST = 0.8, 0.2  # probabilities from which on, and below which
LIMITS = (1.0, 0.01)  # degrees, share of the range: a pose is right within them
DRAWS = 400  # of the better pose from its covariance
BOUND_99 = 16.81  # of a squared difference of six dimensions in units of its covariance
LEAST_ODDS = 1e-4  # probabilities are never taken for surer than this
# Logistic regression on simulated frames, poses right and wrong: python -m benchmarks.referee --fit
WEIGHTS = (-2.45, 0.34, 0.53, -0.13)
EVEN_AMBIGUITY = 0.6  # share of the quality of a turned pose, from which on it is a rival
MOST_HALVINGS = 6.0  # of the quality, beyond which nothing more is told
DISAGREES = 0.25  # a line with less of its visible length supported


@dataclass(frozen=True, eq=False)
class Evidence:
    """What the images say of a pose and of the best one around it.

    Attributes
    ----------
    believed : probability that the best pose is right, were there no other given.
    within : probability that the given pose is right if the best one is, by its covariance.
    worth : quality of the given pose as a share of the best one's.
    turned : quality of the best turn onto a near symmetry of the target as a share of the best pose's; 0
        where the target has none.
    """

    believed: float
    within: float
    worth: float
    turned: float


@dataclass(frozen=True, eq=False)
class Judgement:
    """What is said of a pose.

    Attributes
    ----------
    probability : that it is right to 1 degree and 1 % of the range.
    better : the pose that explains the images best, where the given one differs from it by more than its
        covariance (6, 6) allows; None where it does not, or where nothing can be believed.
    disagreeing : model lines that should be seen and are not.
    """

    probability: float
    better: Pose | None
    covariance: Floats | None
    disagreeing: tuple[int, ...]
    evidence: Evidence | None

    @property
    def state(self) -> Verdict:
        """In one word."""
        if self.probability >= OK:
            return "ok"
        return "lost" if self.probability < LOST else "doubtful"


@dataclass(frozen=True, eq=False)
class _Best:
    """The best pose around a given one."""

    pose: Pose
    covariance: Floats
    quality: float
    believed: float


def judged(
    images: ImageSet,
    names: Sequence[str],
    model: Model,
    camera: Camera,
    pose: Pose,
    settings: PipelineSettings = PipelineSettings(),
) -> Judgement:
    """Judge a pose by images of one set.

    The pose is compared with what refinement makes of it, and with the best pose in the search range around.

    Raises
    ------
    BadInput
        No images, or an unknown one.
    GeometryError
        A pose behind the camera.
    """
    images.check(names)
    problem = PoseProblem.at_scale(images.gradients(names), model, camera, 0, settings.tone_sd_px)
    problem = replace(problem, scale=line_scales(problem, pose))
    spacing = spacing_for(model, camera, pose)
    given = support_at(problem, pose, spacing)
    best = _best(problem, images, names, pose, settings)
    missing = () if given is None else _disagreeing(given)
    if given is None or best is None:
        return Judgement(0.0, None, None, missing, None)
    worth = min(1.0, quality(given) / best.quality)
    evidence = Evidence(best.believed, _within(best, pose), worth, _turned(problem, best, spacing))
    differs = squared_difference(pose, best.pose, best.covariance) > BOUND_99
    better = best.pose if differs and best.believed > LOST else None
    return Judgement(probability(evidence), better, best.covariance, missing, evidence)


def terms(evidence: Evidence) -> tuple[float, ...]:
    """What the probability is a logistic function of, see WEIGHTS."""
    worth = math.log2(max(evidence.worth, 2.0**-MOST_HALVINGS))
    return 1.0, _odds(evidence.believed), _odds(evidence.within), worth


def probability(evidence: Evidence) -> float:
    """Of being right, calibrated; where a turned target would look much alike, one of two at most."""
    logit = sum(weight * term for weight, term in zip(WEIGHTS, terms(evidence), strict=True))
    alike = max(0.0, min(evidence.turned, 1.0) - EVEN_AMBIGUITY) / (1.0 - EVEN_AMBIGUITY)
    return min(1.0 / (1.0 + math.exp(-logit)), (1.0 - 0.5 * alike) / max(1.0, evidence.turned))


def _odds(value: float) -> float:
    """Logarithm of the odds."""
    value = min(max(value, LEAST_ODDS), 1.0 - LEAST_ODDS)
    return math.log(value / (1.0 - value))


def _best(
    problem: PoseProblem, images: ImageSet, names: Sequence[str], pose: Pose, settings: PipelineSettings
) -> _Best | None:
    """What refinement makes of the pose, or what a search around it finds: what explains more."""
    found = []
    wide = estimate_pose(images, names, problem.model, problem.camera, pose, settings)
    if wide.pose is not None and wide.support is not None and wide.covariance is not None:
        found.append(_Best(wide.pose, wide.covariance, quality(wide.support), wide.score))
    spacing = spacing_for(problem.model, problem.camera, pose)
    near = refined(problem, pose, (*REACHES_PX, *FINE_REACHES_PX), spacing)
    if near is not None:
        covariance = pose_covariance(near.solution)
        spread = uncertainty(covariance, near.pose.translation)
        believed = confidence(near.support, wide.ambiguity, spread)
        found.append(_Best(near.pose, covariance, near.quality, believed))
    held = [one for one in found if one.quality > 0.0]
    return max(held, key=lambda one: one.quality, default=None)


def _turned(problem: PoseProblem, best: _Best, spacing_px: float) -> float:
    """How well the images bear a turn of the target onto a near symmetry, beside the best pose."""
    poses = (best.pose.compose(turn) for turn in near_symmetries(problem.model))
    supports = (support_at(problem, pose, spacing_px) for pose in poses)
    return max((quality(one) for one in supports if one is not None), default=0.0) / best.quality


def _within(best: _Best, pose: Pose) -> float:
    """Share of the poses that the best one may stand for, of which the given one is within LIMITS."""
    rng = np.random.default_rng(0)
    steps = rng.multivariate_normal(np.zeros(6), best.covariance, DRAWS, method="eigh")
    near = sum(pose.error_to(best.pose.stepped(step)).within(*LIMITS) for step in steps)
    return (near + 0.5) / (DRAWS + 1)


def squared_difference(one: Pose, other: Pose, covariance: Floats) -> float:
    """Squared length of the step from the other pose to the one, in units of a covariance (6, 6)."""
    turn = one.compose(other.inverse())
    step = np.r_[turn.rotation_vector, one.translation - turn.matrix @ other.translation]
    return float(step @ np.linalg.solve(covariance, step))


def _disagreeing(support: PoseSupport) -> tuple[int, ...]:
    return tuple(line.line for line in support.lines if line.support < DISAGREES)
