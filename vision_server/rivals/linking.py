"""Linking edgels into chains that follow the edge over small gaps and straight on at junctions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from numerics.kernels import kernel
from vision_server.edges.edge_map import EdgeMap

MIN_CHAIN_PX = 6  # shorter chains are noise
REACH_PX = 2  # how far ahead the next edgel may be: 1 is its neighbour, 2 jumps a gap of one pixel
MAX_TURN_COSINE = 0.5  # of the angle between one step and the edge's own direction
MAX_AXIS_COSINE = 0.7  # of the angle between the orientations of two linked edgels


@dataclass(frozen=True)
class Chains:
    """Linked edgels, chain after chain.

    Attributes
    ----------
    points
        float64 (P, 2), sub-pixel x, y of the edgels, px.
    normals
        float64 (P,), orientation across the edge, rad.
    strengths
        float64 (P,), merged magnitude.
    starts
        int64 (C + 1,), chain c is points[starts[c]:starts[c + 1]].
    """

    points: NDArray[np.float64]
    normals: NDArray[np.float64]
    strengths: NDArray[np.float64]
    starts: NDArray[np.int64]


@kernel(nogil=True)
def _next(
    here: int, dx: float, dy: float, index: NDArray[np.int32], places: NDArray[np.int32],
    free: NDArray[np.bool_], normals: NDArray[np.float32], reach: int,
) -> int:  # fmt: skip
    """The best edgel to go on to from ``here`` towards (dx, dy), or -1."""
    rows, columns = index.shape
    y = places[here] // columns
    x = places[here] - y * columns
    best, best_cost = -1, 1e9
    for j in range(-reach, reach + 1):
        for i in range(-reach, reach + 1):
            v, u = y + j, x + i
            if (i == 0 and j == 0) or v < 0 or u < 0 or v >= rows or u >= columns:
                continue
            at = index[v, u]
            if at < 0 or not free[at]:
                continue
            distance = np.sqrt(float(i * i + j * j))
            forward = (i * dx + j * dy) / distance
            if forward < MAX_TURN_COSINE:
                continue
            agreement = abs(normals[at, 0] * normals[here, 0] + normals[at, 1] * normals[here, 1])
            if agreement < MAX_AXIS_COSINE:
                continue
            cost = distance * (2.0 - forward) + 1.0 - agreement
            if cost < best_cost:
                best, best_cost = at, cost
    return best


@kernel(nogil=True)
def _follow(
    seed: int, sign: float, index: NDArray[np.int32], places: NDArray[np.int32], free: NDArray[np.bool_],
    normals: NDArray[np.float32], reach: int, order: NDArray[np.int64], filled: int,
) -> int:  # fmt: skip
    """Write the edgels reached from the seed in one direction into ``order``; how many it holds then."""
    here = seed
    dx, dy = -sign * normals[here, 1], sign * normals[here, 0]
    while True:
        here = _next(here, dx, dy, index, places, free, normals, reach)
        if here < 0:
            return filled
        free[here] = False
        order[filled] = here
        filled += 1
        tx, ty = -normals[here, 1], normals[here, 0]
        if tx * dx + ty * dy < 0.0:
            tx, ty = -tx, -ty
        dx, dy = tx, ty


@kernel(nogil=True)
def _chains(
    chosen: NDArray[np.bool_], index: NDArray[np.int32], places: NDArray[np.int32],
    normals: NDArray[np.float32], seeds: NDArray[np.int64], reach: int, shortest: int,
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:  # fmt: skip
    """Edgel order and chain starts; every edgel is in one chain at most."""
    free = chosen.copy()
    order = np.empty(len(seeds), np.int64)
    back = np.empty(len(seeds), np.int64)
    starts = np.empty(len(seeds) + 1, np.int64)
    starts[0] = 0
    filled, chains = 0, 0
    for seed in seeds:
        if not free[seed]:
            continue
        free[seed] = False
        behind = _follow(seed, -1.0, index, places, free, normals, reach, back, 0)
        begin = filled
        for k in range(behind):
            order[filled + k] = back[behind - 1 - k]
        filled += behind
        order[filled] = seed
        filled = _follow(seed, 1.0, index, places, free, normals, reach, order, filled + 1)
        if filled - begin < shortest:
            filled = begin
        else:
            chains += 1
            starts[chains] = filled
    return order[:filled], starts[: chains + 1]


def link_edgels(
    edges: EdgeMap, chosen: NDArray[np.bool_], *, shortest: int = MIN_CHAIN_PX, reach: int = REACH_PX
) -> Chains:
    """Follow edges from their strongest edgels both ways.

    Parameters
    ----------
    edges
        Merged edge map.
    chosen
        bool (N,), the edgels that count (after hysteresis).
    shortest
        Chains of fewer edgels are dropped.
    reach
        How far ahead the next edgel may be, px (Chebyshev).
    """
    seeds = np.flatnonzero(chosen)
    seeds = seeds[np.argsort(-edges.strength[seeds], kind="stable")]
    order, starts = _chains(chosen, edges.index, edges.places, edges.normals, seeds, reach, shortest)
    return Chains(
        edges.points[order].astype(np.float64),
        edges.axis[order].astype(np.float64),
        edges.strength[order].astype(np.float64),
        starts,
    )
