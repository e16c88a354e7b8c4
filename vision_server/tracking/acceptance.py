"""What a pose has to show to be followed, believed and called sure: the rules, as `tracker` asks for them."""

from __future__ import annotations

import math

import numpy as np

from geometry.model import Model
from geometry.pose import Pose, origin_jacobian
from numerics.arrays import Flags, Floats
from vision_server.matching.match import Anywhere
from vision_server.pose.covariance import uncertainty
from vision_server.tracking.chances import NORMAL_DRAWS
from vision_server.tracking.following import Found
from vision_server.tracking.rivals import Rivals
from vision_server.trust.judgement import Estimate
from vision_server.trust.probability import belief, shared
from vision_server.trust.support import MISSING_SUPPORT, PoseSupport

# Probabilities, by hand: a pose is believed from the first on, stays believed from one frame to the next from
# the second on, and is followed at all from the third on. Less lets look-alikes in, more loses dim frames.
SURE, STAYS, HELD = 0.9, 0.5, 0.3
# After a sure frame the next may be sure from here on: of 143 frames of a real cube, boxes and parts that
# stayed sure so, two were less probable, one of which was off by 3.4 degrees.
STAYS_SURE = 0.6
# A pose is exact if so much of what its covariance allows is within these degrees and share of the range.
EXACT_WITHIN, EXACT_SHARE = (3.0, 0.02), 0.9
EXACT_SIGMAS = 3.0  # times the root of the whole variance: of a normal, 99.7 % and more are nearer
# The covariance that is told is that of the fit times the first, and more by the second for each odds against
# the pose, whose belief counts as the third at least; so that on 48 films of printed boxes 97 % of the
# squared errors are within the 99 % bound.
TOLD_VARIANCE_TIMES, TOLD_PER_ODDS_AGAINST, LEAST_BELIEF = 2.0, 4.0, 0.02
WHOLE_SUPPORT = 0.75  # of its length, from which on a line is seen whole; missing it is below MISSING_SUPPORT
# Of the visible length: what has to be on lines that are seen whole for a pose to be followed, not surely,
# beside an occluder; and what may be on lines that are not seen for a target that was found again to be sure.
HELD_LENGTH_SHARE, MOST_MISSING_SHARE = 0.2, 0.15
MOST_GONE_SHARE = 0.2  # of the length of lines seen whole a frame before, to be followed without another look


def is_likely(estimate: Estimate, known: bool) -> bool:
    """Whether a searched pose of a low score is worth following, if not surely.

    A score is low also where a stretched model would do better, and rounded edges make a target look
    stretched. What may have left, as it is ``known`` from frames before, has to show its lines.
    """
    believed = belief_in(estimate)
    if known:
        return believed >= STAYS and estimate.support is not None and is_whole(estimate.support)
    return believed >= HELD


def found_belief(estimate: Estimate, fitted: Found | None) -> float:
    """Probability that what a search found is the target: its score, or of what is ``fitted`` to whole lines.

    The score asks edge points whether they agree to some hundredths of a pixel, which those of rounded edges
    do not; whole lines know what they are off. That another model does better, they do not know.
    """
    doubt = estimate.misfit
    if fitted is None or doubt is None or doubt.gain > 0.0 or doubt.excess is not None:
        return estimate.score
    own = fitted.belief(estimate.ambiguity) if is_whole(fitted.support) else 0.0
    return max(estimate.score, own)


def belief_in(estimate: Estimate) -> float:
    """Probability that a searched pose is the right one, by its lines; 0 where there is none."""
    if estimate.pose is None or estimate.covariance is None or estimate.support is None:
        return 0.0
    spread = uncertainty(estimate.covariance, estimate.pose.translation)
    return belief(estimate.support, estimate.ambiguity, spread)


def told_covariance(covariance: Floats, believed: float) -> Floats:
    """The covariance (6, 6) of a fit as it is stated of a pose that is believed with a probability.

    In the middle the fit's own is wide enough. Its tails are not: an edge taken for another that hardly
    lowers the belief is off by more, and what is hardly believed by much more.
    """
    return (TOLD_VARIANCE_TIMES + TOLD_PER_ODDS_AGAINST * odds_against(believed)) * covariance


def odds_against(believed: float) -> float:
    """Of what is believed with a probability; nothing is believed less than LEAST_BELIEF."""
    believed = max(believed, LEAST_BELIEF)
    return (1.0 - believed) / believed


