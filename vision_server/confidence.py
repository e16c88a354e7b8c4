"""How sure an estimate is right: a calibrated probability from what the images say, and the rival's share."""

from __future__ import annotations

import math

from vision_server.evidence import NORMAL_FLOOR_PX, Evidence

BIAS = -4.0
PER_LOG_QUALITY = 2.0


def quality(evidence: Evidence) -> float:
    """Normalised score times supported fraction over RMS; edges of saturated pixels count half."""
    discount = 1.0 - 0.5 * evidence.clipped_fraction
    normalised = max(0.0, (evidence.strength - 0.4) / 0.6)
    return discount * normalised * evidence.supported_fraction / max(evidence.rms_px, NORMAL_FLOOR_PX)


def confidence(evidence: Evidence, ambiguity: float, uncertainty: float) -> float:
    """Probability, 0..1, that the pose is within 1 degree and 1 % of the range."""
    value = quality(evidence)
    if value <= 0.0:
        return 0.0
    logit = BIAS + PER_LOG_QUALITY * math.log2(value / 0.1) - 6.0 * max(0.0, ambiguity - 0.5)
    logit -= max(0.0, math.log(max(uncertainty, 1e-6) / 0.003))
    return 1.0 / (1.0 + math.exp(-logit))


def ambiguity(best: Evidence, rivals: list[Evidence]) -> float:
    """Quality of the best other pose as a share of this one's, 0 (unique) to 1 (as good)."""
    own = quality(best)
    if own <= 0.0:
        return 1.0 if rivals else 0.0
    return min(1.0, max((quality(rival) for rival in rivals), default=0.0) / own)
