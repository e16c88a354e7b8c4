"""Linking edgels into chains that follow the edge over small gaps and straight on at junctions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vision_server.edges import EdgeMap

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


@njit(cache=True)
def _next(
    y: int, x: int, dx: float, dy: float, free: NDArray[np.bool_], normal: NDArray[np.float32], reach: int
) -> int:
    """Flat index of the best edgel to go on to from (x, y) towards (dx, dy), or -1."""
    rows, columns = free.shape
    best, best_cost = -1, 1e9
    for j in range(-reach, reach + 1):
        for i in range(-reach, reach + 1):
            v, u = y + j, x + i
            if (i == 0 and j == 0) or v < 0 or u < 0 or v >= rows or u >= columns or not free[v, u]:
                continue
            distance = np.sqrt(float(i * i + j * j))
            forward = (i * dx + j * dy) / distance
            if forward < MAX_TURN_COSINE:
                continue
            agreement = abs(np.cos(float(normal[v, u] - normal[y, x])))
            if agreement < MAX_AXIS_COSINE:
                continue
            cost = distance * (2.0 - forward) + 1.0 - agreement
            if cost < best_cost:
                best, best_cost = v * columns + u, cost
    return best


@njit(cache=True)
def _follow(
    seed: int,
    sign: float,
    free: NDArray[np.bool_],
    normal: NDArray[np.float32],
    reach: int,
    order: NDArray[np.int64],
    filled: int,
) -> int:
    """Write the edgels reached from the seed in one direction into ``order``; how many it holds then."""
    columns = free.shape[1]
    y, x = seed // columns, seed % columns
    dx, dy = -sign * np.sin(float(normal[y, x])), sign * np.cos(float(normal[y, x]))
    while True:
        step = _next(y, x, dx, dy, free, normal, reach)
        if step < 0:
            return filled
        v, u = step // columns, step % columns
        free[v, u] = False
        order[filled] = step
        filled += 1
        tx, ty = -np.sin(float(normal[v, u])), np.cos(float(normal[v, u]))
        if tx * dx + ty * dy < 0.0:
            tx, ty = -tx, -ty
        y, x, dx, dy = v, u, tx, ty


@njit(cache=True)
def _chains(
    mask: NDArray[np.bool_], normal: NDArray[np.float32], seeds: NDArray[np.int64], reach: int, shortest: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Edgel order and chain starts; every edgel is in one chain at most."""
    free = mask.copy()
    columns = mask.shape[1]
    order = np.empty(len(seeds), np.int64)
    back = np.empty(len(seeds), np.int64)
    starts = np.empty(len(seeds) + 1, np.int64)
    starts[0] = 0
    filled, chains = 0, 0
    for seed in seeds:
        y, x = seed // columns, seed % columns
        if not free[y, x]:
            continue
        free[y, x] = False
        behind = _follow(seed, -1.0, free, normal, reach, back, 0)
        begin = filled
        for k in range(behind):
            order[filled + k] = back[behind - 1 - k]
        filled += behind
        order[filled] = seed
        filled = _follow(seed, 1.0, free, normal, reach, order, filled + 1)
        if filled - begin < shortest:
            filled = begin
        else:
            chains += 1
            starts[chains] = filled
    return order[:filled], starts[: chains + 1]


def link_edgels(
    edges: EdgeMap, mask: NDArray[np.bool_], *, shortest: int = MIN_CHAIN_PX, reach: int = REACH_PX
) -> Chains:
    """Follow edges from their strongest edgels both ways.

    Parameters
    ----------
    edges
        Merged edge map.
    mask
        bool (H, W), the edgels that count (after hysteresis).
    shortest
        Chains of fewer edgels are dropped.
    reach
        How far ahead the next edgel may be, px (Chebyshev).
    """
    seeds = np.flatnonzero(mask)
    seeds = seeds[np.argsort(-edges.ridge.ravel()[seeds], kind="stable")]
    order, starts = _chains(mask, edges.orientation, seeds, reach, shortest)
    y, x = np.divmod(order, mask.shape[1])
    normal = edges.orientation.ravel()[order].astype(np.float64)
    offset = edges.offset.ravel()[order].astype(np.float64)
    points = np.stack([x + offset * np.cos(normal), y + offset * np.sin(normal)], axis=1).astype(np.float64)
    return Chains(points, normal, edges.ridge.ravel()[order].astype(np.float64), starts)
