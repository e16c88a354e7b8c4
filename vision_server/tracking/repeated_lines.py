"""Lines that a model repeats: slots, fins, slats. What one of them is off, the others are off, too.

The lips of a row of slots are lit alike, and each has the same shadow beside it. Their edges lie beside the
model's lines by the same, to the same side: twenty lines say no more of it than one, and a fit that takes
them for twenty witnesses states a pose some times as exact as it is.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from geometry.model import Model
from geometry.roundings import sharp_and_convex
from numerics.arrays import Flags, Floats, Ints
from numerics.kernels import kernel
from vision_server.tracking.lines import LINE_UNKNOWNS

# By hand: so many lines are a row; these are as long as each other to this share, and as parallel, and so are
# the normals of the faces beside them, to this sine.
FEWEST_REPEATED, ALIKE_LENGTH, ALIKE_SINE = 3, 0.02, 0.02


@lru_cache(maxsize=8)
def repetition(model: Model) -> Ints:
    """Which row each line of a model is of, (L,): from 1 on, negative where it runs the other way; 0: none.

    Shared, not to be written to.
    """
    along = np.diff(model.vertices[model.lines], axis=1)[:, 0]
    lengths = np.linalg.norm(along, axis=1)
    along = along / np.maximum(lengths, 1e-12)[:, None]
    if not model.faces:
        return np.zeros(len(lengths), dtype=np.int64)
    normals, convex = _normals(model), sharp_and_convex(model)
    rows, found = np.zeros(len(lengths), dtype=np.int64), 0
    left: Flags = (model.line_faces >= 0).any(axis=1) & ~model.smooth
    for line in range(len(lengths)):
        if not left[line]:
            continue
        alike = left & (np.abs(lengths - lengths[line]) <= ALIKE_LENGTH * lengths[line])
        alike &= np.linalg.norm(np.cross(along, along[line]), axis=1) <= ALIKE_SINE
        alike &= _same_faces(normals, normals[line]) & (convex == convex[line])
        left &= ~alike
        if np.count_nonzero(alike) >= FEWEST_REPEATED:
            found += 1
            rows[alike] = found * np.where(along[alike] @ along[line] > 0.0, 1, -1)
    return rows


def _normals(model: Model) -> Floats:
    """Of the two faces beside each line, (L, 2, 3); 0 of one that is not there."""
    there = model.line_faces >= 0
    return np.asarray(model.face_normals[np.maximum(model.line_faces, 0)] * there[:, :, None])


def _same_faces(normals: Floats, own: Floats) -> Flags:
    """Whether two faces' normals (L, 2, 3) are ``own`` (2, 3), in either order."""
    either = [np.linalg.norm(normals - order, axis=2).max(axis=1) <= ALIKE_SINE for order in (own, own[::-1])]
    return np.asarray(either[0] | either[1])


@kernel()
def offsets_of(row: Ints) -> Ints:
    """Of offsets and turns in turn (2 M,), the row that an offset is of: turns are of none."""
    member = np.zeros(2 * len(row), dtype=np.int64)
    member[::2] = row
    return member


@kernel()
def sums_of_rows(member: Ints, weight: Floats, value: Floats, rows: Floats) -> Floats:
    """Of each row, and of none (K, 11): the weighted sums of what moves its numbers, of these, and of 1."""
    sums = np.zeros((np.abs(member).max() + 1, LINE_UNKNOWNS + 2))
    for i in range(len(member)):
        g, sign = abs(member[i]), np.sign(member[i])
        for k in range(LINE_UNKNOWNS):
            sums[g, k] += sign * weight[i] * rows[i, k]
        sums[g, LINE_UNKNOWNS] += sign * weight[i] * value[i]
        sums[g, LINE_UNKNOWNS + 1] += sign * sign * weight[i]
    return sums
