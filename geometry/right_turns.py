"""Turns of regular parts, however little of the target these are: by a third, a quarter, a sixth and so on.

A slender probe's eight-sided body comes back onto itself, and all that stands on it does not. Whether a pose
is turned so only the images tell.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from geometry.model import Model
from geometry.near_symmetries import TOLERANCE, middles_of_rings, wires_of
from geometry.own_axes import own_axes
from geometry.pose import Pose
from geometry.rotation import matrix_of
from geometry.symmetries import SAME_TURN, symmetry_of
from numerics.arrays import Floats

ANGLES_DEG = sorted({*range(30, 360, 30), *range(45, 360, 45)})


@lru_cache(maxsize=8)
def right_turns(model: Model) -> tuple[Pose, ...]:
    """Turns by ANGLES_DEG about axes along the target's own, through its middle and those of rings of lines.

    Without those that bring all of the target back onto itself, and each once.

    Returns
    -------
    target_T_target: what takes a point of the target to where it is after the turn.
    """
    symmetry, tolerance = symmetry_of(model), TOLERANCE * model.diameter
    free, ends = symmetry.free_axis, wires_of(model)
    known = list(symmetry.turns)
    for axis, middle in own_axes(model):
        for place in (middle, *middles_of_rings(ends, axis, tolerance)):
            off = np.linalg.norm(np.cross(axis, place - symmetry.centre))
            if free is not None and off <= tolerance and abs(axis @ free) > 1.0 - SAME_TURN:
                continue
            for angle in ANGLES_DEG:
                pose = Pose.turn_about(place, matrix_of(math.radians(angle) * axis))
                if not any(_are_one(pose, other, model.middle, tolerance) for other in known):
                    known.append(pose)
    return tuple(known[len(symmetry.turns) :])


def _are_one(turn: Pose, other: Pose, middle: Floats, tolerance: float) -> bool:
    """Whether two turns turn alike, and take a point (3,) to the same place."""
    if np.abs(turn.matrix - other.matrix).max() >= SAME_TURN:
        return False
    return bool(np.linalg.norm(turn.apply(middle[None]) - other.apply(middle[None])) <= tolerance)
