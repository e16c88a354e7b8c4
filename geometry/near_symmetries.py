"""Turns that bring most of a target's wireframe, but not all of it, back onto itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache

import numpy as np

from geometry.chains import chains, runs
from geometry.model import Model
from geometry.own_axes import own_axes
from geometry.points_along import points_along
from geometry.pose import Pose
from geometry.rotation import matrix_of
from numerics.arrays import Flags, Floats
from numerics.kernels import kernel

# Chosen by hand where nothing else is said.
POINTS, LEAST_POINTS = 300, 2  # along all lines together, and on each line where they are no more than that
SCREENED = 10  # each so many-th point alone is turned first
TOLERANCE = 0.012  # how far a turned point may be from a line, share of the diameter
LEAST_TOLERANCE = 0.004  # likewise, of a part that is much thinner than long
CLOSER = 0.25  # of the tolerance, for where the axis is: a centroid beside it brings back as much within that
ALIKE = 0.4  # share of the wireframe that must come back onto itself ...
ALIKE_OVER = 0.35  # ... by half a turn: a plate's rim does, turned over, what stands on it does not ...
SCREENED_ALIKE = 0.25  # ... less of few points, which miss some ...
EXACT = 0.995  # ... and from which on the turn changes nothing that could be seen
HALF = Fraction(1, 2)
FOLDS = range(2, 49)  # n-fold turns that are tried: a gear's to 7.5 degrees; ...
FINE = 36  # ... of more than so many, which any small turn is near to, those that bring back as much closely
BESIDE_RAD = np.radians(3.0)  # so much more or less moves the farthest points twice the tolerance ...
PEAK = 1.1  # ... and must bring back less by this factor, or the turn is only a small one
APART_RAD = np.radians(4.0)  # less than the least of FOLDS; products of turns about two middles differ by 0
MOST_MIDDLES = 2  # of rings of lines, for each axis
MOST_PRODUCTS = 80  # 36-fold turns, and each turned over
MOST_LINES = 300  # and chords, of the longest curves: 0.15 s of processor time at most
CHORD_DEG = 11.0  # by which the arc of a chord bends: it is 0.005 radii off, less than the tolerance


@lru_cache(maxsize=8)
def near_symmetries(model: Model) -> tuple[Pose, ...]:
    """Turns by multiples of 360 / n degrees, n in FOLDS, about axes along the target's own (`own_axes`).

    They go through the middle of the bounding box, the wireframe's centroid, or what lines that are alike lie
    around (`middles_of_rings`): one mark moves the first two, and a ring of seven is not in the middle of its
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
    closer = replace(wires, tolerance=CLOSER * wires.tolerance)
    found: list[tuple[float, Pose]] = []
    for axis, of_box in own_axes(model):
        best: dict[Fraction, tuple[float, float, Floats]] = {}  # share, share of the closer, middle of that
        through = [of_box, wires.weights @ wires.points, *middles_of_rings(ends, axis, wires.tolerance)]
        for middle in _distinct(through, axis, 0.1 * TOLERANCE * model.diameter):
            for part, share in _shares(wires, closer, axis, middle).items():
                if share >= _least(part) and share >= PEAK * _beside(wires, axis, part, middle):
                    (close,) = closer.shares(axis, [2.0 * np.pi * float(part)], middle)
                    known = best.get(part, (0.0, 0.0, middle))
                    placed = middle if close > known[1] else known[2]
                    best[part] = (max(share, known[0]), max(close, known[1]), placed)
        if len(best) > 1 and HALF in best and best[HALF][0] < ALIKE:
            del best[HALF]  # of a wheel, between two of its spokes
        exactly = replace(wires, tolerance=exact_tolerance(axis, wires.points - of_box, model.diameter))
        for part in _apart(best):
            share, _, middle = best[part]
            angle = 2.0 * np.pi * float(part)
            if share >= EXACT and exactly.shares(axis, [angle], middle)[0] >= EXACT:
                continue
            found.append((share, Pose.turn_about(middle, matrix_of(angle * axis))))
    found.sort(key=lambda one: -one[0])
    return tuple(turn for _, turn in found)


