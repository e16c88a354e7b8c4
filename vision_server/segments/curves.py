"""Short pieces of bent edges: rims of small holes, teeth of a gear, each too short to be no accident alone.

Pieces that continue each other end to end are judged together: the surprises of all of a chain add up, less
what there was to choose from at each link.
"""

from __future__ import annotations

import numpy as np

from numerics.arrays import Floats, Ints
from numerics.groups import root
from numerics.kernels import kernel

# Chosen by hand.
SHORTEST_PX = 4.0
GAP_PX = 3.0  # between ends that meet
TURN_COSINE = float(np.cos(np.radians(60.0)))  # of the bend where they meet
STRENGTH_RATIO = 3.0  # of two pieces of one edge
LINK = 1.5  # decades: some thirty ways to go on from an end


def chained_surprise(endpoints: Floats, strength: Floats, surprise: Floats) -> Floats:
    """What each of N lines and all that continue it surprise by together, decades.

    Parameters
    ----------
    endpoints, strength
        (N, 4), px, and (N,), of the lines.
    surprise
        (N,), decades, of each by itself.
    """
    chain = _chains(endpoints, strength)
    worth = np.bincount(chain, np.maximum(surprise - LINK, 0.0), len(chain)) + LINK
    return np.asarray(np.maximum(surprise, worth[chain]))


@kernel()
def _chains(endpoints: Floats, strength: Floats) -> Ints:
    """Chain (N,) of each line, named after one of its lines."""
    order = np.argsort(endpoints[:, ::2].copy().ravel(), kind="mergesort")  # ends, 2 i and 2 i + 1, by x
    parent = np.arange(len(endpoints))
    for first in range(len(order)):
        i, a = order[first] // 2, 2 * (order[first] % 2)
        for k in range(first + 1, len(order)):
            j, b = order[k] // 2, 2 * (order[k] % 2)
            if endpoints[j, b] - endpoints[i, a] > GAP_PX:
                break
            alike = max(strength[i], strength[j]) <= STRENGTH_RATIO * min(strength[i], strength[j])
            if i == j or not alike or not _meet(endpoints[i], a, endpoints[j], b):
                continue
            one, other = root(parent, i), root(parent, j)
            parent[max(one, other)] = min(one, other)
    for i in range(len(parent)):
        parent[i] = root(parent, i)
    return parent


@kernel()
def _meet(one: Floats, a: int, other: Floats, b: int) -> bool:
    """Whether a line (4,) meets another with these ends, indices of their x, and bends by little there."""
    if np.hypot(one[a] - other[b], one[a + 1] - other[b + 1]) > GAP_PX:
        return False
    ux, uy = one[a] - one[2 - a], one[a + 1] - one[3 - a]  # towards the meeting
    vx, vy = other[2 - b] - other[b], other[3 - b] - other[b + 1]  # away from it
    along: bool = ux * vx + uy * vy >= TURN_COSINE * np.hypot(ux, uy) * np.hypot(vx, vy)
    return along
