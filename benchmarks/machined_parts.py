"""Parts as a CAD program writes them: round ones of so many segments, and plates with what is milled on."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from geometry.mesh import FLAT_DEG, SHARP_DEG
from geometry.surface import Surface
from numerics.arrays import Flags, Floats, Ints

Solid = tuple[Floats, Ints]  # vertices (V, 3), metres; triangles (T, 3), wound outwards

PLATE_M, THICK_M = (0.20, 0.15), 0.02


def circle(radius: float, segments: int, middle: tuple[float, float] = (0.0, 0.0)) -> Floats:
    """Corners (N, 2), anticlockwise."""
    angle = 2.0 * np.pi * np.arange(segments) / segments
    return radius * np.column_stack([np.cos(angle), np.sin(angle)]) + middle


def rounded(width: float, depth: float, radius: float, segments: int) -> Floats:
    """A rectangle (N, 2) with round corners, ``segments`` to a full turn."""
    quarter = max(1, segments // 4)
    corners = []
    for number, (x, y) in enumerate([(1, 1), (-1, 1), (-1, -1), (1, -1)]):
        angle = 0.5 * np.pi * (number + np.linspace(0.0, 1.0, quarter + 1))
        middle = (x * (0.5 * width - radius), y * (0.5 * depth - radius))
        corners.append(radius * np.column_stack([np.cos(angle), np.sin(angle)]) + middle)
    return np.concatenate(corners)


def drilled(outline: Floats, holes: list[Floats], low: float, high: float, chamfer: float = 0.0) -> Solid:
    """A plate of an outline (N, 2), anticlockwise, with through holes and a chamfered upper edge."""
    from scipy.spatial import Delaunay

    inset = outline * (1.0 - 2.0 * chamfer / np.ptp(outline, axis=0))
    loops = [outline, *holes]
    flat = np.concatenate([inset, *holes])
    first = np.cumsum([0, *map(len, loops)])
    triangles = Delaunay(flat).simplices
    middle = flat[triangles].mean(axis=1)
    inside = _within(middle, inset)
    for hole in holes:
        inside &= ~_within(middle, hole)
    triangles = triangles[inside]
    a, b, c = (flat[triangles[:, k]] for k in range(3))
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    triangles[area < 0] = triangles[area < 0][:, ::-1]
    triangles = triangles[np.abs(area) > 1e-12]
    count = len(flat)
    levels = [(np.concatenate(loops), low), (flat, high)]
    if chamfer:
        levels.insert(1, (np.concatenate(loops), high - chamfer))
    vertices = np.concatenate([np.column_stack([points, np.full(count, z)]) for points, z in levels])
    faces = [triangles[:, ::-1], triangles + count * (len(levels) - 1)]
    for number, loop in enumerate(loops):
        own = first[number] + np.arange(len(loop))
        following = first[number] + (np.arange(len(loop)) + 1) % len(loop)
        for level in range(len(levels) - 1):
            lower, upper = level * count, (level + 1) * count
            wall = np.concatenate(
                [
                    np.column_stack([own + lower, following + lower, following + upper]),
                    np.column_stack([own + lower, following + upper, own + upper]),
                ]
            )
            faces.append(wall if number == 0 else wall[:, ::-1])
    return vertices, np.concatenate(faces)


def _within(points: Floats, loop: Floats) -> Flags:
    """Which points (N, 2) are inside a closed loop (M, 2)."""
    out = np.zeros(len(points), dtype=bool)
    for a, b in zip(loop, np.roll(loop, -1, axis=0), strict=True):
        spans = (a[1] > points[:, 1]) != (b[1] > points[:, 1])
        if spans.any():
            out[spans] ^= points[spans, 0] < a[0] + (points[spans, 1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
    return out


def cylinder(segments: int) -> list[Solid]:
    """A solid cylinder."""
    return [drilled(circle(0.05, segments), [], 0.0, 0.08)]


def ring(segments: int) -> list[Solid]:
    """A short tube."""
    return [drilled(circle(0.08, segments), [circle(0.05, segments)], 0.0, 0.03)]


def flange(segments: int) -> list[Solid]:
    """A disc with six holes and a hub that stands on it; it is turned onto itself by 60 degrees."""
    segments = 6 * -(-segments // 6)
    bolts = [circle(0.009, segments, tuple(0.06 * one)) for one in circle(1.0, 6)]
    disc = drilled(circle(0.08, segments), [*bolts, circle(0.02, segments)], 0.0, 0.015, 0.003)
    return [disc, drilled(circle(0.035, segments), [circle(0.02, segments)], 0.015, 0.05)]


def body(segments: int) -> list[Solid]:
    """A free-form body without one sharp edge."""
    rows = max(6, segments // 2)
    turn, lean = 2.0 * np.pi * np.arange(segments) / segments, np.pi * (np.arange(rows) + 0.5) / rows
    u, v = (part.ravel() for part in np.meshgrid(turn, lean))
    radius = 0.06 * (
        1.0 + 0.25 * np.sin(v) ** 2 * np.cos(3 * u) + 0.3 * np.cos(v) + 0.2 * np.sin(2 * v) * np.sin(u)
    )
    around = np.column_stack([np.sin(v) * np.cos(u), np.sin(v) * np.sin(u), np.cos(v)]) * radius[:, None]
    top, bottom = around[:segments].mean(axis=0), around[-segments:].mean(axis=0)
    vertices = np.concatenate([around, [top, bottom]])
    own = np.arange(segments)
    following = (own + 1) % segments
    faces = [np.column_stack([np.full(segments, len(around)), own, following])]
    for row in range(rows - 1):
        a, b = row * segments, (row + 1) * segments
        faces.append(np.column_stack([own + a, own + b, following + b]))
        faces.append(np.column_stack([own + a, following + b, following + a]))
    last = (rows - 1) * segments
    faces.append(np.column_stack([following + last, own + last, np.full(segments, len(around) + 1)]))
    return [(vertices, np.concatenate(faces))]


ROUND: dict[str, Callable[[int], list[Solid]]] = {
    "cylinder": cylinder,
    "ring": ring,
    "flange": flange,
    "body": body,
}


def machined(rng: np.random.Generator, segments: int) -> list[Solid]:
    """A plate with round corners and a chamfer; holes, ribs and chamfered bosses at random on it."""
    across, down = int(rng.integers(2, 5)), int(rng.integers(2, 4))
    cell = np.array(PLATE_M) / (across, down)
    holes: list[Floats] = []
    standing: list[Solid] = []
    for number in range(across * down):
        middle = tuple((np.array([number % across, number // across]) + 0.5) * cell - 0.5 * np.array(PLATE_M))
        reach, kind = 0.5 * min(cell), rng.integers(4)
        if kind == 0:
            holes.append(circle(reach * rng.uniform(0.3, 0.7), segments, middle))
        elif kind == 1:
            width, depth = cell * rng.uniform((0.1, 0.3), (0.5, 0.8))
            rib = rounded(width, depth, 0.1 * min(width, depth), 4)
            standing.append(_moved(drilled(rib, [], 0.0, rng.uniform(0.01, 0.05)), middle))
        elif kind == 2:
            radius, high = reach * rng.uniform(0.3, 0.7), rng.uniform(0.01, 0.05)
            standing.append(_moved(drilled(circle(radius, segments), [], 0.0, high, 0.15 * radius), middle))
    corner = rng.uniform(0.02, 0.1) * PLATE_M[1]
    plate = drilled(rounded(*PLATE_M, corner, segments), holes, -THICK_M, 0.0, rng.choice([0.0, 0.004]))
    return [plate, *standing]


def _moved(solid: Solid, middle: tuple[float, float]) -> Solid:
    return solid[0] + [*middle, 0.0], solid[1]


def surface_of(solids: list[Solid]) -> Surface:
    """Solids as the surface of one mesh file."""
    before = np.cumsum([0, *(len(vertices) for vertices, _ in solids)])
    triangles = np.concatenate([own + first for (_, own), first in zip(solids, before, strict=False)])
    vertices = np.concatenate([vertices for vertices, _ in solids])
    groups = np.full(len(triangles), -1)
    return Surface(vertices, list(triangles), groups, np.empty((0, 2), np.int64), FLAT_DEG, SHARP_DEG)
