"""Parts drawn at random: prisms, plates with blocks, nearly symmetric wheels; buses, tees, towers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from benchmarks.docking_gear import GEAR, write_gear
from geometry.model import find_target
from numerics.arrays import Floats

Solid = tuple[Floats, float, float]  # a ring of corners (N, 2), anticlockwise, its lower and its upper end

WIDTH_M = (0.15, 0.3)


def write_prism(file: Path, rng: np.random.Generator) -> None:
    """A prism of a random outline."""
    outline = _anticlockwise(random_outline(rng))
    outline = outline * (rng.uniform(*WIDTH_M) / np.ptp(outline, axis=0).max())
    high = np.ptp(outline, axis=0).max() * rng.uniform(0.15, 0.7)
    _write(file, [(outline, -0.5 * high, 0.5 * high)])


def write_plate(file: Path, rng: np.random.Generator) -> None:
    """A plate with one to four blocks on either face, which is not itself turned or mirrored."""
    wide = rng.uniform(*WIDTH_M)
    size = wide * np.array([1.0, rng.uniform(0.5, 0.9)])
    thick = wide * rng.uniform(0.08, 0.3)
    solids: list[Solid] = [(_ring(4, np.pi / 4) * size / np.sqrt(2.0), -thick, 0.0)]
    for place in rng.permutation(4)[: rng.integers(1, 5)]:
        middle = size * (np.array([place % 2, place // 2]) - 0.5) * rng.uniform(0.4, 0.6)
        sides, reach = int(rng.integers(3, 7)), min(size) * rng.uniform(0.1, 0.22)
        block = middle + reach * _ring(sides, rng.uniform(0.0, np.pi))
        high = wide * rng.uniform(0.05, 0.4)
        solids.append((block, 0.0, high) if rng.random() < 0.75 else (block, -thick - high, -thick))
    _write(file, solids)


def write_wheel(file: Path, rng: np.random.Generator) -> None:
    """A wheel of five to twelve sides or teeth, turned onto itself but for one block on it."""
    count, radius = int(rng.integers(5, 13)), 0.5 * rng.uniform(*WIDTH_M)
    outline = _ring(count) * radius
    if rng.random() < 0.5:
        angle = 2.0 * np.pi * (np.arange(4 * count) + 0.5) / (4 * count)
        outline = np.stack([np.cos(angle), np.sin(angle)], axis=1) * radius
        outline[np.arange(4 * count) % 4 >= 2] *= rng.uniform(0.7, 0.85)
    thick = radius * rng.uniform(0.2, 0.8)
    size = radius * rng.uniform(0.1, 0.2, 2)
    block = _ring(4, np.pi / 4) * size + [radius * rng.uniform(0.3, 0.5), 0.0]
    _write(file, [(outline, -thick, 0.0), (block, 0.0, radius * rng.uniform(0.1, 0.4))])


def write_bus(file: Path, rng: np.random.Generator) -> None:
    """A satellite's bus: a prism of four to eight sides, a panel on either side, and a box on it."""
    wide = rng.uniform(*WIDTH_M)
    radius, high = 0.22 * wide, wide * rng.uniform(0.2, 0.5)
    solids: list[Solid] = [(radius * _ring(int(rng.integers(4, 9)), np.pi / 4), -high, 0.0)]
    thick, across = 0.015 * wide, wide * rng.uniform(0.2, 0.4)
    for side in (-1.0, 1.0):
        long = wide * rng.uniform(0.25, 0.45)
        middle = np.array([side * (1.1 * radius + 0.5 * long), 0.0])
        panel = middle + _ring(4, np.pi / 4) * np.array([long, across]) / np.sqrt(2.0)
        at = -high * rng.uniform(0.3, 0.7)
        solids.append((panel, at - thick, at + thick))
    box = radius * (rng.uniform(-0.3, 0.3, 2) + rng.uniform(0.3, 0.5, 2) * _ring(4, np.pi / 4))
    solids.append((box, 0.0, wide * rng.uniform(0.05, 0.25)))
    _write(file, solids)


def write_tee(file: Path, rng: np.random.Generator) -> None:
    """A thick T, its stem beside the middle of its bar, with a block on the stem."""
    wide = rng.uniform(*WIDTH_M)
    stem, bar, thick = wide * rng.uniform(0.2, 0.4, 3)
    long, left = wide * rng.uniform(0.6, 1.1), rng.uniform(0.1, 0.5) * (wide - stem)
    right = left + stem
    outline = np.array([
        (0.0, 0.0), (wide, 0.0), (wide, bar), (right, bar),
        (right, long), (left, long), (left, bar), (0.0, bar),
    ])  # fmt: skip
    block = np.array([left + 0.5 * stem, 0.5 * (bar + long)])
    block = block + 0.4 * stem * rng.uniform(0.5, 1.0, 2) * _ring(4, np.pi / 4)
    middle = np.array([0.5 * wide, 0.4 * long])
    _write(file, [(outline - middle, -thick, 0.0), (block - middle, 0.0, wide * rng.uniform(0.05, 0.2))])


