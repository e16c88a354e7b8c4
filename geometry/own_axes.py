"""The directions that a part is built along: its file's axes, and those of its large plane faces."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from geometry.model import Model
from geometry.pose import Pose
from geometry.rotation import matrix_of
from numerics.arrays import Floats

# Chosen by hand.
PARALLEL, ACROSS = np.cos(np.radians(1.0)), np.sin(np.radians(1.0))  # cosines between normals
LEAST_AREA = 0.02  # share of the whole surface's, of faces that a part is built along
LARGEST, TRIED = 3000, 200  # triangles that count, and those whose normals are tried


class OwnAxis(NamedTuple):
    """A direction that a part may be symmetric about.

    Attributes
    ----------
    direction : (3,), unit.
    middle : (3,), metres, of the box around the part whose sides lie along this axis and those across it.
    """

    direction: Floats
    middle: Floats


@lru_cache(maxsize=8)
def own_axes(model: Model) -> tuple[OwnAxis, ...]:
    """The file's axes; for a part that lies aslant in its file, also the normal of its largest faces, that of
    the largest across these, and what is across both.
    """
    axes = [OwnAxis(axis, model.middle) for axis in np.eye(3)]
    frame = _frame_of_faces(model)
    if frame is None:
        return tuple(axes)
    along = model.vertices @ frame.T
    middle = 0.5 * (along.min(axis=0) + along.max(axis=0)) @ frame
    aslant = [axis for axis in frame if np.abs(axis).max() < PARALLEL]
    return (*axes, *(OwnAxis(axis, middle) for axis in aslant))


@lru_cache(maxsize=8)
def half_turns(model: Model) -> tuple[Pose, ...]:
    """Turns by half about each of a part's own axes, target_T_target, however little they bring back.

    A bracket's plate looks like itself so, but for its holes, though most of the bracket does not.
    """
    return tuple(Pose.turn_about(middle, matrix_of(np.pi * axis)) for axis, middle in own_axes(model))


def _frame_of_faces(model: Model) -> Floats | None:
    """Rows (3, 3): normals of large faces; None where no faces are large."""
    if not model.faces:
        return None
    corners = model.vertices[model.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(normals, axis=1)
    large = np.argsort(-areas, kind="stable")[:LARGEST]
    units = normals[large] / np.maximum(areas[large, None], np.finfo(float).tiny)
    tried = units[:TRIED]
    shares = areas[large] @ (np.abs(units @ tried.T) > PARALLEL) / areas.sum()
    if shares.max() < LEAST_AREA:
        return None
    first = tried[np.argmax(shares)]
    across = np.abs(tried @ first) < ACROSS
    any_across = np.linalg.svd(first[None])[2][1]
    second = tried[across][np.argmax(shares[across])] if across.any() else any_across
    third = np.cross(first, second)
    third /= np.linalg.norm(third)
    return np.stack([first, np.cross(third, first), third])
