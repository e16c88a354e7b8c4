"""For any point and direction in the image, the nearest image segment that runs in about that direction.

Eight bins of axial direction that overlap; in each a labelled distance transform at half resolution says
which segment is nearest. Distances are then taken to the segment itself, so the grid costs no accuracy.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from geometry.camera import Camera

Floats = NDArray[np.float64]

BINS = 8  # over 180°
OVERLAP = 0.5  # a segment also enters a bin from which it is off by this fraction of a bin
CELL_PX = 2.0
NO_SEGMENT = -1


class NearestEdges(NamedTuple):
    """Lookup table for the kernels.

    Attributes
    ----------
    label : (BINS, h, w) int16, segment index, NO_SEGMENT where a bin is empty; cells of CELL_PX.
    segments : (N, 7) float64, first end x, y, unit direction x, y, length px, weight, direction rad.
    size : (2,) float64, width and height of the image, px.
    """

    label: NDArray[np.int16]
    segments: Floats
    size: Floats


def nearest_edges(segments: Floats, weights: Floats, camera: Camera) -> NearestEdges:
    """Build the table for segments (N, 4) px with weights (N,)."""
    steps = segments[:, 2:] - segments[:, :2]
    length = np.hypot(steps[:, 0], steps[:, 1])
    unit = steps / np.maximum(length, 1e-9)[:, None]
    angle = np.arctan2(unit[:, 1], unit[:, 0]) % np.pi
    table = np.column_stack([segments[:, :2], unit, length, weights, angle])
    height, width = (math.ceil(side / CELL_PX) for side in (camera.height, camera.width))
    painted = _paint(table, height, width)
    label = np.full(painted.shape, NO_SEGMENT, dtype=np.int16)
    for bin_ in range(BINS):
        sources = painted[bin_] != NO_SEGMENT
        if not sources.any():
            continue
        _, nearest = cv2.distanceTransformWithLabels(
            (~sources).astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
        )
        names = np.empty(int(nearest.max()) + 1, dtype=np.int16)
        names[nearest[sources]] = painted[bin_][sources]
        label[bin_] = names[nearest]
    return NearestEdges(label, table, np.array([camera.width, camera.height], dtype=np.float64))


@njit(cache=True)
def _paint(table: Floats, height: int, width: int) -> NDArray[np.int16]:
    """Segments drawn into the cells of the bins they belong to; where two meet, the longer one stays."""
    out = np.full((BINS, height, width), NO_SEGMENT, dtype=np.int16)
    order = np.argsort(table[:, 4])
    for i in order:
        position = table[i, 6] / math.pi * BINS
        count = max(2, int(table[i, 4] / CELL_PX * 2.0) + 1)
        for bin_ in range(BINS):
            off = abs(position - (bin_ + 0.5))
            off = min(off, BINS - off)
            if off > 0.5 + OVERLAP:
                continue
            for k in range(count):
                along = table[i, 4] * k / (count - 1)
                column = int((table[i, 0] + along * table[i, 2] + 0.5) / CELL_PX)
                row = int((table[i, 1] + along * table[i, 3] + 0.5) / CELL_PX)
                if 0 <= column < width and 0 <= row < height:
                    out[bin_, row, column] = i
    return out


@njit(cache=True)
def nearest(edges: NearestEdges, x: float, y: float, dx: float, dy: float) -> int:
    """Index of the segment near (x, y) px along direction (dx, dy), NO_SEGMENT when there is none.

    The point must be inside the image: -0.5 ≤ x < width - 0.5, likewise y.
    """
    angle = math.atan2(dy, dx)
    if angle < 0.0:
        angle += math.pi
    bin_ = min(BINS - 1, int(angle / math.pi * BINS))
    return int(edges.label[bin_, int((y + 0.5) / CELL_PX), int((x + 0.5) / CELL_PX)])


@njit(cache=True)
def offset(edges: NearestEdges, segment: int, x: float, y: float) -> tuple[float, float]:
    """Signed distance of a point to a segment's line, and distance to the segment itself, px."""
    row = edges.segments[segment]
    px, py = x - row[0], y - row[1]
    along = px * row[2] + py * row[3]
    across = py * row[2] - px * row[3]
    beyond = max(-along, along - row[4], 0.0)
    return across, math.sqrt(across * across + beyond * beyond)
