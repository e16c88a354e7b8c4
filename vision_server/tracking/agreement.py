"""Whether a pose from elsewhere agrees with one that images tell: how far such poses are off, nobody knows.

The share of a pose's covariance that is around the given one is not the chance that the given one is right:
what images leave open by 2 % they tell of any one pose with a chance of next to nothing, and still it speaks
for a pose from elsewhere that it comes out within what they leave open. By how much the given pose is off has
a prior of its own, in which each order of size is as likely as any other.
"""

from __future__ import annotations

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