def write_tower(file: Path, rng: np.random.Generator) -> None:
    """Two or three prisms on each other, each narrower, turned and moved against the one below."""
    wide = rng.uniform(*WIDTH_M)
    radius, floor, middle = 0.5 * wide, 0.0, np.zeros(2)
    solids: list[Solid] = []
    for _ in range(int(rng.integers(2, 4))):
        high = wide * rng.uniform(0.1, 0.4)
        ring = middle + radius * _ring(int(rng.integers(3, 9)), rng.uniform(0.0, np.pi))
        solids.append((ring, floor, floor + high))
        floor += high
        middle = middle + 0.15 * radius * rng.uniform(-1.0, 1.0, 2)
        radius *= rng.uniform(0.35, 0.55)
    middle_z = 0.5 * floor
    _write(file, [(ring, low - middle_z, top - middle_z) for ring, low, top in solids])


PARTS: dict[str, Callable[[Path, np.random.Generator], None]] = {
    "part": write_prism,
    "plate": write_plate,
    "wheel": write_wheel,
}  # names that are another part for each number
OTHER_PARTS: dict[str, Callable[[Path, np.random.Generator], None]] = {
    "bus": write_bus,
    "tee": write_tee,
    "tower": write_tower,
}  # the same, of shapes that nothing was fitted to


def part_file(name: str, folder: Path, rng: np.random.Generator) -> Path:
    """The file of a target: a part that is drawn into a folder, docking gear, or one of the project's."""
    if name in GEAR:
        return write_gear(name, folder)
    write = PARTS.get(name) or OTHER_PARTS.get(name)
    if write is None:
        return find_target(name)
    file = folder / f"{name}.cao"
    write(file, rng)
    return file


def random_outline(rng: np.random.Generator) -> Floats:
    """Corners (K, 2) of a polygon around its middle: a star of drawn radii, or a stair of right angles."""
    if rng.random() < 0.5:
        corners = int(rng.integers(5, 11))
        angle = 2.0 * np.pi * (np.arange(corners) + rng.uniform(-0.3, 0.3, corners)) / corners
        radius = rng.uniform(0.4, 1.0, corners)
        return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    steps = int(rng.integers(2, 5))
    across, up = np.cumsum(rng.uniform(0.2, 0.8, steps)), np.cumsum(rng.uniform(0.2, 0.8, steps))[::-1]
    stair = [(0.0, 0.0), (across[-1], 0.0)]
    for k in range(steps - 1, -1, -1):
        stair.append((across[k], up[k]))
        if k > 0:
            stair.append((across[k - 1], up[k]))
    stair.append((0.0, up[0]))
    return np.array(stair) - 0.5 * np.array([across[-1], up[0]])


def _ring(corners: int, turn: float = 0.0) -> Floats:
    """Corners (N, 2) of a regular polygon of radius 1, anticlockwise."""
    angle = turn + 2.0 * np.pi * np.arange(corners) / corners
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


def _anticlockwise(outline: Floats) -> Floats:
    following = np.roll(outline, -1, axis=0)
    area = float(np.sum(outline[:, 0] * following[:, 1] - outline[:, 1] * following[:, 0]))
    return outline if area > 0 else outline[::-1]


def _write(file: Path, solids: Sequence[Solid]) -> None:
    """Prisms as a .cao file."""
    points: list[Floats] = []
    faces: list[list[int]] = []
    for ring, low, high in solids:
        count, first = len(ring), sum(map(len, points))
        points += [np.c_[ring, np.full(count, z)] for z in (low, high)]
        around = [list(range(count))[::-1], list(range(count, 2 * count))]
        around += [[i, (i + 1) % count, count + (i + 1) % count, count + i] for i in range(count)]
        faces += [[first + corner for corner in face] for face in around]
    corners = np.concatenate(points)
    text = ["V1", str(len(corners)), *(" ".join(f"{x:.6f}" for x in point) for point in corners), "0", "0"]
    text += [str(len(faces)), *(" ".join(map(str, [len(face), *face])) for face in faces), "0", "0"]
    file.write_text("\n".join(text) + "\n")
