"""The edges of polygons, and which faces share them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from geometry.polygon import corners_of
from numerics.arrays import Flags, Ints


class FaceEdges(NamedTuple):
    """The undirected edges of some faces, in the order in which the faces first run along them.

    Attributes
    ----------
    ends : (E, 2), vertex indices, the lower first.
    sharers : (E,), how often faces run along each.
    begin : (E,), where those of each edge begin in the following.
    face : (U,), the faces that run along each edge, in their order.
    up : (U,), whether they run from the lower index to the higher.
    """

    ends: Ints
    sharers: Ints
    begin: Ints
    face: Ints
    up: Flags

    def pairs(self, among: Flags) -> tuple[Ints, Flags]:
        """Of some edges (E,) of two sharers: both faces (P, 2), and whether these run the same way (P,)."""
        first = self.begin[among]
        faces = np.stack([self.face[first], self.face[first + 1]], axis=1)
        return faces, np.asarray(self.up[first] == self.up[first + 1])


def edges_of(faces: Sequence[Ints]) -> FaceEdges:
    """The edges of polygons of vertex indices; a side from a vertex to itself is none."""
    corner, following, counts = corners_of(faces)
    a, b, face = corner, corner[following], np.repeat(np.arange(len(faces)), counts)
    kept = a != b
    a, b, face = a[kept], b[kept], face[kept]
    low, high = np.minimum(a, b), np.maximum(a, b)
    _, first, edge, sharers = np.unique(
        pair_keys(low, high), return_index=True, return_inverse=True, return_counts=True
    )
    order = np.argsort(first)
    number = np.empty_like(order)
    number[order] = np.arange(len(order))
    uses = np.argsort(number[edge], kind="stable")
    sharers, first = sharers[order], first[order]
    ends = np.stack([low[first], high[first]], axis=1)
    return FaceEdges(ends, sharers, np.cumsum(sharers) - sharers, face[uses], (a < b)[uses])


def pair_keys(low: Ints, high: Ints) -> Ints:
    """One number for each pair of vertex indices, (N,) each, in their order."""
    return np.asarray((low << 32) | high)
