"""Turns that bring most of a target's wireframe, but not all of it, back onto itself."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from geometry.model import Model
from geometry.points_along import points_along
from geometry.pose import Pose
from geometry.rotation import matrix_of

Floats = NDArray[np.float64]

# Chosen by hand where nothing else is said.
POINTS, LEAST_POINTS = 300, 2  # along all lines together, and on each line
SCREENED = 10  # each so many-th point alone is turned first
TOLERANCE = 0.012  # how far a turned point may be from a line, share of the diameter
ALIKE = 0.4  # share of the wireframe that must come back onto itself ...
SCREENED_ALIKE = 0.25  # ... less of few points, which miss some ...
EXACT = 0.995  # ... and from which on the turn changes nothing that could be seen
FOLDS = range(2, 37)  # n-fold turns that are tried: a dial's to 10 degrees
BESIDE_RAD = np.radians(
    3.0
)  # a turn by so much more or less moves the farthest points twice the tolerance ...
PEAK = 1.1  # ... and must bring back less by this factor, or the turn is only a small one
APART_RAD = np.radians(4.0)  # less than the least of FOLDS; products of turns about two middles differ by 0
MOST_PRODUCTS = 80  # 36-fold turns, and each turned over
MOST_LINES = 500  # more are no wireframe: a turn of a round body changes nothing that could be told


@lru_cache(maxsize=8)
def near_symmetries(model: Model) -> tuple[Pose, ...]:
    """Turns by multiples of 360 / n degrees, n in FOLDS, about the target's axes.

    They go through the middle of the bounding box or the wireframe's centroid: one mark moves either.

    Returns
    -------
    target_T_target: what takes a point of the target to where it is after the turn; the nearest to a symmetry
    first; empty for a model of more than MOST_LINES lines.
    """
    if not 0 < len(model.lines) <= MOST_LINES:
        return ()
    points, weights = points_along(model.vertices, model.lines, 0.0, POINTS, LEAST_POINTS)
    middles = [model.middle, weights @ points / weights.sum()]
    if np.linalg.norm(middles[1] - middles[0]) <= 0.1 * TOLERANCE * model.diameter:
        middles.pop()
    found: list[tuple[float, Pose]] = []
    for axis in np.eye(3):
        angles: dict[float, tuple[float, Pose]] = {}
        for n in FOLDS:
            for middle in middles:
                angle = 2.0 * np.pi / n
                alike = _share(points, weights, axis, angle, middle, model)[0]
                if alike < ALIKE or alike < PEAK * max(
                    _share(points, weights, axis, angle + off, middle, model)[0]
                    for off in (-BESIDE_RAD, BESIDE_RAD)
                ):
                    continue
                for k in range(1, n):
                    share, turn = _share(points, weights, axis, k * angle, middle, model)
                    known, _ = angles.get(round(360.0 * k / n, 6), (0.0, None))
                    if ALIKE <= share < EXACT and share > known:
                        angles[round(360.0 * k / n, 6)] = (
                            share,
                            Pose.from_matrix(turn, middle - turn @ middle),
                        )
        found += angles.values()
    found.sort(key=lambda one: -one[0])
    return tuple(pose for _, pose in found)


@lru_cache(maxsize=8)
def near_symmetries_and_products(model: Model) -> tuple[Pose, ...]:
    """The `near_symmetries` and what two of them make: a wheel may be turned over and about its axis at once.

    No two nearer than APART_RAD; MOST_PRODUCTS at most.
    """
    turns = near_symmetries(model)
    found = list(turns)
    rotations = [np.eye(3), *(turn.matrix for turn in turns)]
    for one in turns:
        for other in turns:
            both = one.compose(other)
            cosines = 0.5 * (np.einsum("nij,ij->n", np.array(rotations), both.matrix) - 1.0)
            if len(found) < MOST_PRODUCTS and cosines.max() < np.cos(APART_RAD):
                found.append(both)
                rotations.append(both.matrix)
    return tuple(found)


def _share(
    points: Floats, weights: Floats, axis: Floats, angle: float, middle: Floats, model: Model
) -> tuple[float, Floats]:
    """Share of the wireframe that a turn brings back onto itself, few points first; and the turn (3, 3)."""
    turn = matrix_of(angle * axis)
    for every, least in ((SCREENED, SCREENED_ALIKE), (1, 0.0)):
        some, own = points[::every], weights[::every]
        near = _distance_to_lines((some - middle) @ turn.T + middle, model) <= TOLERANCE * model.diameter
        share = float(own[near].sum() / own.sum())
        if share < least:
            break
    return share, turn


def _distance_to_lines(points: Floats, model: Model) -> Floats:
    """Distance (N,) of points (N, 3) from the nearest line."""
    start = model.vertices[model.lines[:, 0]]
    direction = model.vertices[model.lines[:, 1]] - start
    square = np.maximum(np.einsum("ij,ij->i", direction, direction), 1e-30)
    beside = points[:, None] - start
    share = np.clip(np.einsum("nlk,lk->nl", beside, direction) / square, 0.0, 1.0)
    beside -= share[:, :, None] * direction
    return np.asarray(np.sqrt(np.einsum("nlk,nlk->nl", beside, beside).min(axis=1)))
