"""Canny's post-processing (1986): non-maximum suppression with sub-pixel ridges, and hysteresis."""

from __future__ import annotations

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

Field = NDArray[np.float32]


@njit(cache=True)
def _suppress(magnitude: Field, orientation: Field, profile: Field, ridge: Field, offset: Field) -> None:
    """Keep a pixel whose profile is a maximum across the edge; fit a parabola through the three values."""
    rows, columns = magnitude.shape
    for y in range(1, rows - 1):
        for x in range(1, columns - 1):
            m = magnitude[y, x]
            if m <= 0.0:
                continue
            dx, dy = np.cos(orientation[y, x]), np.sin(orientation[y, x])
            # Step to where the normal leaves the ring of the eight neighbours: one coordinate is then exact.
            stretch = 1.0 / max(abs(dx), abs(dy))
            sx, sy = dx * stretch, dy * stretch
            if abs(dx) >= abs(dy):
                u = 1 if sx > 0.0 else -1
                v = 1 if sy > 0.0 else -1
                t = abs(sy)
                ahead = (1.0 - t) * profile[y, x + u] + t * profile[y + v, x + u]
                behind = (1.0 - t) * profile[y, x - u] + t * profile[y - v, x - u]
            else:
                u = 1 if sx > 0.0 else -1
                v = 1 if sy > 0.0 else -1
                t = abs(sx)
                ahead = (1.0 - t) * profile[y + v, x] + t * profile[y + v, x + u]
                behind = (1.0 - t) * profile[y - v, x] + t * profile[y - v, x - u]
            here = profile[y, x]
            if here < ahead or here <= behind:
                continue
            ridge[y, x] = m
            curvature = ahead - 2.0 * here + behind
            if curvature < 0.0:
                place = 0.5 * (behind - ahead) / curvature * stretch
                offset[y, x] = np.float32(min(max(place, -0.7), 0.7))


def suppress_non_maxima(
    magnitude: Field, orientation: Field, profile: Field | None = None
) -> tuple[Field, Field]:
    """Thin an edge map to ridges one pixel wide.

    Parameters
    ----------
    magnitude
        float32 (H, W); only pixels above 0 can be ridges.
    orientation
        float32 (H, W), axis across the edge, rad.
    profile
        float32 (H, W), what must be a maximum across the edge; ``magnitude`` when left out.

    Returns
    -------
    ridge
        float32 (H, W), the magnitude on ridges, else 0.
    offset
        float32 (H, W), px along the normal from the pixel's centre to the ridge.
    """
    ridge, offset = np.zeros_like(magnitude), np.zeros_like(magnitude)
    _suppress(magnitude, orientation, magnitude if profile is None else profile, ridge, offset)
    return ridge, offset


def hysteresis(ridge: Field, low: float | Field, high: float | Field) -> NDArray[np.bool_]:
    """Ridge pixels above ``low`` that are 8-connected to one above ``high``; thresholds scalar or (H, W)."""
    weak = ridge > low
    if not weak.any():
        return weak
    _, labels = cv2.connectedComponents(weak.view(np.uint8), connectivity=8)
    kept = np.zeros(int(labels.max()) + 1, np.bool_)
    kept[labels[weak & (ridge > high)]] = True
    kept[0] = False
    return np.asarray(kept[labels], dtype=np.bool_)