def are_unlikely(rivals: Rivals) -> bool:
    """Whether look-alikes leave a pose likely enough to be sure."""
    return shared(1.0, rivals.asked) >= SURE


def is_clear(found: Found, rivals: Rivals) -> bool:
    """Whether a pose is the right one by its lines, and beside those that look like it."""
    return found.belief(rivals.unasked) >= SURE and are_unlikely(rivals)


def is_probable(found: Found, rivals: Rivals, stays: bool) -> bool:
    """Whether a pose is clear, or likely enough where it ``stays`` believed from the frame before.

    Of many lines some are always seen whole, and their quality alone is believed; so a pose has to explain
    what is seen better than chance does, too. Of 279 sure frames of drawn films none had less than 10 nats.
    """
    if found.evidence <= 0.0:
        return False
    return is_clear(found, rivals) or (stays and found.belief(rivals.ambiguity) >= STAYS)


def is_sure(found: Found, rivals: Rivals, stays: bool) -> bool:
    """Whether a pose is sure, by its lines, its rivals and the covariance of its fit.

    After a sure frame it ``stays`` so where it is less likely and exact for what its doubt is more than that.
    """
    if is_clear(found, rivals):
        return is_exact(found.pose, found.covariance)
    believed = found.belief(rivals.ambiguity)
    wider = 1.0 + TOLD_PER_ODDS_AGAINST * max(odds_against(believed) - odds_against(SURE), 0.0)
    return stays and believed >= STAYS_SURE and is_exact(found.pose, wider * found.covariance)


def is_exact(pose: Pose, covariance: Floats, within: tuple[float, float] = EXACT_WITHIN) -> bool:
    """Whether a pose is known, by the covariance (6, 6) of its fit, as exactly as a sure one is.

    Parameters
    ----------
    within : degrees and share of the range.
    """
    off = np.vstack([np.eye(3, 6), origin_jacobian(pose.translation)])
    off[:3] /= math.radians(within[0])
    off[3:] /= within[1] * float(np.linalg.norm(pose.translation))
    spread = off @ covariance @ off.T
    if EXACT_SIGMAS**2 * max(np.trace(spread[:3, :3]), np.trace(spread[3:, 3:])) < 1.0:  # spares the draws
        return True
    value, axis = np.linalg.eigh(spread)
    squares = (NORMAL_DRAWS @ (axis * np.sqrt(np.maximum(value, 0.0))).T) ** 2
    within = (squares[:, :3].sum(axis=1) < 1.0) & (squares[:, 3:].sum(axis=1) < 1.0)
    return bool(np.count_nonzero(within) >= EXACT_SHARE * len(NORMAL_DRAWS))


def is_partly_whole(support: PoseSupport) -> bool:
    """Whether enough of the visible length is on lines that are seen whole: clutter gives pieces."""
    return _length(support, least=WHOLE_SUPPORT) >= HELD_LENGTH_SHARE * _length(support)


def is_whole(support: PoseSupport) -> bool:
    """Whether hardly anything is missing: at most MOST_MISSING_SHARE of the visible length."""
    return _length(support, below=MISSING_SUPPORT) <= MOST_MISSING_SHARE * _length(support)


def whole_lines(support: PoseSupport) -> Flags:
    """Which lines of the model are seen whole, (L,)."""
    visible, supported = support.by_line
    return np.asarray((supported >= WHOLE_SUPPORT * visible) & (visible > 0.0))


def keeps(support: PoseSupport, whole: Flags) -> bool:
    """Whether lines that were seen ``whole`` (L,) a frame before still are, where they should be visible.

    Beside the right pose another one may be that lines which were not seen before support instead.
    """
    visible, supported = support.by_line
    gone = whole & (supported < MISSING_SUPPORT * visible)
    return bool(visible[gone].sum() <= MOST_GONE_SHARE * visible[whole].sum())


def _length(support: PoseSupport, least: float = 0.0, below: float = math.inf) -> float:
    """Visible length, px, of the lines with so much support."""
    return sum(line.visible_px for line in support.lines if least <= line.support < below)


def is_elsewhere(pose: Pose, before: Pose | Anywhere, model: Model) -> bool:
    """Whether a pose is beside what was doubted before, which says nothing of it then."""
    if isinstance(before, Anywhere):
        return False
    middles = [one.apply(model.middle[None])[0] for one in (pose, before)]
    if min(middle[2] for middle in middles) <= 0.0:
        return False
    across = [middle[:2] / middle[2] for middle in middles]
    return float(np.linalg.norm(across[0] - across[1])) > model.diameter / float(middles[0][2])
