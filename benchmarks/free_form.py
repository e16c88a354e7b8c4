"""Free-form bodies drawn at random, of smooth surfaces: lumpy ellipsoids, statues, bottles."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import trimesh

from benchmarks.machined_parts import Solid
from benchmarks.statues import body

AROUND = 5  # edges around the equator of an icosahedron, and twice as many of each subdivision
STATUE_M = 0.07  # a statue's unit, half of its height
WAVES, LUMPS = 8, 0.06  # how many over the ellipsoid; of which share of its radius each is deep
BOTTLE_ROWS = 38  # at most, so that 1024 segments are 78 000 facets


def _subdivisions(segments: int) -> int:
    """Of an icosahedron, for so many segments around: 16, 32, 64 ... have 320, 1280, 5120 ... facets."""
    return max(0, round(math.log2(segments / AROUND)))


def lumpy(rng: np.random.Generator, segments: int) -> list[Solid]:
    """An ellipsoid with lumps, none of whose sides is like another."""
    ball = trimesh.creation.icosphere(subdivisions=_subdivisions(segments))
    directions = rng.normal(size=(WAVES, 3))
    directions *= rng.uniform(2.0, 5.0, (WAVES, 1)) / np.linalg.norm(directions, axis=1, keepdims=True)
    waves = np.cos(ball.vertices @ directions.T + rng.uniform(0.0, 2.0 * np.pi, WAVES))
    vertices = rng.uniform(0.04, 0.09, 3) * ball.vertices * (1.0 + LUMPS * waves.sum(axis=1, keepdims=True))
    return [(vertices, np.asarray(ball.faces, np.int64))]


def statue(rng: np.random.Generator, segments: int) -> list[Solid]:
    """Trunk, head, arms and legs, each so fine, that run into each other."""
    mesh = body(rng, carved=False, subdivisions=_subdivisions(segments))
    return [(STATUE_M * mesh.vertices, np.asarray(mesh.faces, np.int64))]


def bottle(rng: np.random.Generator, segments: int) -> list[Solid]:
    """A body of revolution with a belly, a shoulder, a neck and round ends."""
    from scipy.interpolate import PchipInterpolator

    rows = max(8, min(BOTTLE_ROWS, segments // 2))
    high, wide = rng.uniform(0.12, 0.25), rng.uniform(0.02, 0.045)
    waist, neck = wide * rng.uniform(0.7, 1.0), wide * rng.uniform(0.3, 0.6)
    at = [0.0, 0.25, rng.uniform(0.35, 0.45), 0.6, rng.uniform(0.7, 0.85), 1.0]
    profile = PchipInterpolator(at, [wide, wide, waist, wide, neck, neck])
    lean = np.pi * (np.arange(rows) + 0.5) / rows
    along = 0.5 - 0.5 * np.cos(lean)
    rounding = 0.4 * np.where(along < 0.5, wide, neck)
    within = np.minimum(1.0, np.minimum(along, 1.0 - along) * high / rounding)
    radius = profile(along) * np.sqrt(within * (2.0 - within))
    angle = 2.0 * np.pi * np.arange(segments) / segments
    ring = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(segments)])
    rings = [one * ring + [0.0, 0.0, high * up] for one, up in zip(radius, along, strict=True)]
    vertices = np.concatenate([*rings, [[0.0, 0.0, 0.0], [0.0, 0.0, high]]])
    own, following = np.arange(segments), np.roll(np.arange(segments), -1)
    last, foot, top = (rows - 1) * segments, rows * segments, rows * segments + 1
    faces = [np.column_stack([np.full(segments, foot), following, own])]
    for row in range(0, last, segments):
        faces.append(np.column_stack([own + row, following + row, following + row + segments]))
        faces.append(np.column_stack([own + row, following + row + segments, own + row + segments]))
    faces.append(np.column_stack([np.full(segments, top), own + last, following + last]))
    return [(vertices, np.concatenate(faces))]


FREE_FORM: dict[str, Callable[[np.random.Generator, int], list[Solid]]] = {
    "lumpy": lumpy,
    "statue": statue,
    "bottle": bottle,
}  # another body for each state of the generator
