"""Turns that bring most of a target's wireframe, but not all of it, back onto itself."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from geometry.model import Model
from geometry.pose import Pose
from geometry.rotation import matrix_of

Floats = NDArray[np.float64]

POINTS = 1000  # along all lines together, and two on each line at least
TOLERANCE = 0.012  # how far a turned point may be from a line, share of the diameter
ALIKE = 0.4  # share of the wireframe that must come back onto itself ...
EXACT = 0.995  # ... and from which on the turn changes nothing that could be seen
SQUARE = 0.02  # quarter turns are tried where two sides of the bounding box are this much alike
MOST_LINES = 500  # more are no wireframe: a turn of a round body changes nothing that could be told


@lru_cache(maxsize=8)
def near_symmetries(model: Model) -> tuple[Pose, ...]:
    """Half and quarter turns about the axes through the middle of the bounding box.

    Returns
    -------
    target_T_target: what takes a point of the target to where it is after the turn; the nearest to a symmetry
    first; empty for a model of more than MOST_LINES lines.
    """
    if not 0 < len(model.lines) <= MOST_LINES:
        return ()
    points, weights = _line_points(model)
    middle, sides = model.middle, np.ptp(model.vertices, axis=0)
    found: list[tuple[float, Pose]] = []
    for axis in range(3):
        across = np.delete(sides, axis)
        square = abs(across[0] - across[1]) <= SQUARE * model.diameter
        for quarters in (1, 2, 3) if square else (2,):
            turn = matrix_of(0.5 * np.pi * quarters * np.eye(3)[axis])
            distance = _distance_to_lines((points - middle) @ turn.T + middle, model)
            share = float(weights[distance <= TOLERANCE * model.diameter].sum() / weights.sum())
            if ALIKE <= share < EXACT:
                found.append((share, Pose.from_matrix(turn, middle - turn @ middle)))
    found.sort(key=lambda one: -one[0])
    return tuple(pose for _, pose in found)


def _line_points(model: Model) -> tuple[Floats, Floats]:
    """Points (N, 3) along the lines, and the length (N,) that each stands for."""
    ends = model.vertices[model.lines]
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    counts = np.maximum(2, np.rint(POINTS * lengths / max(lengths.sum(), 1e-30)).astype(np.int64))
    line = np.repeat(np.arange(len(counts)), counts)
    along = (np.concatenate([np.arange(n) for n in counts]) + 0.5) / counts[line]
    points = ends[line, 0] + along[:, None] * (ends[line, 1] - ends[line, 0])
    return points, (lengths / counts)[line]


def _distance_to_lines(points: Floats, model: Model) -> Floats:
    """Distance (N,) of points (N, 3) from the nearest line."""
    start = model.vertices[model.lines[:, 0]]
    direction = model.vertices[model.lines[:, 1]] - start
    square = np.maximum(np.einsum("ij,ij->i", direction, direction), 1e-30)
    nearest = np.full(len(points), np.inf)
    for a, d, length2 in zip(start, direction, square, strict=True):
        beside = points - a
        share = np.clip(beside @ d / length2, 0.0, 1.0)
        np.minimum(nearest, np.linalg.norm(beside - share[:, None] * d, axis=1), out=nearest)
    return nearest
