"""What makes a scene hard: shadows of bars, an arm in the way, walls of lines, an empty frame.

    .venv/bin/python -m benchmarks.ray_traced_stacks OUT --hard [--count 6] [--seed 1] [MODEL...]

Numbers go through the kinds A (weak light, blur, a wall of lines), B (grazing sun, shadows of bars), C (an
arm in the way, blur), E (all of it) and N (nothing there). With `--off 0.005` each is of a part that is not
quite its model.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from benchmarks import povray
from geometry.model import Model
from geometry.pose import Pose
from numerics.arrays import Floats
from vision_server.trust.stretch import stretched

KINDS = "ABCEN"
SHORTER = 0.8  # along another axis, of what the part is longer along one


@dataclass(frozen=True)
class Conditions:
    """The sun's strength, the lamps' power, and blur at the widest aperture."""

    sun: float
    power: float = 1.0
    defocus_px: float = 0.0
    motion_px_per_s: float = 0.0


def conditions(kind: str, rng: np.random.Generator) -> Conditions:
    """Light and blur of a kind of scene."""
    blur = {"defocus_px": rng.uniform(2.0, 4.5), "motion_px_per_s": rng.uniform(150.0, 300.0)}
    weak = float(rng.choice([1.0, 0.25, 0.25, 0.0625]))
    return {
        "A": Conditions(0.0, 0.25, **blur),
        "B": Conditions(float(rng.choice([8.0, 20.0, 60.0])), weak),
        "C": Conditions(8.0, 0.25, **blur),
        "E": Conditions(20.0, weak, **blur),
        "N": Conditions(float(rng.choice([0.0, 1.0, 8.0])), 1.0),
    }[kind]


def not_quite(model: Model, off: float, rng: np.random.Generator) -> Model:
    """The part of which a model is not quite true: longer along an axis, shorter along another."""
    if off == 0.0:
        return model
    return stretched(model, np.log1p(rng.permutation([off, -SHORTER * off, 0.0])))


def bar(ends: Floats, width_m: float, look: str) -> str:
    """A round bar between two points (2, 3), metres in the camera frame."""
    start, end = (povray.vector(povray.MM * point) for point in ends)
    return f"cylinder {{ {start}, {end}, {povray.MM * 0.5 * width_m:.6g} {look} }}"


def arm(model: Model, pose: Pose, look: str, rng: np.random.Generator) -> str:
    """A bar in front of the target, right across it, as wide as a tenth to a quarter of its diameter."""
    middle = pose.apply(model.middle[None])[0]
    nearer = rng.uniform(0.55, 0.8)
    centre = nearer * middle + nearer * np.r_[rng.uniform(-0.2, 0.2, 2) * model.diameter, 0.0]
    angle = rng.uniform(0.0, math.pi)
    along = np.array([math.cos(angle), math.sin(angle), rng.uniform(-0.3, 0.3)]) * 3.0 * model.diameter
    start = centre - along * (
        1.0 if rng.random() < 0.5 else rng.uniform(0.02, 0.1)
    )  # ends there, or does not
    return bar(np.stack([start, centre + along]), nearer * rng.uniform(0.1, 0.25) * model.diameter, look)


def shadowing(model: Model, pose: Pose, sun: Floats, look: str, rng: np.random.Generator) -> list[str]:
    """Thin bars between the sun and the target, out of the camera's sight where that can be."""
    middle = pose.apply(model.middle[None])[0]
    out = []
    for _ in range(rng.integers(1, 4)):
        across = np.cross(sun, rng.normal(size=3))
        across /= np.linalg.norm(across)
        centre = middle + rng.uniform(1.2, 2.0) * model.diameter * sun
        centre = centre + rng.uniform(-0.25, 0.25) * model.diameter * np.cross(across, sun)
        ends = np.stack([centre - model.diameter * across, centre + model.diameter * across])
        out.append(bar(ends, rng.uniform(0.02, 0.06) * model.diameter, look))
    return out


def lines_behind(model: Model, pose: Pose, rng: np.random.Generator) -> str:
    """A wall of stripes that run along one of the target's lines as it is seen."""
    ends = pose.apply(model.vertices[model.lines[rng.integers(len(model.lines))]])
    seen = ends[:, :2] / ends[:, 2:]
    angle = math.degrees(math.atan2(*(seen[1] - seen[0])[::-1]))
    dark, light = sorted(rng.uniform(0.1, 0.9, 2))
    share = rng.uniform(0.2, 0.6)
    depth = povray.MM * (pose.translation[2] + rng.uniform(0.7, 1.3) * model.diameter)
    period = povray.MM * model.diameter * rng.uniform(0.06, 0.2)
    return (
        "plane { <0, 0, -1>, 0 pigment { gradient y color_map {"
        f" [0 rgb {dark:.3f}] [{share:.3f} rgb {dark:.3f}] [{share:.3f} rgb {light:.3f}]"
        f" [1 rgb {light:.3f}] }}"
        f" scale {period:.4g} rotate <0, 0, {-angle:.2f}> }}"
        f" finish {{ ambient 0 diffuse 0.8 }} translate <0, 0, {depth:.4g}> }}"
    )
