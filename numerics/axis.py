"""Axial directions in kernels: no library call, no branch."""

from __future__ import annotations

import numpy as np

from numerics.kernels import kernel

# atan(t) / t in powers of t^2 for t in [0, 1]: Abramowitz & Stegun (1964) 4.4.47, within 1e-5 rad
ARCTANGENT = (0.9998660, -0.3302995, 0.1801410, -0.0851330, 0.0208351)


@kernel(inline="always")
def axis_of(dx: np.float32, dy: np.float32) -> np.float32:
    """Direction of a vector other than 0 taken as an axis, rad in [0, pi), 0 along x; within 1e-5 rad."""
    a, b = abs(dx), abs(dy)
    t = min(a, b) / max(a, b)
    z = t * t
    series = np.float32(ARCTANGENT[3]) + z * np.float32(ARCTANGENT[4])
    series = np.float32(ARCTANGENT[1]) + z * (np.float32(ARCTANGENT[2]) + z * series)
    axis = t * (np.float32(ARCTANGENT[0]) + z * series)
    axis = np.float32(0.5 * np.pi) - axis if b > a else axis
    axis = np.float32(np.pi) - axis if (dx > np.float32(0.0)) != (dy > np.float32(0.0)) else axis
    return axis if axis < np.float32(np.pi) else np.float32(0.0)
