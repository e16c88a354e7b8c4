"""Single estimates: N images under random or middle settings, one pose; what scores are calibrated on."""

from __future__ import annotations

import msgspec
import numpy as np

from bridge.messages import Describe, PoseMessage, Settings
from bridge.start_messages import StartArgs
from experiments.kinds import Row
from experiments.plan import Cell
from experiments.worker import Worker
from geometry.pose import Pose
from image_server.simulator.simulator import Simulator
from numerics.arrays import Floats
from vision_server.serve.opening import open_task

RANDOM = "random"


def run(cell: Cell, worker: Worker) -> Row:
    """Photograph a scene and estimate its pose once."""
    device = worker.device(cell)
    description = device.describe()
    arguments = {"matcher": cell.settings.matcher, "seed": cell.seed}
    task = open_task(msgspec.convert(arguments, StartArgs), description)
    lights, _, count = cell.controller_source.partition("-")
    rng = np.random.default_rng(cell.seed)
    names = []
    for number in range(1, int(count) + 1):
        frame = device.capture(_random(description, rng) if lights == RANDOM else _middle(description))
        names.append(f"i{number}")
        task.add(names[-1], frame.pixels, frame.applied)
    found = task.estimate(names)
    row: Row = {"images": len(names), "kept": len(names), "status": "no pose"}
    if found.pose is None:
        return row
    error = device.score(msgspec.convert(found.pose.to_dict(), PoseMessage))
    row |= {
        "status": "estimated",
        "rms_px": found.rms_px,
        "uncertainty": found.uncertainty,
        "score": found.score,
        "ambiguity": found.ambiguity,
        "supported_fraction": found.supported_fraction,
    }
    if error is not None:
        row |= {
            "rotation_deg": error.rotation_deg,
            "translation_fraction": error.translation_fraction_of_range,
        }
    if isinstance(device, Simulator):
        squared = normalised_error_squared(found.pose, found.covariance, device.true_pose)
        row["normalised_error_squared"] = squared
    return row


def _random(device: Describe, rng: np.random.Generator) -> Settings:
    return Settings(
        lights=tuple(int(rng.integers(0, light.levels)) for light in device.lights),
        shutter_s=float(rng.choice(device.shutters_s)),
        aperture=float(rng.choice(device.apertures)),
        focal_length_mm=_first(device.focal_lengths_mm),
        focus_m=_first(device.focuses_m),
    )


def _middle(device: Describe) -> Settings:
    return Settings(
        lights=tuple(light.levels // 2 for light in device.lights),
        shutter_s=device.reference.shutter_s,
        aperture=device.reference.aperture,
        focal_length_mm=_first(device.focal_lengths_mm),
        focus_m=_first(device.focuses_m),
    )


def _first(offered: tuple[float, ...] | None) -> float | None:
    return offered[0] if offered else None


def normalised_error_squared(pose: Pose, covariance: Floats | None, true: Pose) -> float:
    """Squared error of a pose in units of its covariance; 6 on average where that is honest."""
    assert covariance is not None
    step = true.step_from(pose)
    return float(step @ np.linalg.solve(covariance, step))
