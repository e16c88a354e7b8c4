"""Canny's post-processing (1986) of one gradient image: non-maximum suppression, and hysteresis.

This is the definition: the merge of channels suppresses in `ridges`, with the weights of each pixel, and is
tested against it. The other merge rules (`rivals.merge_rules`) use it as it is.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from numerics.arrays import Field, Flags, Grey, Ints
from numerics.kernels import kernel
from vision_server.edges.edge_map import EdgeMap

LOW_NOISE_RATIO = 4.0  # hysteresis thresholds, in standard deviations of the merged contrast
HIGH_NOISE_RATIO = 8.0
MOST_OFFSET_PX = 0.7  # from a ridge's pixel to the ridge: half a diagonal


def suppress_non_maxima(magnitude: Field, orientation: Field) -> tuple[Field, Field]:
    """Thin an edge map to ridges one pixel wide.

    A pixel stays when its magnitude is a maximum among the three where the edge's normal through it meets
    the ring of its eight neighbours. The parabola through the three says where between pixels the ridge is.

    Parameters
    ----------
    magnitude
        float32 (H, W); only pixels above 0 can be ridges, and none of the outermost ones.
    orientation
        float32 (H, W), axis across the edge, rad.

    Returns
    -------
    ridge
        float32 (H, W), the magnitude on ridges, else 0.
    offset
        float32 (H, W), px along the normal from the pixel's centre to the ridge.
    """
    y, x = (at + 1 for at in np.nonzero(magnitude[1:-1, 1:-1] > 0))
    dx, dy = np.cos(orientation[y, x]), np.sin(orientation[y, x])
    longer, shorter = np.maximum(abs(dx), abs(dy)), np.minimum(abs(dx), abs(dy))
    flat = abs(dx) >= abs(dy)
    u, v = np.where(dx > 0, 1, -1), np.where(dy > 0, 1, -1)
    part = shorter / longer

    def beside(sign: int) -> Field:
        """On the ring: between the neighbour straight on and that on the diagonal."""
        straight = magnitude[y + np.where(flat, 0, sign * v), x + np.where(flat, sign * u, 0)]
        return np.asarray((1.0 - part) * straight + part * magnitude[y + sign * v, x + sign * u])

    here, ahead, behind = magnitude[y, x], beside(1), beside(-1)
    kept = (here >= ahead) & (here > behind)
    curvature = np.where(kept, ahead - 2.0 * here + behind, -1.0)
    place = 0.5 * (behind - ahead) / curvature / longer
    ridge, offset = np.zeros_like(magnitude), np.zeros_like(magnitude)
    ridge[y, x] = np.where(kept, here, 0.0)
    offset[y, x] = np.where(kept, np.clip(place, -MOST_OFFSET_PX, MOST_OFFSET_PX), 0.0)
    return ridge, offset


def edgel_thresholds(edges: EdgeMap) -> tuple[Field, Field]:
    """Hysteresis thresholds of each edgel, float32 (N,), from the noise there."""
    return np.float32(LOW_NOISE_RATIO) * edges.floor, np.float32(HIGH_NOISE_RATIO) * edges.floor


def hysteresis(edges: EdgeMap, low: float | Field, high: float | Field) -> Flags:
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
    weak, strong = edges.strength > low, edges.strength > np.maximum(low, high)
    return _reached(edges.places, edges.shape[1], weak, strong)


@kernel()
def _reached(places: NDArray[np.int32], columns: int, weak: Flags, strong: Flags) -> Flags:
    """Which of N ascending places are 8-connected through weak ones to a strong one, weak itself.

    Each piece is a tree of edgels; ``parent`` is an earlier one of the same piece, of its root itself.
    """
    parent = np.arange(len(places))
    above = row = 0  # the first edgel that may be beside the row above, and where this row begins
    for i in range(len(places)):
        while places[i] >= row + columns:
            row += columns
        first = places[i] - columns - (1 if places[i] > row else 0)
        last = places[i] - columns + (1 if places[i] < row + columns - 1 else 0)
        while places[above] < first:
            above += 1
        if not weak[i]:
            continue
        if i > 0 and weak[i - 1] and places[i - 1] == places[i] - 1 >= row:
            parent[i] = parent[i - 1]
        k = above
        while k < i and places[k] <= last:
            if weak[k]:
                _join(parent, i, k)
            k += 1
    reached = strong & weak
    for i in range(len(places)):
        parent[i] = parent[parent[i]]  # those before are roots' children by now
        reached[parent[i]] |= reached[i]
    for i in range(len(places)):
        reached[i] = weak[i] & reached[parent[i]]
    return reached


@kernel()
def _join(parent: Ints, one: int, other: int) -> None:
    """Make one tree of those of two edgels."""
    while one != other:
        one, other = max(one, other), min(one, other)
        if parent[one] == one:
            parent[one] = other
        one = parent[one]


def edge_picture(edges: EdgeMap) -> Grey:
    """Edgels that survive hysteresis, white on black, uint8 (H, W)."""
    picture = np.zeros(edges.shape, np.uint8)
    picture.ravel()[edges.places[hysteresis(edges, *edgel_thresholds(edges))]] = 255
    return picture
