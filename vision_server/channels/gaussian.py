"""The Gaussian and its derivative, sampled."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def gaussian_kernels(sigma_px: float) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Sampled Gaussian (sum 1) and its derivative (unit response to a unit ramp), both 1-D float32."""
    radius = int(np.ceil(3.0 * sigma_px))
    x = np.arange(-radius, radius + 1, dtype=np.float64)
    smooth = np.exp(-0.5 * (x / sigma_px) ** 2)
    smooth /= smooth.sum()
    derivative = x * smooth
    derivative /= (derivative * x).sum()
    return smooth.astype(np.float32), derivative.astype(np.float32)
