"""Recursive top-down splitting of chains into straight pieces (the paper, "edge linking")."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from numerics.kernels import kernel
from vision_server.rivals.linking import Chains

MAX_DEVIATION_RATIO = 0.03  # of max |d_i| to D, the distance between the piece's ends
MIN_DEVIATION_PX = 1.0  # deviations under this are the noise of edgels, whatever the length


@kernel()
def _farthest(points: NDArray[np.float64], first: int, last: int) -> tuple[int, float, float]:
    """The point farthest from the chord first-last: index, distance, length of the chord."""
    ax, ay = points[first, 0], points[first, 1]
    cx, cy = points[last, 0] - ax, points[last, 1] - ay
    chord = np.sqrt(cx * cx + cy * cy)
    index, distance = -1, -1.0
    for k in range(first + 1, last):
        px, py = points[k, 0] - ax, points[k, 1] - ay
        d = abs(px * cy - py * cx) / chord if chord > 1e-9 else np.sqrt(px * px + py * py)
        if d > distance:
            index, distance = k, d
    return index, distance, chord


@kernel()
def _split(
    points: NDArray[np.float64], starts: NDArray[np.int64], ratio: float, tolerance: float
) -> NDArray[np.int64]:
    """Pieces as rows (first, last + 1), by splitting at the farthest point while it is too far."""
    pieces = np.empty((len(points) + 1, 2), np.int64)
    stack = np.empty((len(points) + 1, 2), np.int64)
    count = 0
    for c in range(len(starts) - 1):
        stack[0, 0], stack[0, 1] = starts[c], starts[c + 1] - 1
        depth = 1
        while depth > 0:
            depth -= 1
            first, last = stack[depth, 0], stack[depth, 1]
            if last > first + 1:
                index, distance, chord = _farthest(points, first, last)
                if distance > tolerance and distance > ratio * chord:
                    stack[depth, 0], stack[depth, 1] = index, last
                    stack[depth + 1, 0], stack[depth + 1, 1] = first, index
                    depth += 2
                    continue
            pieces[count, 0], pieces[count, 1] = first, last + 1
            count += 1
    return pieces[:count]


def split_chains(
    chains: Chains, *, ratio: float = MAX_DEVIATION_RATIO, tolerance_px: float = MIN_DEVIATION_PX
) -> NDArray[np.int64]:
    """Straight pieces of chains: split at the farthest point while max|d_i| / D exceeds ``ratio``.

    Parameters
    ----------
    chains
        Linked edgels.
    ratio
        Largest deviation allowed, as a fraction of the distance D between the ends.
    tolerance_px
        Deviations up to this never split.

    Returns
    -------
    int64 (N, 2), index of a piece's first point and one past its last; neighbours share the split point.
    """
    if len(chains.points) == 0:
        return np.zeros((0, 2), np.int64)
    return np.asarray(_split(chains.points, chains.starts, ratio, tolerance_px))
