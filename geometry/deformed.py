"""A model stretched, sheared or mirrored: what follows from its facets alone is shared with what it was.

Dozens of such models are looked at beside a pose. Which lines follow each other, and which facets a search
may do without, need not be found again for each.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from geometry.model import Model
from numerics.arrays import Floats


class Change(NamedTuple):
    """How a model came of another: what is beside a place (3,), m, was multiplied by a matrix (3, 3)."""

    before: Model
    matrix: Floats
    about: Floats


_CHANGES: WeakKeyDictionary[Model, Change] = WeakKeyDictionary()


def deformed(model: Model, matrix: Floats, about: Floats | None = None) -> Model:
    """The model with what is beside a place, its middle if not told, multiplied by a matrix (3, 3).

    A mirrored model's faces wind outwards again.
    """
    about = model.middle if about is None else about
    vertices = about + (model.vertices - about) @ matrix.T
    faces, triangles = model.faces, model.triangles
    if np.linalg.det(matrix) < 0.0:
        faces, triangles = tuple(face[::-1] for face in faces), triangles[:, ::-1]
    normals = model.face_normals @ np.linalg.inv(matrix)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    out = replace(model, vertices=vertices, faces=faces, triangles=triangles, face_normals=normals)
    _CHANGES[out] = Change(model, matrix, about)
    return out


def change_of(model: Model) -> Change | None:
    """How a model came of another by `deformed`; None of any other model, and of what was made of such."""
    return _CHANGES.get(model)
