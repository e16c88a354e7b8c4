"""Turns that bring most of a target's wireframe, but not all of it, back onto itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from geometry.model import Model
from geometry.own_axes import TOLERANCE_SHARE, lines_apart, own_axes, wires_of
from geometry.points_along import points_along
from geometry.pose import Pose
from geometry.rotation import matrix_of
from numerics.arrays import Flags, Floats
from numerics.kernels import kernel

# By hand. Points along all lines together, and on each line where they are no more than that; each so many-th
# point alone is turned first. Near symmetries are found once for a model.
WIRE_POINTS, LEAST_LINE_POINTS, SCREENED_STEP = 300, 2, 10
LEAST_TOLERANCE_SHARE = 0.004  # of the diameter, where a part is much thinner than long
CLOSER_TIMES = 0.25  # of the tolerance, for where the axis is: beside it as much comes back within all of it
ALIKE_SHARE = 0.4  # share of the wireframe that must come back onto itself ...
ALIKE_OVER_SHARE = 0.35  # ... by half a turn: a plate's rim does, turned over, what stands on it does not ...
SCREENED_SHARE = 0.25  # ... less of few points, which miss some ...
UNCHANGED_SHARE = 0.995  # ... and from which on the turn changes nothing that could be seen
HALF_TURN = 0.5  # of a full one, as are all parts; of equal fractions the floats are equal
FOLDS = range(2, 49)  # n-fold turns that are tried: a gear's to 7.5 degrees; ...
FINE_FOLD = 36  # ... of more, which any small turn is near to, those that bring back as much closely
BESIDE_RAD = np.radians(3.0)  # so much more or less moves the farthest points twice the tolerance, ...
MOST_BESIDE_RAD = np.radians(30.0)  # ... of a half turn about the axis of a slender part at most this ...
PEAK_RATIO = 1.1  # ... and must bring back less by this factor, or the turn is only a small one
ONE_TURN_RAD = np.radians(4.0)  # less than the least of FOLDS; products about two middles differ by 0


class _Back(NamedTuple):
    """What turns by one part of a full turn bring back, shares of the wireframe.

    Attributes
    ----------
    share, closely : within the tolerance, and within CLOSER_TIMES of it.
    middle : (3,), metres, what the axis goes through.
    """

    share: float
    closely: float
    middle: Floats


@lru_cache(maxsize=8)
def near_symmetries(model: Model) -> tuple[Pose, ...]:
    """Turns by multiples of 360 / n degrees, n in FOLDS, about axes along the target's own (`own_axes`).

    They go through the middle of the bounding box, the wireframe's centroid, or what lines that are alike lie
    around (the axis' rings): one mark moves the first two, and a ring of seven is not in the middle of its
    box.

    Returns
    -------
    target_T_target: what takes a point of the target to where it is after the turn; the nearest to a symmetry
    first.
    """
    ends = wires_of(model)
    if len(ends) == 0:
        return ()
    wires = _Wireframe.of_ends(ends, model.diameter)
    closer = replace(wires, tolerance=CLOSER_TIMES * wires.tolerance)
    found: list[tuple[float, Pose]] = []
    for axis, of_box, rings in own_axes(model):
        best: dict[float, _Back] = {}
        through = [of_box, wires.weights @ wires.points, *rings]
        for middle in lines_apart(through, axis, 0.1 * TOLERANCE_SHARE * model.diameter):
            for part, one in _brought_back(wires, closer, axis, middle).items():
                known = best.get(part, one)
                closest = max(known, one, key=lambda back: back.closely)
                best[part] = closest._replace(share=max(known.share, one.share))
        if len(best) > 1 and HALF_TURN in best and best[HALF_TURN].share < ALIKE_SHARE:
            del best[HALF_TURN]  # of a wheel, between two of its spokes
        exactly = replace(wires, tolerance=exact_tolerance(axis, wires.points - of_box, model.diameter))
        for part in _apart(best):
            share, _, middle = best[part]
            angle = 2.0 * np.pi * part
            if share >= UNCHANGED_SHARE and exactly.shares(axis, [angle], middle)[0] >= UNCHANGED_SHARE:
                continue
            found.append((share, Pose.turn_about(middle, matrix_of(angle * axis))))
    found.sort(key=lambda one: -one[0])
    return tuple(turn for _, turn in found)


def exact_tolerance(axis: Floats, points: Floats, diameter: float) -> float:
    """How far a turn that changes nothing may take points (N, 3), given from a place on its axis, metres.

    By the width across the axis: of a thin shaft's length shallow flats are hardly anything.
    """
    width = 2.0 * _farthest(axis, points)
    return max(TOLERANCE_SHARE * min(width, diameter), LEAST_TOLERANCE_SHARE * diameter)


def _farthest(axis: Floats, points: Floats) -> float:
    """How far points (N, 3), given from a place on an axis, are from it at most, metres."""
    return float(np.linalg.norm(np.cross(points, axis), axis=1).max())


@dataclass(frozen=True, eq=False)
class _Wireframe:
    """Points along a model's lines, and the lines that they may come to lie on again.

    Attributes
    ----------
    points : (N, 3), metres, with their ``weights`` (N,), of the length, 1 in all.
    start, direction : (L, 3), of the lines.
    tolerance : metres.
    """

    points: Floats
    weights: Floats
    start: Floats
    direction: Floats
    tolerance: float

    @classmethod
    def of_ends(cls, ends: Floats, diameter: float) -> _Wireframe:
        lines = np.arange(2 * len(ends)).reshape(-1, 2)
        least = LEAST_LINE_POINTS if LEAST_LINE_POINTS * len(ends) <= WIRE_POINTS else 1
        points, weights = points_along(ends.reshape(-1, 3), lines, 0.0, WIRE_POINTS, least)
        start, end = ends[:, 0], ends[:, 1]
        return cls(points, weights / weights.sum(), start, end - start, TOLERANCE_SHARE * diameter)

    def shares(self, axis: Floats, angles: Sequence[float], middle: Floats, every: int = 1) -> Floats:
        """Share of the wireframe that each turn brings back onto itself, by each ``every``-th point."""
        some, weights = self.points[::every] - middle, self.weights[::every]
        turned = np.concatenate([some @ matrix_of(angle * axis).T for angle in angles]) + middle
        near = _on_some_line(turned, self.start, self.direction, self.tolerance)
        return np.asarray(near.reshape(len(angles), len(some)) @ weights / weights.sum())


@kernel()
def _on_some_line(points: Floats, start: Floats, direction: Floats, tolerance: float) -> Flags:
    """Whether points (N, 3) are within the tolerance of a line from ``start`` along ``direction`` (L, 3)."""
    out = np.zeros(len(points), dtype=np.bool_)
    inverse, square = np.empty(len(start)), tolerance * tolerance
    middle, around = start + 0.5 * direction, np.empty(len(start))  # and the square of how far a line reaches
    for line in range(len(start)):
        x, y, z = direction[line]
        length = x * x + y * y + z * z
        inverse[line] = 1.0 / (length + 1e-30)
        around[line] = (0.5 * np.sqrt(length) + tolerance) ** 2
    for i in range(len(points)):
        px, py, pz = points[i]
        for line in range(len(start)):
            dx, dy, dz = px - middle[line, 0], py - middle[line, 1], pz - middle[line, 2]
            if dx * dx + dy * dy + dz * dz > around[line]:
                continue
            x, y, z = direction[line]
            dx, dy, dz = px - start[line, 0], py - start[line, 1], pz - start[line, 2]
            share = min(max((dx * x + dy * y + dz * z) * inverse[line], 0.0), 1.0)
            dx, dy, dz = dx - share * x, dy - share * y, dz - share * z
            if dx * dx + dy * dy + dz * dz <= square:
                out[i] = True
                break
    return out


def _brought_back(wires: _Wireframe, closer: _Wireframe, axis: Floats, middle: Floats) -> dict[float, _Back]:
    """What turns about an axis through a place (3,) bring back, by their part of a full turn.

    Those turns that stand out, of all multiples of n-fold ones that do.
    """
    full = 2.0 * np.pi
    screened = wires.shares(axis, [full / n for n in FOLDS], middle, SCREENED_STEP) >= SCREENED_SHARE
    found: dict[float, float] = {}
    for n in np.array(FOLDS)[screened].tolist():
        (alike,) = wires.shares(axis, [full / n], middle)
        if n > FINE_FOLD and closer.shares(axis, [full / n], middle)[0] < ALIKE_SHARE:
            continue
        parts = [part for part in (k / n for k in range(1, n)) if part not in found]
        if parts and _stands_out(wires, axis, 1.0 / n, middle, alike):
            shares = wires.shares(axis, [full * part for part in parts], middle)
            found.update(zip(parts, shares.tolist(), strict=True))
    return {
        part: _Back(share, float(closer.shares(axis, [full * part], middle)[0]), middle)
        for part, share in found.items()
        if _stands_out(wires, axis, part, middle, share)
    }


def _stands_out(wires: _Wireframe, axis: Floats, part: float, middle: Floats, share: float) -> bool:
    """Whether a turn brings back enough, and more than a little less or a little more of its angle does."""
    if share < (ALIKE_OVER_SHARE if part == HALF_TURN else ALIKE_SHARE):
        return False
    angle, aside = 2.0 * np.pi * part, BESIDE_RAD
    if part == HALF_TURN:
        farthest = max(_farthest(axis, wires.points - middle), 1e-9)
        aside = float(np.clip(2.0 * wires.tolerance / farthest, BESIDE_RAD, MOST_BESIDE_RAD))
    beside = wires.shares(axis, [angle - aside, angle + aside], middle)
    return share >= PEAK_RATIO * float(beside.max())


def _apart(best: Mapping[float, _Back]) -> list[float]:
    """Parts of a full turn, none ONE_TURN_RAD or less from one before it: those of the fold all of whose
    turns bring back most, closely. Beside a tooth's turn other folds have one that brings back as much.
    """
    whole = {
        n: sum(best[part].closely if (part := k / n) in best else 0.0 for k in range(1, n)) / (n - 1)
        for n in FOLDS
    }
    worth = {part: max(whole[n] for n in FOLDS if round(part * n) / n == part) for part in best}
    kept: list[float] = []
    for part in sorted(best, key=lambda one: (-worth[one], -best[one].closely)):
        around = [abs(part - other) for other in kept]
        if all(2.0 * np.pi * min(gap, 1 - gap) > ONE_TURN_RAD for gap in around):
            kept.append(part)
    return kept
