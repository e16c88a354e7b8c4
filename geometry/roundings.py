"""Where the rounded edges of a target are seen: inside of where those of its sharp model are.

Of an edge with the faces' normals n and m, the axis of a rounding of radius r lies at -r a from it, with a =
(n + m) / (1 + n.m). An outline is where the line of sight touches the rounding: off by r (1 - a.u) u, where u
points outwards across the line of sight. Of a crease between two faces in sight, the middle of the rounding
is taken; where on it brightness changes most is the light's affair.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from geometry.model import Model
from numerics.arrays import Flags, Floats, Ints
from numerics.kernels import kernel

# Two faces are as one, without an edge between them that could be rounded, where 1 + the cosine between their
# normals is less than this.
FLAT_FACES = 0.05


@lru_cache(maxsize=8)
def sharp_and_convex(model: Model) -> Flags:
    """Which lines are sharp convex edges between two faces, (L,)."""
    middles = np.array([model.vertices[face].mean(axis=0) for face in model.faces])
    one, two = model.line_faces[:, 0], model.line_faces[:, 1]
    place = model.vertices[model.lines].mean(axis=1)
    behind = ((middles[two] - place) * model.face_normals[one]).sum(axis=1) < 0.0
    closed = ~(model.two_sided[one] | model.two_sided[two])
    return np.asarray(behind & closed & (one >= 0) & (two >= 0) & ~model.smooth)


def shifts_of(model: Model, rotation: Floats, line: Ints, points: Floats, along: Floats) -> Floats:
    """How far rounded edges lie from the model's, (N, 3), per metre of radius, camera frame.

    Parameters
    ----------
    rotation : (3, 3), of the pose.
    line : (N,), of the model.
    points, along : (N, 3), a point of each and the unit vector along it, camera frame.
    """
    if not model.faces:
        return np.zeros(points.shape)
    normals, faces = model.face_normals @ rotation.T, model.line_faces[line]
    return _shifts(normals[faces[:, 0]], normals[faces[:, 1]], sharp_and_convex(model)[line], points, along)


@kernel()
def _shifts(one: Floats, two: Floats, rounds: Flags, points: Floats, along: Floats) -> Floats:
    out = np.zeros(points.shape)
    for i in range(len(points)):
        if rounds[i]:
            out[i] = shift_at(one[i], two[i], points[i], along[i])
    return out


@kernel()
def shift_at(n: Floats, m: Floats, point: Floats, along: Floats) -> Floats:
    """Of one point of an edge between faces with these normals; 0 where they are as one."""
    cosine, both = dot(n, m), n + m
    if 1.0 + cosine <= FLAT_FACES:
        return np.zeros(3)
    apex = both / (1.0 + cosine)
    if dot(n, point) < 0.0 and dot(m, point) < 0.0:
        return np.asarray(both / max(math.sqrt(2.0 + 2.0 * cosine), FLAT_FACES) - apex)
    across = np.cross(point, along)
    length = math.sqrt(dot(across, across))
    outward = across / (length if dot(across, both) >= 0.0 else -length)
    return np.asarray((1.0 - dot(outward, apex)) * outward)


@kernel()
def dot(one: Floats, two: Floats) -> float:
    """Of two vectors (3,)."""
    return float(one[0] * two[0] + one[1] * two[1] + one[2] * two[2])
