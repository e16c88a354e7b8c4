"""The axes that a part may be turned about: directions it is built along, and places they go through."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from geometry.chains import chains, chords
from geometry.model import Model
from numerics.arrays import Floats

PARALLEL_COSINE, ACROSS_COSINE = np.cos(np.radians(1.0)), np.sin(np.radians(1.0))  # of normals (by hand)
LEAST_AREA_SHARE = 0.02  # share of the whole surface's, of faces that a part is built along
MOST_FACETS, MOST_TRIED_FACETS = 3000, 200  # triangles that count, and those whose normals are tried
TOLERANCE_SHARE = 0.012  # of the diameter: lines that are alike differ by less, points are off (by hand)
MOST_MIDDLES = 2  # of rings of lines, for each axis
MOST_WIRES = 300  # of the longest curves: turns of them take 0.15 s of processor time at most


class OwnAxis(NamedTuple):
    """A direction that a part may be symmetric about.

    Attributes
    ----------
    direction : (3,), unit.
    middle : (3,), metres, of the box around the part whose sides lie along this axis and those across it.
    rings : (3,), metres, the middles of rings of lines around this direction, see `middles_of_rings`.
    """

    direction: Floats
    middle: Floats
    rings: tuple[Floats, ...]


@lru_cache(maxsize=8)
def own_axes(model: Model) -> tuple[OwnAxis, ...]:
    """The file's axes; for a part that lies aslant in its file, also the normal of its largest faces, that of
    the largest across these, and what is across both.
    """
    wires, tolerance = wires_of(model), TOLERANCE_SHARE * model.diameter
    axes = [(axis, model.middle) for axis in np.eye(3)]
    frame = _frame_of_faces(model)
    if frame is not None:
        along = model.vertices @ frame.T
        middle = 0.5 * (along.min(axis=0) + along.max(axis=0)) @ frame
        axes += [(axis, middle) for axis in frame if np.abs(axis).max() < PARALLEL_COSINE]
    return tuple(OwnAxis(*one, tuple(middles_of_rings(wires, one[0], tolerance))) for one in axes)


def _frame_of_faces(model: Model) -> Floats | None:
    """Rows (3, 3): normals of large faces; None where no faces are large."""
    if not model.faces:
        return None
    corners = model.vertices[model.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(normals, axis=1)
    large = np.argsort(-areas, kind="stable")[:MOST_FACETS]
    units = normals[large] / np.maximum(areas[large, None], np.finfo(float).tiny)
    tried = units[:MOST_TRIED_FACETS]
    shares = areas[large] @ (np.abs(units @ tried.T) > PARALLEL_COSINE) / areas.sum()
    if shares.max() < LEAST_AREA_SHARE:
        return None
    first = tried[np.argmax(shares)]
    across = np.abs(tried @ first) < ACROSS_COSINE
    any_across = np.linalg.svd(first[None])[2][1]
    second = tried[across][np.argmax(shares[across])] if across.any() else any_across
    third = np.cross(first, second)
    third /= np.linalg.norm(third)
    return np.stack([first, np.cross(third, first), third])


@lru_cache(maxsize=8)
def wires_of(model: Model) -> Floats:
    """Both ends (L, 2, 3), metres, of a model's sharp lines; of the facets of a curve, of its chords.

    A hole of 128 segments is 33 chords. Of the longest curves, MOST_WIRES are left. Shared, not to be written
    to.
    """
    arcs, alone = chords(model)
    alone = alone[~model.smooth[alone]]
    wires = model.vertices[np.concatenate([arcs[:, 1:], model.lines[alone]])]
    curve = chains(model)[np.concatenate([arcs[:, 0], alone])]
    whole = np.bincount(curve, np.linalg.norm(wires[:, 1] - wires[:, 0], axis=1), minlength=len(model.lines))
    return np.asarray(wires[np.argsort(-whole[curve], kind="stable")[:MOST_WIRES]])


def middles_of_rings(wires: Floats, axis: Floats, tolerance: float) -> list[Floats]:
    """Points that an axis of this direction may go through, for lines (L, 2, 3) that are alike.

    Lines that a turn takes into each other are as long as each other, as steep, and as high along its axis;
    their middles lie on a circle around it, also where some of the ring are missing.

    Returns
    -------
    (3,), metres, those that most of the wireframe lies around first, MOST_MIDDLES at most.
    """
    along = wires[:, 1] - wires[:, 0]
    middles, lengths = wires.mean(axis=1), np.linalg.norm(along, axis=1)
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
    return lines_apart(list(places[order]), axis, tolerance)[:MOST_MIDDLES]


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


def lines_apart(points: Sequence[Floats], axis: Floats, tolerance: float) -> list[Floats]:
    """Those (3,) through which go different lines of this direction, in order."""
    places = np.array(points).reshape(-1, 3)
    across = places - np.outer(places @ axis, axis)
    kept: list[int] = []
    for index, place in enumerate(across):
        if (((across[kept] - place) ** 2).sum(axis=1) > tolerance**2).all():
            kept.append(index)
    return list(places[kept])
