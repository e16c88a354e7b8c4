"""Axes about which a part is round but for some of its lines: a flange's bolts, the mark on a wheel."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from geometry.model import Model
from geometry.near_symmetries import EXACT, exact_tolerance
from geometry.own_axes import TOLERANCE, own_axes
from geometry.points_along import points_along
from geometry.pose import Pose
from geometry.rotation import matrix_of
from geometry.symmetries import ODD_ANGLES_RAD, count_astray
from numerics.arrays import Floats

ROUND = 0.35  # share of the length of the sharp lines that any turn must bring back (chosen by hand)
POINTS = 4000  # along them, of which ...
TURNED = 300  # ... so many are turned
RIM = 0.95  # of the largest distance from the axis: chamfers of a rim count as rim


@lru_cache(maxsize=8)
def round_axes(model: Model) -> tuple[tuple[Floats, Floats], ...]:
    """Unit directions (3,) and a point (3,), metres, of the axes that a part is nearly round about.

    Looked for along the part's own axes (`own_axes`), through its origin, its middle, and those of its rims;
    none of a body of revolution, of which a turn changes nothing at all.
    """
    sharp = model.lines[~model.smooth]
    if len(sharp) == 0:
        return ()
    cloud, length = points_along(model.vertices, sharp, 0.0, POINTS)
    place = (np.arange(TURNED) + 0.5) / TURNED * length.sum()
    some = cloud[np.searchsorted(np.cumsum(length), place)]
    near = TOLERANCE * model.diameter
    found: list[tuple[Floats, Floats]] = []
    for axis, middle, rings in own_axes(model):
        for centre in (np.zeros(3), middle, *rings):
            if any(known is axis for known, _ in found):
                continue
            turned = [(some - centre) @ matrix_of(angle * axis).T + centre for angle in ODD_ANGLES_RAD]
            if any(_share(points, cloud, near) < ROUND for points in turned):
                continue
            reach = exact_tolerance(axis, some - centre, model.diameter)
            if all(_share(points, cloud, reach) < EXACT for points in turned):
                found.append((axis, centre))
    return tuple(found)


def turned_about(pose: Pose, axis: Floats, centre: Floats, angle_rad: float) -> Pose:
    """A pose whose target is turned about an axis of its own."""
    return pose.compose(Pose.turn_about(centre, matrix_of(angle_rad * axis)))


def rim_middle(model: Model, axis: Floats, centre: Floats) -> Floats:
    """The point (3,) of an axis, metres, about which the outermost rim lies."""
    from_centre = model.vertices - centre
    along = from_centre @ axis
    aside = np.linalg.norm(from_centre - along[:, None] * axis, axis=1)
    rim = along[aside >= RIM * aside.max()]
    return np.asarray(centre + 0.5 * (rim.min() + rim.max()) * axis)


def other_sides(pose: Pose, axis: Floats, middle: Floats) -> list[Pose]:
    """The three other poses in which a rim about an axis looks alike: from behind, and tilted the other way.

    The rim's ``middle`` (3,), in the target's frame, stays where it is.
    """
    place = pose.apply(middle[None])[0]
    half = matrix_of(math.pi * place / np.linalg.norm(place))  # about the line of sight: tilted the other way
    across = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    flip = matrix_of(math.pi * across / np.linalg.norm(across))
    rotations = [pose.matrix @ flip, half @ pose.matrix, half @ pose.matrix @ flip]
    return [Pose.from_matrix(one, place - one @ middle) for one in rotations]


def _share(points: Floats, cloud: Floats, reach: float) -> float:
    """Share of some points (M, 3) that have one of a cloud (N, 3) within reach."""
    return 1.0 - count_astray(np.ascontiguousarray(points), cloud, reach, len(points)) / len(points)