def exact_tolerance(axis: Floats, points: Floats, diameter: float) -> float:
    """How far a turn that changes nothing may take points (N, 3), given from a place on its axis, metres.

    By the width across the axis: of a thin shaft's length shallow flats are hardly anything.
    """
    width = 2.0 * float(np.linalg.norm(np.cross(points, axis), axis=1).max())
    return max(TOLERANCE * min(width, diameter), LEAST_TOLERANCE * diameter)


def wires_of(model: Model) -> Floats:
    """Both ends (L, 2, 3), metres, of a model's sharp lines; of the facets of a curve, of its chords.

    A hole of 128 segments is 33 chords. Of the longest curves, MOST_LINES are left.
    """
    pieces: list[tuple[int, int, int]] = []  # one of the chord's lines, its first and its last corner
    followed: set[int] = set()
    for run in runs(model, CHORD_DEG):
        (first, first_back), (last, last_back) = run[0], run[-1]
        followed.update(line for line, _ in run)
        pieces.append((first, model.lines[first, int(first_back)], model.lines[last, int(not last_back)]))
    alone = np.setdiff1d(np.flatnonzero(~model.smooth), list(followed))
    pieces += [(line, *model.lines[line]) for line in alone.tolist()]
    line, start, end = np.array(pieces, dtype=np.int64).reshape(-1, 3).T
    ends = np.stack([model.vertices[start], model.vertices[end]], axis=1)
    ends, curve = ends[start != end], chains(model)[line[start != end]]
    whole = np.bincount(curve, np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1), minlength=len(model.lines))
    return np.asarray(ends[np.argsort(-whole[curve], kind="stable")[:MOST_LINES]])


def middles_of_rings(ends: Floats, axis: Floats, tolerance: float) -> list[Floats]:
    """Points that an axis of this direction may go through, for lines (L, 2, 3) that are alike.

    Lines that a turn takes into each other are as long as each other, as steep, and as high along its axis;
    their middles lie on a circle around it, also where some of the ring are missing.

    Returns
    -------
    (3,), metres, those that most of the wireframe lies around first, MOST_MIDDLES at most.
    """
    along = ends[:, 1] - ends[:, 0]
    middles, lengths = ends.mean(axis=1), np.linalg.norm(along, axis=1)
    alike = np.stack([lengths, np.abs(along @ axis), middles @ axis], axis=1)
    left = np.ones(len(alike), dtype=bool)
    rings: list[tuple[float, Floats]] = []
    for line in range(len(alike)):
        if not left[line]:
            continue
        ring = left & (np.abs(alike - alike[line]).max(axis=1) <= tolerance)
        left &= ~ring
        middle = _middle_of_ring(middles[ring], axis, tolerance) if ring.sum() > 1 else None
        if middle is not None:
            rings.append((float(lengths[ring].sum()), middle))
    weights = np.array([weight for weight, _ in rings])
    places = np.array([middle for _, middle in rings]).reshape(-1, 3)
    near = np.linalg.norm(places[:, None] - places, axis=2) <= 0.5 * tolerance
    order = np.argsort(-(near @ weights), kind="stable")
    return _distinct(list(places[order]), axis, tolerance)[:MOST_MIDDLES]


@lru_cache(maxsize=8)
def near_symmetries_and_products(model: Model) -> tuple[Pose, ...]:
    """The `near_symmetries` and what two of them make: a wheel may be turned over and about its axis at once.

    No two nearer than APART_RAD; MOST_PRODUCTS at most.
    """
    turns = near_symmetries(model)
    found = list(turns)
    known = np.array([np.eye(3), *(turn.matrix for turn in turns)])
    for one in turns:
        for other in turns:
            if len(found) >= MOST_PRODUCTS:
                return tuple(found)
            both = one.matrix @ other.matrix
            if np.tensordot(known, both, 2).max() < 1.0 + 2.0 * np.cos(APART_RAD):
                found.append(one.compose(other))
                known = np.concatenate([known, both[None]])
    return tuple(found)


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
        least = LEAST_POINTS if LEAST_POINTS * len(ends) <= POINTS else 1
        points, weights = points_along(ends.reshape(-1, 3), lines, 0.0, POINTS, least)
        start, end = ends[:, 0], ends[:, 1]
        return cls(points, weights / weights.sum(), start, end - start, TOLERANCE * diameter)

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


