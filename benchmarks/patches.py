"""The faces of a part as an eye sees them: of a curved one all facets are one patch."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from geometry.model import Model

SMOOTH_DEG = 25.0  # between facets of one curved patch
SAME_CORNER = 1e-6  # of the diameter


def patches(model: Model) -> NDArray[np.intp]:
    """Of each triangle (T,) the patch it is of: what curves by less than SMOOTH_DEG from one to the next."""
    points, triangles = model.vertices, model.triangles
    a, b, c = (points[triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(float).tiny)
    _, place = np.unique(np.round(points / (SAME_CORNER * model.diameter)), axis=0, return_inverse=True)
    sides = np.sort(place.ravel()[triangles[:, [[0, 1], [1, 2], [2, 0]]]].reshape(-1, 2), axis=1)
    owner = np.repeat(np.arange(len(triangles)), 3)
    order = np.lexsort((owner, *sides.T))
    one, other = order[:-1], order[1:]
    shared = (sides[one] == sides[other]).all(axis=1)
    one, other = owner[one[shared]], owner[other[shared]]
    smooth = np.sum(normals[one] * normals[other], axis=1) > math.cos(math.radians(SMOOTH_DEG))
    joined = coo_array((np.ones(smooth.sum()), (one[smooth], other[smooth])), shape=(len(triangles),) * 2)
    return np.asarray(connected_components(joined, directed=False)[1], dtype=np.intp)


def of_faces(model: Model) -> NDArray[np.intp]:
    """Of each face (F,) the first one of its patch."""
    patch = patches(model)
    firsts = model.triangle_face[np.unique(patch, return_index=True)[1]]
    faces = np.arange(len(model.faces))
    faces[model.triangle_face] = firsts[patch]
    return faces
