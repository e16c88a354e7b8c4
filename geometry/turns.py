"""The turns of a part after which all, much or some of it looks as before: each kind, and who asks for it.

A pose may be mistaken for one so turned, ``pose.compose(turn)``: each turn is a target_T_target, what takes a
point of the target to where it is after the turn. The kinds, and who asks for them in `vision_server`:

- Exact symmetries (`symmetries.symmetry_of`) change nothing that could be seen; a body of revolution may be
  turned by any angle about its free axis. `pipeline` takes poses so turned for one answer, and
  `tracking.turning` takes such a turn for none.
- Near symmetries (`near_symmetries.near_symmetries`) bring back much of the wireframe, as by a gear's tooth.
  A seed pose may be turned so: `trust.ranking` asks within the search range, `trust.rivals` outside of it.
- Two near symmetries one after the other (`near_symmetries_and_products`), and half turns about the part's
  own axes (`half_turns`), whatever these bring back, are asked for at first sight (`trust.all_sides`).
- Right turns (`right_turns`), parts of a full turn, bring back what is regular of a part, as an eight-sided
  body is. First sight asks for them, too, where they fit nearly as well.
- Free turns go about an axis that a part is round about but for some lines (`round_axes`), as a flange is.
  `trust.spun` looks all around in steps that a view tells apart; `trust.rivals` weighs some (`free_turns`).

The check of a pose (`tracking.referee`) asks for near symmetries, right turns and `turns_about_round_axes`,
and looks all around. For `tracking.turning` a pose is a look-alike that a near symmetry, a right turn of half
or a turn about a round axis takes to one that the target can have.

Whether images show a turn about a round axis is asked in three ways, as three things hang on it. In
`trust.spun` `unseen_turns` asks if any turn stands out; else the axis is told as free. In `trust.rivals`
`turned_round` asks how likely the best of `free_turns` is. In `tracking.round_parts` a frame is sure of a
turn if it supports each of `turns_about_round_axes` less.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import lru_cache
from itertools import product

import numpy as np

from geometry.model import Model
from geometry.near_symmetries import ONE_TURN_RAD, UNCHANGED_SHARE, exact_tolerance, near_symmetries
from geometry.own_axes import TOLERANCE_SHARE, own_axes
from geometry.points_along import points_along
from geometry.pose import Pose
from geometry.rotation import matrix_of
from geometry.symmetries import ODD_ANGLES_RAD, ONE_TURN_ENTRY, count_astray, symmetry_of
from numerics.arrays import Floats

MOST_PRODUCTS = 80  # 36-fold turns, and each turned over
RIGHT_TURNS_DEG = sorted({*range(30, 360, 30), *range(45, 360, 45)})  # of right turns: twelfths and eighths
# By hand: share of the length of the sharp lines that any turn about a round axis must bring back ...
ROUND_SHARE = 0.35
ROUND_POINTS, ROUND_TURNED_POINTS = 4000, 300  # ... of points along them, and of so many that are turned
# And more than a shift by so many tolerances does: among thousands of lines any point has one near. By hand
# (by 5 0.3 of a gear and 0.7 of a plate with 2000 lines come to lie near lines, by 10 a tenth and 0.6).
ELSEWHERE_TOLERANCES = 10.0
RIM_SHARE = 0.95  # of the largest distance from the axis: chamfers of a rim count as rim
AXIS_COSINE = 0.999  # cosine between an axis and that of a turn about it
LEAST_FREE_TURN_DEG, FREE_TURNS_A_SIDE = 3.0, 5  # the least free turn, and how many to either side (by hand)


@lru_cache(maxsize=8)
def near_symmetries_and_products(model: Model) -> tuple[Pose, ...]:
    """The `near_symmetries` and what two of them make: a wheel may be turned over and about its axis at once.

    No two nearer than ONE_TURN_RAD; MOST_PRODUCTS at most.
    """
    turns = near_symmetries(model)
    found = list(turns)
    known = np.array([np.eye(3), *(turn.matrix for turn in turns)])
    for one, other in product(turns, turns):
        if len(found) >= MOST_PRODUCTS:
            break
        both = one.matrix @ other.matrix
        if np.tensordot(known, both, 2).max() < 1.0 + 2.0 * np.cos(ONE_TURN_RAD):
            found.append(one.compose(other))
            known = np.concatenate([known, both[None]])
    return tuple(found)


@lru_cache(maxsize=8)
def half_turns(model: Model) -> tuple[Pose, ...]:
    """Turns by half about each of a part's own axes, however little they bring back.

    A bracket's plate looks like itself so, but for its holes, though most of the bracket does not.
    """
    return tuple(Pose.turn_about(middle, matrix_of(np.pi * axis)) for axis, middle, _ in own_axes(model))


@lru_cache(maxsize=8)
def right_turns(model: Model) -> tuple[Pose, ...]:
    """Turns by RIGHT_TURNS_DEG about the target's own axes, through its middle and those of rings of lines.

    A slender probe's eight-sided body comes back so, and all that stands on it does not: only images tell.
    Without turns that bring all of the target back onto itself, and each once.
    """
    symmetry, tolerance = symmetry_of(model), TOLERANCE_SHARE * model.diameter
    free, found = symmetry.free_axis, []
    turns = np.array([turn.matrix for turn in symmetry.turns])
    places = np.array([turn.apply(model.middle[None])[0] for turn in symmetry.turns])
    for axis, middle, rings in own_axes(model):
        for through in (middle, *rings):
            off = np.linalg.norm(np.cross(axis, through - symmetry.centre))
            if free is not None and off <= tolerance and abs(axis @ free) > 1.0 - ONE_TURN_ENTRY:
                continue
            for angle in RIGHT_TURNS_DEG:
                turn = matrix_of(math.radians(angle) * axis)
                place = turn @ (model.middle - through) + through
                alike = np.abs(turns - turn).max(axis=(1, 2)) < ONE_TURN_ENTRY
                if not (np.linalg.norm(places[alike] - place, axis=1) <= tolerance).any():
                    found.append(Pose.turn_about(through, turn))
                    turns, places = np.concatenate([turns, turn[None]]), np.concatenate([places, place[None]])
    return tuple(found)


@lru_cache(maxsize=8)
def round_axes(model: Model) -> tuple[tuple[Floats, Floats], ...]:
    """Unit directions (3,) and points (3,), metres, of axes that a part is round about but for some lines.

    Looked for along the part's own axes (`own_axes`), through its origin, its middle, and those of its rims;
    none of a body of revolution, of which a turn changes nothing at all.
    """
    sharp = model.lines[~model.smooth]
    if len(sharp) == 0:
        return ()
    cloud, length = points_along(model.vertices, sharp, 0.0, ROUND_POINTS)
    place = (np.arange(ROUND_TURNED_POINTS) + 0.5) / ROUND_TURNED_POINTS * length.sum()
    some = cloud[np.searchsorted(np.cumsum(length), place)]
    near = TOLERANCE_SHARE * model.diameter
    found: list[tuple[Floats, Floats]] = []
    for axis, middle, rings in own_axes(model):
        least = max(ROUND_SHARE, _share_by_chance(some, cloud, near, axis))
        for centre in (np.zeros(3), middle, *rings):
            if any(known is axis for known, _ in found):
                continue
            turned = [(some - centre) @ matrix_of(angle * axis).T + centre for angle in ODD_ANGLES_RAD]
            if any(_share(points, cloud, near) < least for points in turned):
                continue
            reach = exact_tolerance(axis, some - centre, model.diameter)
            if all(_share(points, cloud, reach) < UNCHANGED_SHARE for points in turned):
                found.append((axis, centre))
    return tuple(found)


def _share_by_chance(points: Floats, cloud: Floats, reach: float, axis: Floats) -> float:
    """What `_share` is, at most, once the points are shifted across an axis, to where they are not from."""
    across = np.linalg.svd(axis[None])[2][1:]
    return max(_share(points + ELSEWHERE_TOLERANCES * reach * way, cloud, reach) for way in across)


def _share(points: Floats, cloud: Floats, reach: float) -> float:
    """Share of some points (M, 3) that have one of a cloud (N, 3) within reach."""
    return 1.0 - count_astray(np.ascontiguousarray(points), cloud, reach, len(points)) / len(points)


@lru_cache(maxsize=8)
def free_turns(model: Model) -> tuple[tuple[Pose, ...], ...]:
    """Small and large turns about each axis that a model is nearly round about.

    Up to half of the turn that changes nothing.
    """
    out = []
    for axis, centre in round_axes(model):
        half = math.pi / folds_about(model, axis)
        angles = np.geomspace(min(math.radians(LEAST_FREE_TURN_DEG), half), half, FREE_TURNS_A_SIDE)
        out.append(tuple(Pose.turn_about(centre, matrix_of(angle * axis)) for angle in [*angles, *-angles]))
    return tuple(out)


@lru_cache(maxsize=8)
def turns_about_round_axes(model: Model) -> tuple[Pose, ...]:
    """The `free_turns`, and the near symmetries about the same axes, which take petals or teeth to others."""
    turns: list[Pose] = []
    for (axis, _), free in zip(round_axes(model), free_turns(model), strict=True):
        turns += [*free, *_about(axis, near_symmetries(model))]
    return tuple(turns)


def folds_about(model: Model, axis: Floats) -> int:
    """How many turns about an axis, none included, bring a model back onto itself."""
    return len(_about(axis, symmetry_of(model).turns))


def spin_rad(model: Model) -> float:
    """How far a nearly round target need be turned to either side until it has looked all ways it can.

    It is turned by its symmetries, near ones too, anyway: so by half of what lies between two of these.
    """
    axes = [axis for axis, _ in round_axes(model)]
    if len(axes) != 1:
        return math.pi if axes else 0.0
    turns = _about(axes[0], (*symmetry_of(model).turns, *near_symmetries(model)))
    angles = [sign * (turn.rotation_vector @ axes[0]) for turn in turns for sign in (1.0, -1.0)]
    angles = np.sort(np.mod(angles, 2.0 * math.pi)).tolist()
    return 0.5 * float(np.diff([*angles, angles[0] + 2.0 * math.pi]).max())


def _about(axis: Floats, turns: Iterable[Pose]) -> list[Pose]:
    """Those of some turns that go about an axis (3,)."""
    vectors = ((turn, turn.rotation_vector) for turn in turns)
    return [turn for turn, vector in vectors if abs(vector @ axis) >= AXIS_COSINE * np.linalg.norm(vector)]


def turned_about(pose: Pose, axis: Floats, centre: Floats, angle_rad: float) -> Pose:
    """A pose whose target is turned about an axis of its own."""
    return pose.compose(Pose.turn_about(centre, matrix_of(angle_rad * axis)))


def rim_middle(model: Model, axis: Floats, centre: Floats) -> Floats:
    """The point (3,) of an axis, metres, about which the outermost rim lies."""
    from_centre = model.vertices - centre
    along = from_centre @ axis
    aside = np.linalg.norm(from_centre - along[:, None] * axis, axis=1)
    rim = along[aside >= RIM_SHARE * aside.max()]
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
