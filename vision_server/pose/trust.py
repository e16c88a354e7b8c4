"""How sure an estimate is right: a calibrated probability from what the images say, and the rival's share."""

from __future__ import annotations

import math

from vision_server.pose.support import NORMAL_FLOOR_PX, PoseSupport

# Logistic regression on simulated estimates (experiments/plans/calibration.toml), made a little steeper in
# quality.
BIAS = 2.5
PER_LOG2_QUALITY = 1.0
PER_LOG_UNCERTAINTY = -1.5  # of the uncertainty over LIMIT
PER_AMBIGUITY = -8.0  # above CLEAR_AMBIGUITY
LIMIT = 0.01  # 1 % of the range, 1 degree
LEAST_UNCERTAINTY = 0.0005  # being surer than this is no further reason to believe
CLEAR_AMBIGUITY = 0.3  # rivals with less than this share of the quality are none
EVEN_AMBIGUITY = 0.6  # from here to 1 the chance is bounded by less and less, to a half: one of two
LEAST_QUALITY = 1e-3


def quality(support: PoseSupport) -> float:
    """Normalised score times supported fraction over RMS; edges of saturated pixels count half."""
    discount = 1.0 - 0.5 * support.clipped_fraction
    normalised = max(0.0, (support.strength - 0.4) / 0.6)
    return discount * normalised * support.supported_fraction / max(support.rms_px, NORMAL_FLOOR_PX)


def confidence(support: PoseSupport, ambiguity: float, uncertainty: float) -> float:
    """Probability, 0..1, that the pose is within 1 degree and 1 % of the range."""
    value = quality(support)
    if value <= LEAST_QUALITY:
        return 0.0
    logit = (
        BIAS
        + PER_LOG2_QUALITY * math.log2(value)
        + PER_LOG_UNCERTAINTY * math.log(max(uncertainty, LEAST_UNCERTAINTY) / LIMIT)
        + PER_AMBIGUITY * max(0.0, ambiguity - CLEAR_AMBIGUITY)
    )
    bound = 1.0 - 0.5 * max(0.0, ambiguity - EVEN_AMBIGUITY) / (1.0 - EVEN_AMBIGUITY)
    return min(bound, 1.0 / (1.0 + math.exp(-logit)))


def ambiguity(best: PoseSupport, rivals: list[PoseSupport]) -> float:
    """Quality of the best other pose as a share of this one's, 0 (unique) to 1 (as good)."""
    own = quality(best)
    if own <= 0.0:
        return 1.0 if rivals else 0.0
    return min(1.0, max((quality(rival) for rival in rivals), default=0.0) / own)
