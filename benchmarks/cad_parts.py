"""Parts of a machine shop, drawn at random, as one closed mesh: spur gears, stepped shafts, brackets."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from benchmarks.machined_parts import Solid, circle, drilled, rounded
from geometry.polygon import triangulate
from numerics.arrays import Floats, Ints

PRESSURE_RAD = np.radians(20.0)  # of involute teeth
ADDENDUM, DEDENDUM = 1.0, 1.25  # of a tooth, over its module


class Layer(NamedTuple):
    """A prism, or frustum, of a stack: outlines (N, 2) below and above, anticlockwise; through holes; levels.

    Of two layers on each other the outline of one lies within the other's or is the same array, as is a hole
    that both have.
    """

    below: Floats
    above: Floats
    holes: Sequence[Floats]
    low: float
    high: float


def plain(outline: Floats, holes: Sequence[Floats], low: float, high: float) -> Layer:
    """A prism."""
    return Layer(outline, outline, holes, low, high)


def stacked(layers: Sequence[Layer]) -> Solid:
    """Layers on each other, lowest first, as one solid without faces inside."""
    pieces = [*_walls(layers), *_levels(layers)]
    before = np.cumsum([0, *(len(places) for places, _ in pieces)])
    faces = np.concatenate([own + first for (_, own), first in zip(pieces, before, strict=False)])
    places = np.concatenate([own for own, _ in pieces])
    vertices, index = np.unique(np.round(places, 9), axis=0, return_inverse=True)
    return vertices, index[faces]


def _at(loop: Floats, level: float) -> Floats:
    return np.column_stack([loop, np.full(len(loop), level)])


def _walls(layers: Sequence[Layer]) -> Iterator[Solid]:
    """What stands around each layer and its holes."""
    for layer in layers:
        around = [(layer.below, layer.above), *((hole, hole) for hole in layer.holes)]
        for number, (lower, upper) in enumerate(around):
            own = np.arange(len(lower))
            following, over = np.roll(own, -1), len(lower)
            halves = [(own, following, following + over), (own, following + over, own + over)]
            wall = np.concatenate([np.column_stack(half) for half in halves])
            places = np.concatenate([_at(lower, layer.low), _at(upper, layer.high)])
            yield places, wall if number == 0 else wall[:, ::-1]


def _levels(layers: Sequence[Layer]) -> Iterator[Solid]:
    """The bottom, the top, and what two layers leave of each other in between."""
    yield _face([layers[0].below, *layers[0].holes], layers[0].low, upwards=False)
    for under, over in pairwise(layers):
        if under.above is over.below:
            continue
        upwards = bool(np.ptp(under.above) > np.ptp(over.below))
        (outer, holes), (inner, covered) = (under.above, under.holes), (over.below, over.holes)
        if not upwards:
            outer, holes, inner, covered = inner, covered, outer, holes
        left = [hole for hole in holes if not any(hole is one for one in covered)]
        yield _face([outer, inner, *left], under.high, upwards)
    yield _face([layers[-1].above, *layers[-1].holes], layers[-1].high, upwards=True)


def _face(loops: Sequence[Floats], level: float, upwards: bool) -> Solid:
    triangles = _between(loops)
    return _at(np.concatenate(loops), level), triangles if upwards else triangles[:, ::-1]


def _between(loops: Sequence[Floats]) -> Ints:
    """Triangles (T, 3) of the first loop less the others, anticlockwise; indices into all of them together.

    Each hole, the nearest first, is joined to the outline by a cut there and back.
    """
    points = np.concatenate(loops)
    first = np.cumsum([0, *map(len, loops)])
    around = np.arange(len(loops[0]))
    rest = [np.arange(a, b)[::-1] for a, b in pairwise(first[1:])]
    while rest:
        apart = [np.linalg.norm(points[around][:, None] - points[hole][None], axis=2) for hole in rest]
        nearest = int(np.argmin([one.min() for one in apart]))
        hole = rest.pop(nearest)
        at, begin = np.unravel_index(np.argmin(apart[nearest]), apart[nearest].shape)
        cut = np.roll(hole, -int(begin))
        around = np.concatenate([around[: at + 1], cut, cut[:1], around[at:]])
    flat = np.column_stack([points[around], np.zeros(len(around))])
    return np.asarray(around[triangulate(flat)])


def keyed(radius: float, segments: int, width: float, reach: float) -> Floats:
    """A circle (N, 2) with a rectangular key seat at +x, ``reach`` from the axis: a hole's or a shaft's."""
    half = np.arcsin(0.5 * width / radius)
    angle = np.linspace(half, 2.0 * np.pi - half, segments)
    arc = radius * np.column_stack([np.cos(angle), np.sin(angle)])
    return np.concatenate([[[reach, 0.5 * width]], arc, [[reach, -0.5 * width]]])


def flattened(radius: float, segments: int, flats: int, depth: float) -> Floats:
    """A circle (N, 2) with one flat, or two opposite ones, so much deep."""
    half = np.arccos(1.0 - depth / radius)
    starts = np.arange(flats) * np.pi
    arcs = [
        np.linspace(start + half, start + 2.0 * np.pi / flats - half, segments // flats) for start in starts
    ]
    angle = np.concatenate(arcs)
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


def toothed(teeth: int, radius: float, flank: int) -> Floats:
    """The outline (N, 2) of a spur gear of that pitch radius: involute flanks of so many points."""
    module = 2.0 * radius / teeth
    base = radius * np.cos(PRESSURE_RAD)
    reach = np.linspace(radius - DEDENDUM * module, radius + ADDENDUM * module, flank)
    pressure = np.arccos(base / np.maximum(reach, base))
    half = 0.5 * np.pi / teeth + (np.tan(PRESSURE_RAD) - PRESSURE_RAD) - (np.tan(pressure) - pressure)
    half = np.minimum(half, 0.95 * np.pi / teeth)  # flanks do not meet at the root
    angle = np.concatenate([-half, half[::-1]])
    distance = np.concatenate([reach, reach[::-1]])
    turns = 2.0 * np.pi * np.arange(teeth)[:, None] / teeth
    every = (angle + turns).ravel()
    return np.asarray(np.tile(distance, teeth)[:, None] * np.column_stack([np.cos(every), np.sin(every)]))


def gear(rng: np.random.Generator, segments: int) -> list[Solid]:
    """A spur gear with a bore, its key seat, a hub on one side, and holes in the web of some."""
    teeth, radius = int(rng.integers(17, 41)), rng.uniform(0.02, 0.08)
    wide, bore = radius * rng.uniform(0.2, 0.5), radius * rng.uniform(0.2, 0.3)
    hub, tall = bore * rng.uniform(1.5, 1.9), radius * rng.uniform(0.15, 0.5)
    seat = keyed(bore, segments, 0.6 * bore, 1.3 * bore)
    around = int(rng.integers(3, 7)) * int(rng.integers(2))
    root = radius * (1.0 - 2.0 * DEDENDUM / teeth)
    web = [
        circle(0.25 * (root - hub), segments, tuple(0.5 * (root + hub) * one)) for one in circle(1.0, around)
    ]
    disc = plain(toothed(teeth, radius, max(2, segments // 16)), [seat, *web], 0.0, wide)
    return [stacked([disc, plain(circle(hub, segments), [seat], wide, wide + tall)])]


def shaft(rng: np.random.Generator, segments: int) -> list[Solid]:
    """A shaft of three to five steps and a chamfered end, a key seat in the widest and flats on the last."""
    steps, first = int(rng.integers(3, 6)), rng.uniform(0.006, 0.012)
    peak = int(rng.integers(1, steps - 1))
    growth = rng.uniform(1.25, 1.45, steps) ** np.where(np.arange(steps) <= peak, 1.0, -1.0)
    radius, long = first * np.cumprod(growth), rng.uniform(0.015, 0.05, steps)
    outlines = [circle(one, segments) for one in radius]
    outlines[peak] = keyed(radius[peak], segments, 0.5 * radius[peak], 0.82 * radius[peak])
    outlines[-1] = flattened(radius[-1], segments, int(rng.integers(1, 3)), 0.25 * radius[-1])
    ends = np.concatenate([[0.0], np.cumsum(long)])
    layers = [plain(one, [], low, high) for one, low, high in zip(outlines, ends, ends[1:], strict=False)]
    chamfer = 0.12 * radius[0]
    narrow = Layer(0.88 * outlines[0], outlines[0], [], 0.0, chamfer)
    return [stacked([narrow, layers[0]._replace(low=chamfer), *layers[1:]])]


def bracket(rng: np.random.Generator, segments: int) -> list[Solid]:
    """A base and an upright plate with round corners and holes, and one to three ribs between them."""
    wide, deep, tall = rng.uniform(0.05, 0.12), rng.uniform(0.04, 0.09), rng.uniform(0.04, 0.1)
    thick = rng.uniform(0.1, 0.15) * min(deep, tall)
    base = _plate(rng, wide, deep, thick, segments)
    upright = _plate(rng, 0.9 * wide, tall, thick, segments)
    back = 0.48 * deep
    # lifted onto its edge: its own y goes upwards, its thickness to the back
    vertices = np.column_stack(
        [upright[0][:, 0], back - thick + upright[0][:, 2], thick + 0.5 * tall + upright[0][:, 1]]
    )
    solids: list[Solid] = [base, (vertices, upright[1][:, ::-1])]
    ribs = int(rng.integers(1, 4))
    out, up = 0.6 * deep, 0.6 * tall
    for place in 0.7 * wide * ((np.arange(ribs) + 0.5) / ribs - 0.5):
        triangle = np.array([(0.0, 0.0), (0.0, up), (-out, 0.0)])
        points, faces = stacked([plain(triangle, [], -0.5 * thick, 0.5 * thick)])
        corner = np.array([place, back - thick, thick])
        solids.append((np.column_stack([points[:, 2], points[:, 0], points[:, 1]]) + corner, faces))
    return solids


def _plate(rng: np.random.Generator, wide: float, deep: float, thick: float, segments: int) -> Solid:
    """A plate with round corners and one to three holes, of different sizes, side by side."""
    count = int(rng.integers(1, 4))
    places = wide * ((np.arange(count) + 0.5) / count - 0.5)
    most = 0.5 * min(wide / count, deep)
    holes = [
        circle(most * rng.uniform(0.2, 0.5), segments, (place, rng.uniform(-0.2, 0.1) * deep))
        for place in places
    ]
    return drilled(rounded(wide, deep, rng.uniform(0.05, 0.2) * deep, segments), holes, 0.0, thick)


CAD: dict[str, Callable[[np.random.Generator, int], list[Solid]]] = {
    "gear": gear,
    "shaft": shaft,
    "bracket": bracket,
}  # another part for each state of the generator
