"""Turns that change nothing one could see of a target: its exact symmetries, and the axis of a round one."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations

import numpy as np

from geometry.model import Model
from geometry.near_symmetries import FOLDS, UNCHANGED_SHARE, exact_tolerance
from geometry.points_along import points_along
from geometry.polygon import face_areas
from geometry.pose import Pose
from geometry.rotation import cross_matrix, matrix_of, vector_of
from numerics.arrays import Floats, Ints
from numerics.kernels import kernel

# By hand. Of the cloud that a turned body is held against: spacing, share of the diameter, and most points;
# so many of these are turned. Each is compared with all of the cloud: time is as their product.
CLOUD_SPACING, CLOUD_POINTS, TURNED_POINTS = 0.004, 20000, 400
# By hand. Of round surfaces, how far beside where they were a turn may leave them: share of the diameter, for
# facets, and mean distances of the points of the cloud, so that next to none has none within reach.
BESIDE_SHARE, BESIDE_SPACINGS = 0.02, 3.0
SAME_RADIUS = 1e-3  # of the diameter: corners as far from the middle may be each other's images
ODD_ANGLES_RAD = (0.37, 1.13, 2.2)  # by which only a body of revolution may be turned about its axis
ONE_TURN_ENTRY = 0.05  # largest difference of the matrices of turns that are one
MOST_SYMMETRIES = 2 * FOLDS[-1]  # of a target with an axis, and upside down
MOST_TRIED_TURNS = 20000  # turns that bring corners to corners; one with more alike has n-fold ones only


@dataclass(frozen=True, eq=False)
class Symmetry:
    """What turns leave a target as it looks.

    Attributes
    ----------
    turns : target_T_target, the identity first; of a body of revolution one of each that the free axis
        does not lead to.
    free_axis : (3,), unit, about which the target may be turned by any angle, or None.
    centre : (3,), metres, what all of them leave in its place.
    """

    turns: tuple[Pose, ...]
    free_axis: Floats | None
    centre: Floats


ASYMMETRIC = Symmetry((Pose(np.zeros(3), np.zeros(3)),), None, np.zeros(3))


@lru_cache(maxsize=8)
def symmetry_of(model: Model) -> Symmetry:
    """The exact symmetries of a model's sharp lines and its surface; of that alone where it has no such line.

    A cone has one rim, which a half turn leaves as it is.
    """
    body = _Body.of_model(model)
    for axis in body.axes:
        if all(body.comes_back(matrix_of(angle * axis)) for angle in ODD_ANGLES_RAD):
            across = np.linalg.svd(axis[None])[2][1]
            half = [matrix_of(np.pi * across)]
            turns = body.poses([turn for turn in half if body.comes_back(turn)])
            return Symmetry(turns, _named(axis), body.centre)
    kept: list[Floats] = []
    for turn in body.candidates():
        if _is_new(turn, kept) and body.comes_back(turn):
            kept.append(turn)
    return Symmetry(body.poses(_with_products(body, kept)), None, body.centre)


def if_round(model: Model) -> Symmetry:
    """The symmetries of a model that is round about an axis; none of any other."""
    symmetry = symmetry_of(model) if model.smooth.any() else ASYMMETRIC
    return ASYMMETRIC if symmetry.free_axis is None else symmetry


def turned_towards(pose: Pose, other: Pose, symmetry: Symmetry) -> Pose:
    """The pose, turned about the free axis, if there is one, so that it is turned least against the other."""
    axis = symmetry.free_axis
    if axis is None:
        return pose
    between = pose.matrix.T @ other.matrix  # the turn Q about the axis that maximises trace(Q' between)
    cosine = float(np.trace(between) - axis @ between @ axis)
    sine = -float(np.trace(cross_matrix(axis) @ between))
    turn = matrix_of(np.arctan2(sine, cosine) * axis)
    return pose.compose(Pose.turn_about(symmetry.centre, turn))


@dataclass(frozen=True, eq=False)
class _Body:
    """Points of a model about its middle, as the turns are tried on them.

    Attributes
    ----------
    centre : (3,), what every symmetry leaves in its place.
    cloud : (N, 3), dense, about the centre; ``held`` (M, 3) of them are turned.
    corners : (C, 3), ends of sharp lines, about the centre.
    surface : (S, 3), points of a surface that is round somewhere, about the centre; none of another, which
        its lines tell. ``beside``, metres, is how far from it a symmetry may bring them.
    axes : (3, 3), principal axes, in rows.
    diameter : metres.
    """

    centre: Floats
    cloud: Floats
    held: Floats
    corners: Floats
    surface: Floats
    beside: float
    axes: Floats
    diameter: float

    @classmethod
    def of_model(cls, model: Model) -> _Body:
        sharp = model.lines[~model.smooth]
        if len(sharp):
            points, weights = points_along(
                model.vertices, sharp, CLOUD_SPACING * model.diameter, CLOUD_POINTS
            )
        else:
            corners = model.vertices[model.triangles]
            points = corners.mean(axis=1)
            weights = np.linalg.norm(
                np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
            )
        centre = weights @ points / weights.sum()
        points = points - centre
        moments = (points * weights[:, None]).T @ points
        rng = np.random.default_rng(0)
        some = rng.choice(
            len(points), min(len(points), TURNED_POINTS), replace=False, p=weights / weights.sum()
        )
        held = points[some]
        if len(points) > CLOUD_POINTS:
            points = points[rng.choice(len(points), CLOUD_POINTS, replace=False)]
        corners = model.vertices[np.unique(sharp)] - centre
        axes = np.linalg.eigh(moments)[1].T
        surface, beside = _of_surface(model, rng) if len(sharp) and model.smooth.any() else (points[:0], 0.0)
        return cls(centre, points, held, corners, surface - centre, beside, axes, model.diameter)

    def comes_back(self, turn: Floats) -> bool:
        """Whether a turn (3, 3) about the centre leaves the body as it is."""
        turned = np.ascontiguousarray(self.held @ turn.T)
        astray, vector = int((1.0 - UNCHANGED_SHARE) * len(turned)), vector_of(turn)
        axis = vector / max(float(np.linalg.norm(vector)), np.finfo(float).tiny)
        reach = exact_tolerance(axis, self.held, self.diameter)
        if count_astray(turned, self.cloud, reach, astray) > astray:
            return False
        turned = np.ascontiguousarray(self.surface[:TURNED_POINTS] @ turn.T)
        astray = int((1.0 - UNCHANGED_SHARE) * len(turned))
        return count_astray(turned, self.surface, self.beside, astray) <= astray

    def candidates(self) -> list[Floats]:
        """Turns (3, 3) that may leave the body as it is: n-fold ones, and those of two corners to others."""
        radius = np.linalg.norm(self.corners, axis=1) / self.diameter
        classes = _classes(radius)
        for first, second in combinations([*classes, *classes[:1]], 2):
            pair = _apart(self.corners, first, second)
            if pair is None or len(first) * len(second) > MOST_TRIED_TURNS:
                continue
            return [*self.of_axes(), *_turns_of_pairs(self.corners, pair, first, second, self.diameter)]
        return list(self.of_axes())

    def of_axes(self) -> Iterator[Floats]:
        """Turns (3, 3) about the principal axes: half ones, and all multiples of an n-fold one.

        A turn by half as much must not leave the body as it is: small ones of a thin rod all do.
        """
        for axis in self.axes:
            yield matrix_of(np.pi * axis)
            for n in FOLDS:
                angle = 2.0 * np.pi / n
                turn, half = matrix_of(angle * axis), matrix_of(0.5 * angle * axis)
                if self.comes_back(turn) and not self.comes_back(half):
                    yield from (matrix_of(k * angle * axis) for k in range(1, n))

    def poses(self, turns: list[Floats]) -> tuple[Pose, ...]:
        """The identity and these turns about the centre, each once."""
        others = [turn for turn in turns if np.abs(turn - np.eye(3)).max() >= ONE_TURN_ENTRY]
        return (*ASYMMETRIC.turns, *(Pose.turn_about(self.centre, turn) for turn in others))


def _of_surface(model: Model, rng: np.random.Generator) -> tuple[Floats, float]:
    """Points (CLOUD_POINTS, 3) of a surface, at random, and how far others of it may be from the nearest."""
    first, second, third = model.vertices[model.triangles].transpose(1, 0, 2)
    areas = face_areas(model.vertices, list(model.triangles))
    one = rng.choice(len(areas), CLOUD_POINTS, p=areas / areas.sum())
    along, across = np.sqrt(rng.random(CLOUD_POINTS)), rng.random(CLOUD_POINTS)
    weights = np.stack([1.0 - along, along * (1.0 - across), along * across])
    points = np.einsum("kn,knc->nc", weights, np.stack([first[one], second[one], third[one]]))
    spacing = float(np.sqrt(areas.sum() / CLOUD_POINTS))
    return points, max(BESIDE_SHARE * model.diameter, BESIDE_SPACINGS * spacing)


@kernel()
def count_astray(points: Floats, cloud: Floats, reach: float, most: int) -> int:
    """How many points (N, 3) have none of the cloud (M, 3) within reach; counted to one over ``most``."""
    astray = 0
    for i in range(len(points)):
        near = False
        for k in range(len(cloud)):
            x, y, z = points[i, 0] - cloud[k, 0], points[i, 1] - cloud[k, 1], points[i, 2] - cloud[k, 2]
            if x * x + y * y + z * z <= reach * reach:
                near = True
                break
        if not near:
            astray += 1
            if astray > most:
                break
    return astray


def _is_new(turn: Floats, kept: list[Floats]) -> bool:
    return not any(np.abs(turn - known).max() < ONE_TURN_ENTRY for known in kept)


def _with_products(body: _Body, turns: list[Floats]) -> list[Floats]:
    """Turns (3, 3) with all that they make one after the other: symmetries are a group.

    The facets of a hole may come to facets by fewer turns than the part around it has, of which some are
    then found about its axis alone.
    """
    kept = list(turns)
    for turn in kept:  # which grows meanwhile
        for other in turns:
            product = turn @ other
            if len(kept) < MOST_SYMMETRIES and _is_new(product, kept) and body.comes_back(product):
                kept.append(product)
    return kept


def _named(axis: Floats) -> Floats:
    """The axis as one would write it: rounded, its largest part positive."""
    rounded = np.round(axis, 9) + 0.0
    return np.asarray(rounded * np.sign(rounded[np.argmax(np.abs(rounded))]))


def _classes(radius: Floats) -> list[Ints]:
    """Corners (C,) by their distance from the centre, the smallest class first; none in the centre itself."""
    order = np.argsort(radius, kind="stable")
    breaks = np.flatnonzero(np.diff(radius[order]) > SAME_RADIUS) + 1
    classes = [part for part in np.split(order, breaks) if len(part) and radius[part[0]] > 10 * SAME_RADIUS]
    return sorted(classes, key=len)


def _apart(corners: Floats, first: Ints, second: Ints) -> tuple[int, int] | None:
    """A corner of each class that are not on one line with the centre."""
    a = corners[first[0]] / np.linalg.norm(corners[first[0]])
    others = corners[second] / np.linalg.norm(corners[second], axis=1, keepdims=True)
    good = np.flatnonzero(np.abs(others @ a) < 0.95)
    return (int(first[0]), int(second[good[0]])) if len(good) else None


def _turns_of_pairs(
    corners: Floats, pair: tuple[int, int], first: Ints, second: Ints, diameter: float
) -> list[Floats]:
    """Turns that bring a pair of corners onto pairs of the same classes that are as far apart."""

    def frame(a: Floats, b: Floats) -> Floats:
        x = a / np.linalg.norm(a)
        z = np.cross(a, b)
        z /= np.linalg.norm(z)
        return np.stack([x, np.cross(z, x), z], axis=1)

    a, b = corners[pair[0]], corners[pair[1]]
    apart = np.linalg.norm(a - b)
    gaps = np.linalg.norm(corners[first][:, None] - corners[second][None], axis=2)
    own = frame(a, b)
    return [
        frame(corners[first[i]], corners[second[j]]) @ own.T
        for i, j in np.argwhere(np.abs(gaps - apart) < 2.0 * SAME_RADIUS * diameter)
    ]
