"""A run folder as a session leaves it, of a plain synthetic cube: small, exact, and needing no data."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from numerics.arrays import Flags, Floats, Grey

CUBE = """V1
8
-0.05 -0.05 -0.05
0.05 -0.05 -0.05
-0.05 0.05 -0.05
0.05 0.05 -0.05
-0.05 -0.05 0.05
0.05 -0.05 0.05
-0.05 0.05 0.05
0.05 0.05 0.05
0
0
6
4 0 2 3 1
4 4 5 7 6
4 0 1 5 4
4 2 6 7 3
4 0 4 6 2
4 1 3 7 5
0
0
"""
GREY = 60


@dataclass(frozen=True)
class Bench:
    """A camera, a cube before it, and the files they live in."""

    model: Model
    model_file: Path
    camera: Camera = field(default_factory=lambda: Camera(320, 240, 400.0, 400.0, 159.5, 119.5))
    pose: Pose = field(default_factory=lambda: Pose(np.array([0.4, 0.6, 0.1]), np.array([0.01, -0.01, 0.35])))

    def image(self) -> Grey:
        """An even grey image: nothing in it is blue or orange."""
        return np.full((self.camera.height, self.camera.width), GREY, np.uint8)


RunMaker = Callable[..., Path]


def step_record(number: int, pose: Pose) -> dict[str, Any]:
    return {
        "iteration": number,
        "image": f"i{number}",
        "settings": {"lights": [number, 0, 7], "shutter_s": 0.0166667, "aperture": 4.0},
        "settings_words": f"left {number} right 0 top 7, 1/60 s, f/4",
        "qualitative": "dim, from the top",
        "decision": "discard" if number == 2 else "keep",
        "reason": f"reason <{number}> & more",
        "set_size": max(1, number - 1),
        "rms_px": 2.0 / number,
        "merit": 4.0 / number,
        "supported_fraction": 0.9,
        "pose": pose.to_dict(),
        "error": {"rotation_deg": 0.1, "translation_m": 2e-4, "translation_fraction_of_range": 6e-4},
    }


def result_record(steps: list[dict[str, Any]], pose: Pose) -> dict[str, Any]:
    covariance = np.diag([1e-8] * 3 + [1e-8] * 3).tolist()
    return {
        "status": "converged",
        "controller": "heuristic",
        "target": "cube",
        "seed": 1,
        "iterations": len(steps),
        "kept": [step["image"] for step in steps if step["decision"] == "keep"],
        "discarded": [step["image"] for step in steps if step["decision"] == "discard"],
        "rms_px": 0.41,
        "merit_px": 0.6,
        "threshold_px": 1.0,
        "pose": pose.to_dict() if steps else None,
        "covariance": covariance if steps else None,
        "seconds": {"total": 2.0, "capture": 0.5, "edges": 0.25, "matching": 0.75, "controller": 0.25},
        "steps": steps,
        "error": steps[-1]["error"] if steps else None,
        "command": "swipl main.pl --seed 1",
    }


def blue(image: Grey) -> Flags:
    """Pixels of the supported lines' colour on an even grey image."""
    return image[:, :, 0].astype(int) - image[:, :, 2] > 40


def orange(image: Grey) -> Flags:
    """Pixels of the unsupported lines' colour on an even grey image."""
    return image[:, :, 2].astype(int) - image[:, :, 0] > 40


def distance_to(points: Floats, start: Floats, end: Floats) -> Any:
    """Distances (N,) of points (N, 2) to the segment start–end."""
    along = end - start
    share = np.clip((points - start) @ along / math.pow(float(np.linalg.norm(along)), 2), 0.0, 1.0)
    return np.linalg.norm(points - start - share[:, None] * along, axis=1)
