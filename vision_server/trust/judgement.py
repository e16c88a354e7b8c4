"""What is said of a pose that was found: how sure it is right, how exact it is, and which others may be."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from geometry.pose import Pose
from geometry.symmetries import Symmetry
from numerics.arrays import Floats
from vision_server.pose.covariance import uncertainty
from vision_server.pose.line_scales import with_line_scales
from vision_server.pose.observation import PoseProblem
from vision_server.trust.alternatives import PoseChance, listed, without_free_turn
from vision_server.trust.likely import Likely
from vision_server.trust.other_hand import Matcher, the_other_way
from vision_server.trust.probability import (
    WORTH_DOUBTING,
    WORTH_TURNING,
    LineAgreement,
    Misfit,
    ambiguity,
    confidence,
    odds,
)
from vision_server.trust.ranking import Refined
from vision_server.trust.restarts import astray
from vision_server.trust.rivals import RivalPose
from vision_server.trust.settling import Settled
from vision_server.trust.stretch import misfit
from vision_server.trust.support import LineSupport, PoseSupport, support_at

LEAST_BY_LINES = 0.02  # belief in a pose by its lines; of those that had less, one in a hundred was right
LEAST_STATED = 0.02  # what a score counts as, at least, in the spread that is stated; by hand


@dataclass(frozen=True, eq=False)
class Rival:
    """Another pose that explains the images, and its chance over the estimate's, at most 1."""

    pose: Pose
    share: float


@dataclass(frozen=True, eq=False)
class Estimate:
    """What the images of a set say about the target's pose; see docs/pose.md for each value.

    Without a pose, covariance, rms_px and uncertainty are None too. ``poses`` are all that fit, where nothing
    was known of the pose; ``free`` the axes that the target may be turned about unseen, in its frame.
    """

    pose: Pose | None = None
    covariance: Floats | None = None
    rms_px: float | None = None
    uncertainty: float | None = None
    supported_fraction: float = 0.0
    score: float = 0.0
    ambiguity: float = 0.0
    lines: tuple[LineSupport, ...] = ()
    rivals: tuple[Rival, ...] = ()
    poses: tuple[PoseChance, ...] = ()
    free: tuple[Floats, ...] = ()
    segments: int = 0
    seconds: dict[str, float] = field(default_factory=dict)
    support: PoseSupport | None = None
    misfit: Misfit | None = None
    agreement: LineAgreement | None = None


def judged(
    first: Refined,
    last: Settled,
    rivals: list[RivalPose],
    symmetry: Symmetry,
    match: Matcher,
) -> Estimate:
    """What there is to say about a pose that was ``first`` before its last step, beside these rivals."""
    best, covariance, agreement = last
    spread = uncertainty(without_free_turn(covariance, best.pose, symmetry), best.pose.translation)
    unclear = ambiguity(one.nats for one in rivals)
    by_lines = confidence(best.support, unclear, spread)
    if by_lines < LEAST_BY_LINES:
        return Estimate()

    if agreement is not None:
        contested = ambiguity(one.nats for one in rivals if not one.turned)
        agreement = agreement._replace(astray=astray(last, symmetry), contested=contested)

    def believed(doubt: Misfit | None) -> float:
        return confidence(best.support, unclear, spread, doubt, agreement)

    doubt = misfit(first) if max(by_lines, believed(None)) >= WORTH_DOUBTING else None
    if doubt is not None and believed(doubt) >= WORTH_TURNING:
        doubt = replace(doubt, otherwise=the_other_way(first, match))
        unclear = min(1.0, max(unclear, doubt.otherwise))
    return Estimate(
        pose=best.pose,
        covariance=covariance,
        rms_px=best.support.rms_px,
        uncertainty=spread,
        supported_fraction=best.support.supported_fraction,
        score=believed(doubt),
        ambiguity=unclear,
        lines=best.support.lines,
        rivals=tuple(Rival(one.pose, odds(one.nats)) for one in rivals),
        free=() if symmetry.free_axis is None else (symmetry.free_axis,),
        support=best.support,
        misfit=doubt,
        agreement=agreement,
    )


def with_poses(
    estimate: Estimate, likely: list[Likely], symmetry: Symmetry, allowed: Callable[[Pose], bool]
) -> Estimate:
    """The estimate with all poses that fit; its score is no more than the first one's probability.

    What speaks against the first, as a model that is not true, speaks against all.
    """
    doubted = min(1.0, estimate.score / likely[0].probability) if likely[0].probability > 0.0 else 0.0
    poses = tuple(
        replace(one, probability=doubted * one.probability)
        for one in listed([(one.last.best.pose, one.probability) for one in likely], symmetry, allowed)
    )
    first = poses[0].probability if poses else estimate.score
    return replace(estimate, poses=poses, score=min(estimate.score, first))


def of_all_lines(estimate: Estimate, problem: PoseProblem, spacing_px: float) -> Estimate:
    """An estimate by some of a target's lines, with what the images say of all of them at its pose."""
    if estimate.pose is None:
        return estimate
    support = support_at(with_line_scales(problem, estimate.pose), estimate.pose, spacing_px)
    if support is None:
        return estimate
    return replace(
        estimate,
        support=support,
        lines=support.lines,
        rms_px=support.rms_px,
        supported_fraction=support.supported_fraction,
    )


def stated(found: Estimate) -> Estimate:
    """The estimate, of a spread as it is stated: its variance over the score.

    The fit's own knows nothing of what speaks against the pose: where it is doubted and nevertheless right,
    some of its lines are on other edges than it takes them for.
    """
    if found.covariance is None or found.uncertainty is None:
        return found
    wider = 1.0 / max(found.score, LEAST_STATED)
    spread = found.uncertainty * math.sqrt(wider)
    return replace(found, covariance=wider * found.covariance, uncertainty=spread)


def about_origin(found: Estimate, middle_from_origin: Pose) -> Estimate:
    """The estimate in the model's own frame; its covariance is of steps in the camera's, and stays."""
    if found.pose is None:
        return found
    rivals = tuple(replace(rival, pose=rival.pose.compose(middle_from_origin)) for rival in found.rivals)
    poses = tuple(replace(one, pose=one.pose.compose(middle_from_origin)) for one in found.poses)
    return replace(found, pose=found.pose.compose(middle_from_origin), rivals=rivals, poses=poses)
