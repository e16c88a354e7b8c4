"""Recursive top-down splitting of chains into straight pieces (the paper, "edge linking")."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vision_server.segments.line_fit import Edgels

Floats = NDArray[np.float64]

MAX_DEVIATION_RATIO = 0.03  # of max |d_i| to D, the distance between the piece's ends
MIN_DEVIATION_PX = 1.0  # deviations under this are the noise of edgels, whatever the length
CLOSED_PX = 1e-9  # ends so near to each other have no chord: distances are taken from them


def _split(points: Floats, first: int, last: int, ratio: float, tolerance: float) -> list[tuple[int, int]]:
    """Pieces (first, one past the last) of the points from ``first`` to ``last``, both included."""
    chord = points[last] - points[first]
    length = float(np.hypot(*chord))  # D
    x, y = (points[first + 1 : last] - points[first]).T
    distance = abs(x * chord[1] - y * chord[0]) / length if length > CLOSED_PX else np.hypot(x, y)  # |d_i|
    if len(distance) == 0 or distance.max() <= max(tolerance, ratio * length):
        return [(first, last + 1)]
    middle = first + 1 + int(np.argmax(distance))
    return _split(points, first, middle, ratio, tolerance) + _split(points, middle, last, ratio, tolerance)


def split_chains(
    chains: Edgels, *, ratio: float = MAX_DEVIATION_RATIO, tolerance_px: float = MIN_DEVIATION_PX
) -> NDArray[np.int64]:
    """Straight pieces of chains: split at the farthest point while max|d_i| / D exceeds ``ratio``.

    Parameters
    ----------
    chains
        Linked edgels, each group a chain.
    ratio
        Largest deviation allowed, as a fraction of the distance D between the ends.
    tolerance_px
        Deviations up to this never split.

    Returns
    -------
    int64 (N, 2), index of a piece's first point and one past its last; neighbours share the split point.
    """
    pieces = [
        piece
        for first, end in chains.groups.tolist()
        for piece in _split(chains.points, first, end - 1, ratio, tolerance_px)
    ]
    return np.array(pieces, np.int64).reshape(-1, 2)
