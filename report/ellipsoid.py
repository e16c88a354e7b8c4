"""The uncertainty of a position as a small picture: its ellipsoid in oblique view, with a scale."""

import math

import numpy as np

from bridge.messages import PoseMessage
from bridge.result_file import Covariance
from geometry.pose import origin_jacobian
from numerics.arrays import Floats
from report.words import length

SIZE_PX = 240
RADIUS_PX = 70  # of the longest axis
DEVIATIONS = 2.0  # an axis this long covers 19 cases of 20
POINTS = 48
# Oblique view of the camera's axes: x to the right, y down, z forward, away to the upper right.
VIEW = np.array([[1.0, 0.0, 0.45], [0.0, 1.0, -0.32]])
AXES = (
    ("right", np.array([1.0, 0.0, 0.0])),
    ("down", np.array([0.0, 1.0, 0.0])),
    ("forward", np.array([0.0, 0.0, 1.0])),
)


def ellipsoid_svg(pose: PoseMessage | None, covariance: Covariance | None) -> str:
    """The position's ellipsoid at two standard deviations as SVG; empty where none is known.

    Parameters
    ----------
    pose, covariance : as in `uncertainty_of`.
    """
    if pose is None or covariance is None or not np.isfinite(matrix := np.array(covariance)).all():
        return ""
    jacobian = origin_jacobian(np.array(pose.translation))
    variances, directions = np.linalg.eigh(jacobian @ matrix @ jacobian.T)
    semiaxes = DEVIATIONS * np.sqrt(np.maximum(variances, 0.0)) * directions  # columns, m
    longest = float(np.linalg.norm(semiaxes, axis=0).max())
    if longest <= 0.0:
        return ""
    scale = RADIUS_PX / longest
    rings = "".join(
        f'<path class="ring" d="{_path(_ring(semiaxes[:, one], semiaxes[:, other]), scale)}"/>'
        for one, other in ((0, 1), (1, 2), (0, 2))
    )
    arrows = "".join(_arrow(name, axis) for name, axis in AXES)
    step_m = 10 ** math.floor(math.log10(longest))
    bar_px = step_m * scale
    low = SIZE_PX - 14
    label = f"Position uncertainty: longest semi-axis {length(longest)} at two standard deviations"
    return (
        f'<svg class="ellipsoid" viewBox="0 0 {SIZE_PX} {SIZE_PX}" role="img" aria-label="{label}">'
        f"{arrows}{rings}"
        f'<path class="scale" d="M10 {low}h{bar_px:.1f}"/>'
        f'<text x="{16 + bar_px:.1f}" y="{low + 4}">{length(step_m, 1)}</text></svg>'
    )


def _ring(one: Floats, other: Floats) -> Floats:
    angle = np.linspace(0.0, 2 * np.pi, POINTS, endpoint=False)[:, None]
    return np.asarray(np.cos(angle) * one + np.sin(angle) * other)


def _path(points_m: Floats, scale: float) -> str:
    places = points_m @ VIEW.T * scale + SIZE_PX / 2
    return "M" + " ".join(f"{x:.1f} {y:.1f}" for x, y in places) + "Z"


def _arrow(name: str, axis: Floats) -> str:
    x, y = VIEW @ axis * (SIZE_PX / 2 - 22) + SIZE_PX / 2
    middle = SIZE_PX / 2
    return (
        f'<path class="axis" d="M{middle} {middle}L{x:.1f} {y:.1f}"/>'
        f'<text x="{x:.1f}" y="{y - 4:.1f}" text-anchor="middle">{name}</text>'
    )
