"""Docking gear with curved faces, thin bars and deep hollows, as STL files a CAD program might write.

Nothing was tuned to these shapes: a capsule, an antenna dish, a truss, a ring with petals, a grapple fixture,
a probe with a boom, an angle bracket, and a cart.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import reduce
from operator import add
from pathlib import Path

import numpy as np
from manifold3d import CrossSection, Manifold

Place = tuple[float, float, float]


def capsule() -> Manifold:
    """A blunt cone on a short cylinder, with a hatch and two boxes."""
    body = _turned(0.12, 0.10, 0.05).translate([0, 0, 0.06]) + _turned(0.05, 0.10).translate([0, 0, -0.02])
    hatch = _turned(0.02, 0.035).translate([0, 0, 0.13])
    body = body + hatch - _turned(0.05, 0.025).translate([0, 0, 0.14])
    return body + _box(0.03, 0.05, 0.03, (0.1, 0, -0.02)) + _box(0.02, 0.02, 0.05, (-0.03, 0.06, 0.06))


def dish() -> Manifold:
    """A dish with its feed on a box with one panel."""
    angle = np.linspace(0.0, np.pi / 2.6, 14)
    outside = np.stack([0.08 * np.sin(angle), 0.08 * (1.0 - np.cos(angle))], axis=1)
    inside = outside[::-1] + np.array([0.0, 0.004])
    bowl = CrossSection([np.vstack([outside, inside])]).revolve(48).translate([0, 0, 0.075])
    bus = _turned(0.03, 0.012, segments=24).translate([0, 0, 0.07]) + _box(0.10, 0.08, 0.12)
    bus = bus + _box(0.16, 0.004, 0.08, (0.13, 0, 0)) + _box(0.03, 0.03, 0.02, (-0.03, 0.05, -0.02))
    return bowl + bus + _turned(0.06, 0.003, segments=12).translate([0, 0, 0.11])


def truss() -> Manifold:
    """A boom of four bays of three struts each, with a box at its end."""

    def corner(bay: int, side: int) -> Place:
        angle = 2.0 * np.pi * side / 3.0
        return 0.07 * bay - 0.14, float(0.06 * np.cos(angle)), float(0.06 * np.sin(angle))

    bars: list[Manifold] = []
    for bay in range(5):
        for side in range(3):
            here, beside = corner(bay, side), (side + 1) % 3
            bars.append(_bar(here, corner(bay, beside), 0.010))
            if bay < 4:
                bars.append(_bar(here, corner(bay + 1, side), 0.012))
                bars.append(_bar(here, corner(bay + 1, beside), 0.008))
    return reduce(add, bars) + _box(0.05, 0.06, 0.06, (-0.16, 0, 0))


def petals() -> Manifold:
    """A ring with three guide petals and two lugs that are not alike."""
    ring = _turned(0.03, 0.10) - _turned(0.05, 0.075)
    foot = [[r, y, 0.01] for r in (0.072, 0.086) for y in (-0.03, 0.03)]
    tip = [[r, y, 0.07] for r in (0.05, 0.056) for y in (-0.012, 0.012)]
    petal = Manifold.hull_points([*foot, *tip])
    for third in range(3):
        ring = ring + petal.rotate([0, 0, 120 * third])
    return ring + _box(0.03, 0.02, 0.03, (-0.105, 0, 0)) + _box(0.02, 0.03, 0.02, (0.04, 0.09, 0))


def grapple() -> Manifold:
    """A plate with two holes, a pin with a head, three vanes and a block."""
    plate = _box(0.22, 0.18, 0.015)
    for x in (-0.08, 0.08):
        plate = plate - _turned(0.05, 0.018).translate([x, 0.05, 0])
    plate = plate + _turned(0.09, 0.010, segments=32).translate([0, 0, 0.045])
    plate = plate + _turned(0.008, 0.028, segments=32).translate([0, 0, 0.09])
    for third in range(3):
        plate = plate + _box(0.05, 0.01, 0.05, (0.055, 0, 0.025)).rotate([0, 0, 120 * third + 20])
    return plate + _box(0.04, 0.03, 0.03, (-0.08, -0.06, 0.02))


def probe() -> Manifold:
    """An eight-sided body with a boom, a panel and a nozzle."""
    body = _turned(0.10, 0.06, segments=8) + _box(0.20, 0.012, 0.012, (0.14, 0, 0.02))
    body = body + _box(0.03, 0.05, 0.04, (0.25, 0, 0.02)) + _box(0.006, 0.16, 0.08, (-0.02, 0.13, 0))
    return body + _turned(0.04, 0.03, 0.012, segments=32).translate([0, 0, -0.07])


def angle() -> Manifold:
    """A bracket with a rib and three holes."""
    plate = _box(0.16, 0.10, 0.014) + _box(0.014, 0.10, 0.10, (-0.073, 0, 0.05))
    corners = ((-0.07, 0.0), (0.03, 0.0), (-0.07, 0.085))
    plate = plate + Manifold.hull_points([[x, y, z] for x, z in corners for y in (-0.006, 0.006)])
    plate = plate - _turned(0.05, 0.014, segments=40).translate([0.05, 0.03, 0])
    plate = plate - _turned(0.05, 0.009, segments=40).translate([0.05, -0.03, 0])
    return plate - _turned(0.1, 0.016, segments=40).rotate([0, 90, 0]).translate([-0.07, 0.03, 0.065])


def cart() -> Manifold:
    """A box on six wheels, with a cab and a mast."""
    body = _box(0.16, 0.09, 0.04) + _box(0.05, 0.06, 0.05, (0.03, 0, 0.04))
    body = body + _bar((-0.06, 0, 0.02), (-0.06, 0, 0.1), 0.008) + _box(0.02, 0.05, 0.03, (-0.06, 0, 0.11))
    wheel = _turned(0.025, 0.026, segments=32).rotate([90, 0, 0])
    for x in (-0.055, 0.0, 0.055):
        for y in (-0.06, 0.06):
            body = body + wheel.translate([x, y, -0.02])
    return body


GEAR: dict[str, Callable[[], Manifold]] = {
    one.__name__: one for one in (capsule, dish, truss, petals, grapple, probe, angle, cart)
}


def write_gear(name: str, folder: Path) -> Path:
    """The STL file of a piece of gear, written into a folder; metres."""
    import trimesh

    mesh, file = GEAR[name]().to_mesh(), folder / f"{name}.stl"
    trimesh.Trimesh(mesh.vert_properties[:, :3], mesh.tri_verts).export(file)
    return file


def _box(x: float, y: float, z: float, middle: Place = (0.0, 0.0, 0.0)) -> Manifold:
    return Manifold.cube([x, y, z], True).translate(list(middle))


def _turned(high: float, radius: float, upper: float | None = None, segments: int = 48) -> Manifold:
    """A cylinder or a cone about the z axis, its middle at the origin."""
    return Manifold.cylinder(high, radius, radius if upper is None else upper, segments, True)


def _bar(start: Sequence[float], end: Sequence[float], wide: float) -> Manifold:
    """A square bar between two points."""
    from trimesh.geometry import align_vectors

    ends = np.array([start, end], dtype=np.float64)
    along = ends[1] - ends[0]
    length = float(np.linalg.norm(along))
    place = align_vectors([0, 0, 1], along / length)  # type: ignore[no-untyped-call]
    place[:3, 3] = ends.mean(axis=0)
    return Manifold.cube([wide, wide, length + wide], True).transform(place[:3])
