"""For any point and direction in the image, the nearest image segment that runs in about that direction.

Eight bins of axial direction that overlap; in each a labelled distance transform at half resolution says
which segment is nearest. Distances are then taken to the segment itself, so the grid costs no accuracy.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera
from numerics.arrays import Field, Floats, Grey, Ints
from numerics.kernels import kernel

Labels = NDArray[np.int16]

AXIS_BINS = 8  # over 180°, by hand: `bin_of` and TAN_22_5 are written for these
BIN_OVERLAP = 0.5  # a segment also enters a bin from which it is off by this fraction of a bin
CELL_PX = 2.0  # by hand: distances are taken to segments, half the size has four times as many
NO_SEGMENT = -1
GAIN_REACH_PX = 24.0  # from which an edge counts in the scores of drawn poses (by hand)
PIECE_PX = 8.0  # of a segment, that lines of a pose can lie on once (by hand)
TAN_22_5 = math.sqrt(2.0) - 1.0


class NearestEdges(NamedTuple):
    """Lookup table for the kernels.

    Attributes
    ----------
    label : (AXIS_BINS, h, w) int16, segment index, NO_SEGMENT where a bin is empty; cells of CELL_PX.
    gain : (AXIS_BINS, h, w) uint8, 255 · max(0, 1 − d/GAIN_REACH_PX) with d the distance in
        the grid; for scores where a pixel does not matter.
    segments : (N, 6) float64, first end x, y, unit direction x, y, length px, direction rad.
    first_piece : (N + 1,) int64, number of the first piece of each segment; last, how many there are.
    size : (2,) float64, width and height of the image, px.
    """

    label: NDArray[np.int16]
    gain: Grey
    segments: Floats
    first_piece: Ints
    size: Floats


def nearest_edges(segments: Floats, camera: Camera) -> NearestEdges:
    """Build the table for segments (N, 4) px."""
    steps = segments[:, 2:] - segments[:, :2]
    length = np.hypot(steps[:, 0], steps[:, 1])
    unit = steps / np.maximum(length, 1e-9)[:, None]
    angle = np.arctan2(unit[:, 1], unit[:, 0]) % np.pi
    table = np.column_stack([segments[:, :2], unit, length, angle])
    height, width = (math.ceil(side / CELL_PX) for side in (camera.height, camera.width))
    painted = _paint(table, np.argsort(length, kind="stable"), height, width)  # long ones on top
    label = np.full(painted.shape, NO_SEGMENT, dtype=np.int16)
    gain = np.zeros(painted.shape, dtype=np.uint8)
    for bin_ in range(AXIS_BINS):
        if (painted[bin_] != NO_SEGMENT).any():
            distance, label[bin_] = distance_transform(painted[bin_])
            gain[bin_] = cv2.convertScaleAbs(
                np.maximum(GAIN_REACH_PX / CELL_PX - distance, 0.0), alpha=255.0 * CELL_PX / GAIN_REACH_PX
            )
    first_piece = np.concatenate([[0], np.cumsum((length / PIECE_PX).astype(np.int64) + 1)])
    size = np.array([camera.width, camera.height], dtype=np.float64)
    return NearestEdges(label, gain, table, first_piece, size)


def distance_transform_plainly(painted: Labels) -> tuple[Floats, Labels]:
    """The definition: distance (h, w) in cells of each cell from the nearest painted one, and its label.

    ``painted`` (h, w) is NO_SEGMENT where nothing is; a label somewhere there is.
    """
    sources = np.argwhere(painted != NO_SEGMENT)
    cells = np.indices(painted.shape).transpose(1, 2, 0)
    distances = np.linalg.norm(cells[:, :, None] - sources, axis=3)
    nearest = sources[distances.argmin(axis=2)]
    return distances.min(axis=2), painted[nearest[..., 0], nearest[..., 1]]


def distance_transform(painted: Labels) -> tuple[Field, Labels]:
    """`distance_transform_plainly` by two passes over the cells (Borgefors 1986), within 3 %."""
    sources = painted != NO_SEGMENT
    distance, nearest = cv2.distanceTransformWithLabels(
        (~sources).astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    names = np.empty(int(nearest.max()) + 1, dtype=np.int16)
    names[nearest[sources]] = painted[sources]
    return np.asarray(distance, dtype=np.float32), names[nearest]


@kernel()
def _paint(table: Floats, order: Ints, height: int, width: int) -> NDArray[np.int16]:
    """Segments drawn into the cells of the bins they belong to; where two meet, the later in order stays."""
    out = np.full((AXIS_BINS, height, width), NO_SEGMENT, dtype=np.int16)
    for i in order:
        position = table[i, 5] / math.pi * AXIS_BINS
        count = max(2, int(table[i, 4] / CELL_PX * 2.0) + 1)
        for bin_ in range(AXIS_BINS):
            off = abs(position - (bin_ + 0.5))
            off = min(off, AXIS_BINS - off)
            if off > 0.5 + BIN_OVERLAP:
                continue
            for k in range(count):
                along = table[i, 4] * k / (count - 1)
                column = int((table[i, 0] + along * table[i, 2] + 0.5) / CELL_PX)
                row = int((table[i, 1] + along * table[i, 3] + 0.5) / CELL_PX)
                if 0 <= column < width and 0 <= row < height:
                    out[bin_, row, column] = i
    return out


@kernel()
def bin_of(dx: float, dy: float) -> int:
    """Bin of an axial direction: floor(angle / (180° / AXIS_BINS)), by comparing with their borders."""
    if dy < 0.0:
        dx, dy = -dx, -dy
    side = 0 if dx > 0.0 else 4
    if side == 4:
        dx, dy = dy, -dx
    if dy < dx:  # below 45° of this quarter
        return side if dy < TAN_22_5 * dx else side + 1
    return side + 3 if dx <= TAN_22_5 * dy else side + 2


@kernel()
def offset(segments: Floats, segment: int, x: float, y: float) -> tuple[float, float]:
    """Signed distance of a point to the line of one of segments (N, 6), and distance to itself, px."""
    px, py = x - segments[segment, 0], y - segments[segment, 1]
    along = px * segments[segment, 2] + py * segments[segment, 3]
    across = py * segments[segment, 2] - px * segments[segment, 3]
    beyond = max(-along, along - segments[segment, 4], 0.0)
    return across, math.sqrt(across * across + beyond * beyond)


@kernel(inline="always")
def piece_of(edges: NearestEdges, segment: int, x: float, y: float) -> int:
    """Number of the piece of a segment that is nearest to a point."""
    segments = edges.segments
    along = (x - segments[segment, 0]) * segments[segment, 2] + (y - segments[segment, 1]) * segments[
        segment, 3
    ]
    along = min(max(along, 0.0), segments[segment, 4])
    return int(edges.first_piece[segment] + along / PIECE_PX)
