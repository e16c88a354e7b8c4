"""What speaks for a pose that came from elsewhere, and the probability that it is right."""

from __future__ import annotations

import math
from typing import NamedTuple

from vision_server.tracking.agreement import Agreement


class Chance(NamedTuple):
    """What a pose that may be the right one says of a given one.

    Attributes
    ----------
    share : of that pose by its likelihood, of all around.
    believed : probability that its lines are where they seem.
    within : how much of its covariance is within the limits of RIGHT of the given pose.
    agreement : of the given pose with it, were the given one from elsewhere, where poses that look alike are
        taken for each other.
    """

    share: float
    believed: float
    within: float
    agreement: Agreement


class Chances(NamedTuple):
    """What speaks for a pose: of each one around, and how far refinement moves the given one, in RIGHT."""

    around: tuple[Chance, ...]
    moved: float


class Calibration(NamedTuple):
    """What turns chances into a probability.

    Attributes
    ----------
    bias, per_log_odds : of the log odds of a pose that refinement does not move, which these images tell.
    elsewhere : logarithm of the density (see `Agreement`) of given poses where the pose around is wrong.
    derived : log odds that a pose that refinement does not move is from these images.
    most : log odds of a pose from elsewhere that agrees with all that is seen.
    """

    bias: float
    per_log_odds: float
    elsewhere: float
    derived: float
    most: float


LEAST_ODDS = 1e-4  # Probabilities are never taken for surer than this (chosen by hand).
LEAST_DENSITY = 1e-300  # a density that is none
# By maximum likelihood on simulated frames, poses right and wrong: python -m benchmarks.referee --fit
CALIBRATION = Calibration(0.5, 0.9, -2.0, 2.6, 4.1)
# What refinement moves a pose by that was refined on these images before, one sd, in RIGHT (chosen by hand).
REFINED_AGAIN_SD = 0.15


def probability(chances: Chances, by: Calibration = CALIBRATION) -> float:
    """Of being right.

    A mixture of two models, by how far refinement moves the pose. One that it does not move may be derived
    from these very images: it agrees with them whether it is right or not, and has the chance that they leave
    it (logistic in the log odds, of a bias and a slope). One from elsewhere is independent of them, and would
    hardly agree with them by chance (`agreement`): it is right by Bayes' rule. Both are calibrated ``by``
    coefficients; `benchmarks.referee`, which fits them, tries others.
    """
    around = chances.around
    if not around:
        return 0.0
    own = sum(
        one.share * _logistic(by.bias + by.per_log_odds * log_odds(one.believed * one.within))
        for one in around
    )
    density = sum(
        one.share * (one.believed * one.agreement.likelihood + (1.0 - one.believed) * math.exp(by.elsewhere))
        for one in around
    )
    right = sum(one.share * one.believed * one.agreement.right for one in around)
    independent = _logistic(by.most) * right / max(density, LEAST_DENSITY)
    derived = math.exp(by.derived - 0.5 * (chances.moved / REFINED_AGAIN_SD) ** 2)
    return (independent + derived * own) / (1.0 + derived)


def _logistic(value: float) -> float:
    return 1.0 / (1.0 + math.exp(-value))


def log_odds(believed: float) -> float:
    """Logarithm of the odds; nothing is believed more than LEAST_ODDS leaves."""
    believed = min(max(believed, LEAST_ODDS), 1.0 - LEAST_ODDS)
    return math.log(believed / (1.0 - believed))
