"""Corners of facets on a side of another one (T-junctions), as where one was cut and its neighbour was not.

The surface would be open there, and have a line where the part has none.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress

import numpy as np

from geometry.errors import GeometryError
from geometry.face_edges import edges_of
from geometry.polygon import triangulate
from numerics.arrays import Floats, Ints

AT_ONCE = 10_000  # pieces of sides whose corners are looked for together
CORNERS_A_PIECE = 4.0  # so much longer than corners are apart: about so many are near it


def cut_at_junctions(vertices: Floats, triangles: Ints, reach: float) -> Ints:
    """Triangles (T, 3) of a mesh of triangles (U, 3): those with corners of others on a side are cut there.

    Only sides that one facet alone has are looked at, and only their ends: within ``reach`` of a side, in the
    unit of the vertices (V, 3), they lie on it.
    """
    found = [np.empty((4, 0)), *map(np.array, _on_sides(vertices, triangles, reach))]
    facet, side, at, corner = np.concatenate(found, axis=1)
    if not len(facet):
        return triangles
    order = np.lexsort((at, side, facet))
    whole, parts = np.ones(len(triangles), dtype=np.bool_), []
    for rows in np.split(order, np.flatnonzero(np.diff(facet[order])) + 1):
        own = int(facet[rows[0]])
        polygon = np.insert(triangles[own], side[rows].astype(int) + 1, corner[rows].astype(int))
        with suppress(GeometryError):
            parts.append(polygon[triangulate(vertices[polygon])])
            whole[own] = False
    return np.concatenate([triangles[whole], *parts])


def _on_sides(vertices: Floats, triangles: Ints, reach: float) -> Iterator[tuple[Ints, Ints, Floats, Ints]]:
    """Facets, which of their sides, how far along it, and the corner that lies there, (N,) each."""
    edges = edges_of(list(triangles))
    loose = edges.sharers == 1
    if not loose.any():
        return
    from scipy.spatial import cKDTree  # closed meshes do without

    owner = edges.face[edges.begin[loose]]
    ends = np.where(edges.up[edges.begin[loose], None], edges.ends[loose], edges.ends[loose][:, ::-1])
    corners, start = np.unique(ends), vertices[ends[:, 0]]
    step = vertices[ends[:, 1]] - start
    length = np.linalg.norm(step, axis=1)
    size = float(np.linalg.norm(np.ptp(vertices[corners], axis=0)))
    count = np.ceil(length * math.sqrt(len(corners)) / (CORNERS_A_PIECE * size)).astype(int)
    piece_of = np.repeat(np.arange(len(ends)), count)
    place = np.arange(len(piece_of)) - np.repeat(np.cumsum(count) - count, count)
    tree = cKDTree(vertices[corners])
    for first in range(0, len(piece_of), AT_ONCE):
        some, k = piece_of[first : first + AT_ONCE], place[first : first + AT_ONCE]
        middle = start[some] + ((k + 0.5) / count[some])[:, None] * step[some]
        near = tree.query_ball_point(middle, 0.5 * length[some] / count[some] + reach)
        hits = [len(these) for these in near]
        of, k, corner = np.repeat(some, hits), np.repeat(k, hits), corners[np.concatenate(near).astype(int)]
        aside = vertices[corner] - start[of]
        at = (aside * step[of]).sum(axis=1) / length[of] ** 2
        on = np.linalg.norm(aside - at[:, None] * step[of], axis=1) < reach
        on &= (np.minimum(at, 1.0 - at) * length[of] > reach) & (np.floor(at * count[of]) == k)
        on &= (corner[:, None] != triangles[owner[of]]).all(axis=1)
        of, corner, at = of[on], corner[on], at[on]
        yield owner[of], (triangles[owner[of]] == ends[of, :1]).argmax(axis=1), at, corner