def _shares(wires: _Wireframe, closer: _Wireframe, axis: Floats, middle: Floats) -> dict[Fraction, float]:
    """Shares that turns about an axis bring back, by their part of a full turn.

    Of all folds that bring back more than a little less or more of their angle does.
    """
    full = 2.0 * np.pi
    screened = wires.shares(axis, [full / n for n in FOLDS], middle, SCREENED) >= SCREENED_ALIKE
    out: dict[Fraction, float] = {}
    for n in np.array(FOLDS)[screened].tolist():
        (alike,) = wires.shares(axis, [full / n], middle)
        if n > FINE and closer.shares(axis, [full / n], middle)[0] < ALIKE:
            continue
        if alike < _least(Fraction(1, n)) or alike < PEAK * _beside(wires, axis, Fraction(1, n), middle):
            continue
        parts = [part for part in (Fraction(k, n) for k in range(1, n)) if part not in out]
        if parts:
            shares = wires.shares(axis, [full * float(part) for part in parts], middle)
            out.update(zip(parts, shares.tolist(), strict=True))
    return out


def _least(part: Fraction) -> float:
    """The share that a turn by this part of a full one must bring back."""
    return ALIKE_OVER if part == HALF else ALIKE


def _beside(wires: _Wireframe, axis: Floats, part: Fraction, middle: Floats) -> float:
    """The more of what a little less and a little more than a part of a full turn bring back."""
    angle = 2.0 * np.pi * float(part)
    return float(wires.shares(axis, [angle - BESIDE_RAD, angle + BESIDE_RAD], middle).max())


def _apart(best: Mapping[Fraction, tuple[float, float, Floats]]) -> list[Fraction]:
    """Parts of a full turn, none APART_RAD or less from one that goes before: those of the fold all of whose
    turns bring back most, closely. Beside a tooth's turn other folds have one that brings back as much.
    """
    whole = {
        n: sum(best[part][1] if (part := Fraction(k, n)) in best else 0.0 for k in range(1, n)) / (n - 1)
        for n in FOLDS
    }
    worth = {part: max(whole[n] for n in FOLDS if n % part.denominator == 0) for part in best}
    kept: list[Fraction] = []
    for part in sorted(best, key=lambda one: (-worth[one], -best[one][1])):
        around = [abs(part - other) for other in kept]
        if all(2.0 * np.pi * min(gap, 1 - gap) > APART_RAD for gap in around):
            kept.append(part)
    return kept


def _middle_of_ring(points: Floats, axis: Floats, tolerance: float) -> Floats | None:
    """The middle (3,) of a circle about an axis of this direction through points (N, 3); None off circles."""
    across = np.linalg.svd(axis[None])[2][1:]
    centre = points.mean(axis=0)
    if len(points) == 2:
        return np.asarray(centre)
    flat = (points - centre) @ across.T
    equations = np.c_[2.0 * flat, np.ones(len(flat))]
    solved, _, rank, _ = np.linalg.lstsq(equations, (flat**2).sum(axis=1), rcond=1e-6)
    if rank < 3:
        return None
    radii = np.linalg.norm(flat - solved[:2], axis=1)
    return np.asarray(centre + solved[:2] @ across) if np.ptp(radii) <= tolerance else None


def _distinct(points: Sequence[Floats], axis: Floats, tolerance: float) -> list[Floats]:
    """Those (3,) through which go different lines of this direction, in order."""
    places = np.array(points).reshape(-1, 3)
    across = places - np.outer(places @ axis, axis)
    kept: list[int] = []
    for index, place in enumerate(across):
        if (((across[kept] - place) ** 2).sum(axis=1) > tolerance**2).all():
            kept.append(index)
    return list(places[kept])
