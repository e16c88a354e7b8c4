"""A 6×6 pose covariance as numbers a person can hold against a ruler."""

import math
from dataclasses import dataclass

import numpy as np

from bridge.messages import PoseMessage
from bridge.result_file import Covariance
from geometry.pose import origin_jacobian
from numerics.arrays import Floats


@dataclass(frozen=True)
class Uncertainty:
    """Standard deviations of a pose, in the camera's axes (x right, y down, z forward).

    Attributes
    ----------
    position_m : of the target's origin along x, y, z, metres.
    rotation_deg : about x, y, z, degrees.
    along_m, across_m : of the target's origin along the line of sight, and the largest across it.
    worst_position_m, worst_rotation_deg : along the worst direction whatever it is.
    fraction_of_range : worst_position_m divided by the range.
    """

    position_m: tuple[float, float, float]
    rotation_deg: tuple[float, float, float]
    along_m: float
    across_m: float
    worst_position_m: float
    worst_rotation_deg: float
    fraction_of_range: float


def uncertainty_of(pose: PoseMessage | None, covariance: Covariance | None) -> Uncertainty | None:
    """Standard deviations of a pose from the covariance of a small left-multiplied step.

    The step turns about the camera's centre, so the target's origin moves by dr × t + dt; the position's
    covariance is that of this sum. None when pose or covariance is missing or the covariance is not one
    (not finite, or with a negative variance).
    """
    if pose is None or covariance is None:
        return None
    matrix = np.array(covariance)
    x, y, z = pose.translation
    jacobian = origin_jacobian(np.array(pose.translation))
    position = jacobian @ matrix @ jacobian.T
    rotation = matrix[:3, :3]
    distance = math.sqrt(x * x + y * y + z * z)
    if not np.isfinite(matrix).all() or distance == 0:
        return None
    if (np.diag(position) < 0).any() or (np.diag(rotation) < 0).any():
        return None
    sight = np.array([x, y, z]) / distance
    aside = np.eye(3) - np.outer(sight, sight)
    worst = _worst(position)
    return Uncertainty(
        position_m=_deviations(position),
        rotation_deg=_deviations(rotation, math.degrees(1)),
        along_m=math.sqrt(max(0.0, float(sight @ position @ sight))),
        across_m=_worst(aside @ position @ aside),
        worst_position_m=worst,
        worst_rotation_deg=math.degrees(_worst(rotation)),
        fraction_of_range=worst / distance,
    )


def _deviations(covariance: Floats, scale: float = 1.0) -> tuple[float, float, float]:
    x, y, z = (scale * math.sqrt(value) for value in np.diag(covariance))
    return x, y, z


def _worst(covariance: Floats) -> float:
    symmetric = (covariance + covariance.T) / 2
    return math.sqrt(max(0.0, float(np.linalg.eigvalsh(symmetric)[-1])))
