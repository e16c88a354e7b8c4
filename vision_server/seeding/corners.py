"""Corners of a model: what a person can point at, in its drawing and in an image."""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from geometry.model import Model
from numerics.arrays import Ints

STRAIGHT_DEG = 30.0  # two lines that go on within it make no corner: facets of a rim; chosen by hand
APART = 0.05  # of the model's size, between outermost points that are no sharp corners; chosen by hand
FEWEST = 4  # of a model with fewer of both, every end of a line can be pointed at


def corners_of(model: Model) -> Ints:
    """Vertex numbers (C,), ascending: where lines that are always seen end or meet at an angle.

    Of a rounded corner, outermost points are given that are not near to others.
    """
    around: dict[int, list[int]] = {}
    for start, end in model.lines[~model.smooth].tolist():
        around.setdefault(start, []).append(end)
        around.setdefault(end, []).append(start)
    sharp = [vertex for vertex, ends in around.items() if not _goes_on(model, vertex, ends)]
    found = _with_far_ones(model, sharp, np.intersect1d(_outermost(model), np.array([*around], np.int64)))
    return np.unique(model.lines) if len(found) < FEWEST else found


def _outermost(model: Model) -> Ints:
    """Vertices of the convex hull; of a flat model, all."""
    try:
        return np.asarray(ConvexHull(model.vertices).vertices, dtype=np.int64)
    except QhullError:
        return np.arange(len(model.vertices))


def _goes_on(model: Model, vertex: int, ends: list[int]) -> bool:
    """Whether two lines meet at a vertex, and are nearly one."""
    if len(ends) != 2:
        return False
    one, other = model.vertices[ends] - model.vertices[vertex]
    cosine = one @ other / max(float(np.linalg.norm(one) * np.linalg.norm(other)), np.finfo(float).tiny)
    return bool(cosine < -np.cos(np.radians(STRAIGHT_DEG)))


def _with_far_ones(model: Model, first: list[int], others: Ints) -> Ints:
    """The first and, farthest first, those of the others that are not near to one that is taken."""
    taken = list(first)
    places = model.vertices[others]
    if len(others) == 0:
        return np.array(sorted(taken), dtype=np.int64)
    start = model.vertices[taken] if taken else model.middle[None]
    gap = np.min([np.linalg.norm(places - point, axis=1) for point in start], axis=0)
    while gap.max() > APART * model.diameter:
        farthest = int(gap.argmax())
        taken.append(int(others[farthest]))
        gap = np.minimum(gap, np.linalg.norm(places - places[farthest], axis=1))
    return np.array(sorted(taken), dtype=np.int64)
