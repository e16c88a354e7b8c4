"""Canny's post-processing (1986): non-maximum suppression with sub-pixel ridges, and hysteresis."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from numerics.kernels import kernel
from vision_server.edges.edge_map import EdgeMap

Field = NDArray[np.float32]


@kernel()
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


@kernel(nogil=True)
def _spread(
    weak: NDArray[np.bool_], kept: NDArray[np.bool_], places: NDArray[np.int32], rows: int, columns: int
) -> None:
    """From the edgels kept so far to the weak ones that are 8-connected to them; ``places`` ascend."""
    width = columns + 2
    marks = np.zeros((rows + 2) * width, np.uint8)  # 1 weak, 2 kept; with a border
    at, grown = np.empty(len(places), np.int32), np.empty(len(places), np.int32)
    depth, y = 0, 0
    for i in range(len(places)):
        while places[i] >= (y + 1) * columns:
            y += 1
        at[i] = places[i] + width + 1 + 2 * y
        marks[at[i]] = 2 if kept[i] else weak[i]
        grown[depth] = at[i]
        depth += kept[i]
    while depth > 0:
        depth -= 1
        middle = grown[depth]
        for row in range(middle - width, middle + width + 1, width):
            for beside in range(row - 1, row + 2):
                if marks[beside] == 1:
                    marks[beside] = 2
                    grown[depth] = beside
                    depth += 1
    for i in range(len(places)):
        kept[i] = marks[at[i]] == 2


def hysteresis(edges: EdgeMap, low: float | Field, high: float | Field) -> NDArray[np.bool_]:
    """Edgels stronger than ``low`` that are 8-connected to one stronger than ``high``.

    Parameters
    ----------
    edges
        N edgels.
    low, high
        Thresholds, scalar or (N,).

    Returns
    -------
    bool (N,).
    """
    weak, kept = edges.strength > low, edges.strength > np.maximum(low, high)
    _spread(weak, kept, edges.places, *edges.shape)
    return np.asarray(kept, dtype=np.bool_)
