"""Linking edgels into chains (the paper, "edge linking"), over small gaps and straight on at junctions."""

from __future__ import annotations

import numpy as np

from numerics.arrays import Flags, Ints
from numerics.kernels import kernel
from vision_server.edges.edge_map import EdgeMap, FreeEdgels
from vision_server.segments.line_fit import Edgels, edgel_groups

# Chosen by hand.
MIN_CHAIN_PX = 6  # shorter chains are noise
REACH_PX = 2  # how far ahead the next edgel may be: 1 is its neighbour, 2 jumps a gap of one pixel
MAX_TURN_COSINE = 0.5  # of the angle between one step and the edge's own direction
MAX_AXIS_COSINE = 0.7  # of the angle between the orientations of two linked edgels


@kernel()
def _next(edgels: FreeEdgels, here: int, dx: float, dy: float) -> int:
    """The best edgel to go on to from ``here`` towards (dx, dy), or -1."""
    rows, columns = edgels.number_at.shape
    normals = edgels.normals
    y = edgels.places[here] // columns
    x = edgels.places[here] - y * columns
    best, best_cost = -1, 1e9
    for v in range(max(y - REACH_PX, 0), min(y + REACH_PX + 1, rows)):
        for u in range(max(x - REACH_PX, 0), min(x + REACH_PX + 1, columns)):
            at = edgels.number_at[v, u]
            if at < 0 or not edgels.free[at]:
                continue
            distance = np.hypot(u - x, v - y)
            forward = ((u - x) * dx + (v - y) * dy) / distance
            agreement = abs(normals[at, 0] * normals[here, 0] + normals[at, 1] * normals[here, 1])
            if forward < MAX_TURN_COSINE or agreement < MAX_AXIS_COSINE:
                continue
            cost = distance * (2.0 - forward) + 1.0 - agreement
            if cost < best_cost:
                best, best_cost = at, cost
    return best


@kernel()
def _follow(edgels: FreeEdgels, seed: int, sign: float, chain: Ints) -> int:
    """Write the edgels reached from the seed in one direction into ``chain``; how many they are."""
    here, count = seed, 0
    dx, dy = -sign * edgels.normals[here, 1], sign * edgels.normals[here, 0]
    while True:
        here = _next(edgels, here, dx, dy)
        if here < 0:
            return count
        edgels.free[here] = False
        chain[count] = here
        count += 1
        tx, ty = -edgels.normals[here, 1], edgels.normals[here, 0]
        if tx * dx + ty * dy < 0.0:
            tx, ty = -tx, -ty
        dx, dy = tx, ty


@kernel()
def _chains(edgels: FreeEdgels, seeds: Ints) -> tuple[Ints, Ints]:
    """Edgels of all chains, and each chain's first and one past its last; an edgel is in one at most."""
    order, back = np.empty(len(seeds), np.int64), np.empty(len(seeds), np.int64)
    chains = np.empty((len(seeds), 2), np.int64)
    filled, count = 0, 0
    for seed in seeds:
        if not edgels.free[seed]:
            continue
        edgels.free[seed] = False
        behind = _follow(edgels, seed, -1.0, back)
        middle = filled + behind
        order[filled:middle] = back[:behind][::-1]
        order[middle] = seed
        end = middle + 1 + _follow(edgels, seed, 1.0, order[middle + 1 :])
        if end - filled >= MIN_CHAIN_PX:
            chains[count] = filled, end
            count += 1
            filled = end
    return order[:filled], chains[:count]


def link_edgels(edges: EdgeMap, chosen: Flags) -> Edgels:
    """Follow edges from their strongest edgels both ways.

    Parameters
    ----------
    edges
        Merged edge map.
    chosen
        bool (N,), the edgels that count (after hysteresis).

    Returns
    -------
    Edgels, each group of them a chain, in order.
    """
    order, chains = _chains(edges.free(chosen), edges.strongest_first(chosen))
    return edgel_groups(edges, order, chains)
