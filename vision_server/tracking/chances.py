"""What speaks for a pose that came from elsewhere, and the probability that it is right.

The share of a pose's covariance that is around the given one is not the chance that the given one is right:
what images leave open by 2 % they tell of any one pose with a chance of next to nothing, and still it speaks
for a pose from elsewhere that it comes out within what they leave open (`agreement`). By how much the given
pose is off has a prior of its own, in which each order of size is as likely as any other.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from geometry.pose import Pose, origin_jacobian
from numerics.arrays import Floats

# What poses from elsewhere may be off by, in units of what is right: each as likely.
GIVEN_POSE_ERRORS = np.geomspace(0.2, 30.0, 8)
NORMAL_DRAWS = np.random.default_rng(0).normal(size=(400, 6))  # of a standard normal: shares to 2.5 %


class Agreement(NamedTuple):
    """Of a given pose with one that images tell.

    Attributes
    ----------
    likelihood : density of the given pose, were the target where the other pose and its covariance say; per
        sixth power of the limits, over that of (2 pi)^-3.
    right : the part of it in which the given pose is right.
    """

    likelihood: float
    right: float


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
    own = of_images(around, by)
    density = sum(
        one.share * (one.believed * one.agreement.likelihood + (1.0 - one.believed) * math.exp(by.elsewhere))
        for one in around
    )
    right = sum(one.share * one.believed * one.agreement.right for one in around)
    independent = _logistic(by.most) * right / max(density, LEAST_DENSITY)
    derived = math.exp(by.derived - 0.5 * (chances.moved / REFINED_AGAIN_SD) ** 2)
    return (independent + derived * own) / (1.0 + derived)


def of_images(around: Sequence[Chance], by: Calibration = CALIBRATION) -> float:
    """Of being right, of a pose that these very images tell; ``around`` are the chances of that pose."""
    return sum(
        one.share * _logistic(by.bias + by.per_log_odds * log_odds(one.believed * one.within))
        for one in around
    )


def agreement(limits: tuple[float, float], one: Pose, covariance: Floats, given: Pose) -> Agreement:
    """Agreement of a given pose with one of a covariance (6, 6).

    The target is at ``one`` but for a normal error of C; the given pose is off from there by a normal error
    of s^2 D, where D has the limits' lengths, for each s of GIVEN_POSE_ERRORS alike. The density of
    their difference d is that of a normal with C + s^2 D; and what of it the given pose is off by
    is normal, too, of mean s^2 D (C + s^2 D)^-1 d.

    Parameters
    ----------
    limits
        Degrees and share of the range, within which a pose is right.
    """
    range_m = float(np.linalg.norm(one.translation))
    unit = np.repeat([np.radians(limits[0]), limits[1] * range_m], 3)
    about_origin = np.eye(6)
    about_origin[3:] = origin_jacobian(one.translation)
    own = about_origin @ covariance @ about_origin.T / np.outer(unit, unit)
    step = np.r_[given.step_from(one)[:3], given.translation - one.translation] / unit
    likelihood = right = 0.0
    for size in GIVEN_POSE_ERRORS:
        off = np.eye(6) * size**2 / 3.0
        inverse = np.linalg.inv(own + off)
        density = float(np.exp(0.5 * (np.linalg.slogdet(inverse)[1] - step @ inverse @ step)))
        spread = np.linalg.cholesky(off - off @ inverse @ off + 1e-12 * np.eye(6))
        parts = (off @ inverse @ step + NORMAL_DRAWS @ spread.T).reshape(-1, 2, 3)
        within = int((np.linalg.norm(parts, axis=2) < 1.0).all(axis=1).sum())
        likelihood += density / len(GIVEN_POSE_ERRORS)
        right += density / len(GIVEN_POSE_ERRORS) * (within + 0.5) / (len(NORMAL_DRAWS) + 1)
    return Agreement(likelihood, right)


def _logistic(value: float) -> float:
    return 1.0 / (1.0 + math.exp(-value))


def log_odds(believed: float) -> float:
    """Logarithm of the odds; nothing is believed more than LEAST_ODDS leaves."""
    believed = min(max(believed, LEAST_ODDS), 1.0 - LEAST_ODDS)
    return math.log(believed / (1.0 - believed))
