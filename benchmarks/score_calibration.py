"""How far the score of an estimate can be trusted: simulated estimates, right and wrong, by score.

    .venv/bin/python -m benchmarks.score_calibration [--seeds 30-34] [--scenarios nominal,textured,...]

Three targets under five conditions (eclipse, sun, harsh sun; defocus, motion and weak light in two of
them), each from one random frame, one at middle levels, and three random frames together. One JSON object
per estimate, then one per threshold (wrong poses that pass it, share of the right ones that do) and the
normalised error squared of the covariance (6 on average when honest).
"""

from __future__ import annotations

import json
import os
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from typing import Annotated, Any

import msgspec
import numpy as np
import typer

from bridge.messages import Settings
from geometry.camera import Camera
from geometry.model import find_target, load_model
from geometry.pose import Pose
from image_server.simulator import Simulator
from image_server.simulator.scenario import load_scenario, with_conditions
from stack.exposure import relative_exposure
from vision_server.image_set import ImageSet
from vision_server.pipeline import Estimate, PipelineSettings, estimate_pose

TARGETS = ("cube", "fixture", "satellite")
CONDITIONS = (
    (0.0, False),
    (1.0, False),
    (20.0, False),
    (0.0, True),
    (8.0, True),
)  # strength of the sun, hard
SETS = (("r0",), ("middle",), ("r0", "r1", "r2"))
THRESHOLDS = (0.5, 0.8, 0.9, 0.95)
LIMITS = (1.0, 0.01)  # degrees, share of the range


@dataclass(frozen=True)
class Scene:
    """One simulated scene."""

    target: str
    scenario: str
    seed: int
    sun: float
    hard: bool


def normalised_error(estimate: Estimate, true: Pose) -> float:
    """Squared error of a pose in units of its covariance."""
    assert estimate.pose is not None
    assert estimate.covariance is not None
    turn = true.compose(estimate.pose.inverse())
    step = np.r_[turn.rotation_vector, true.translation - turn.matrix @ estimate.pose.translation]
    return float(step @ np.linalg.solve(estimate.covariance, step))


def run_scene(scene: Scene) -> list[dict[str, Any]]:
    """Photograph one scene and estimate its pose from each of SETS."""
    conditions = with_conditions(
        load_scenario(scene.scenario),
        ambient_scale=scene.sun,
        light_power=0.25 if scene.hard else 1.0,
        defocus_sigma_px=4.0 if scene.hard else 0.0,
        motion_px_per_s=(240.0, 160.0) if scene.hard else (0.0, 0.0),
    )
    simulator = Simulator(scene.target, conditions, seed=scene.seed)
    device = simulator.describe()
    assert device.camera is not None
    camera = Camera.from_dict(msgspec.to_builtins(device.camera))
    images = ImageSet(camera.width, camera.height)
    random = np.random.default_rng(scene.seed)
    full = [light.levels - 1 for light in device.lights]
    settings = {
        f"r{number}": Settings(
            lights=tuple(int(random.integers(0, most + 1)) for most in full),
            shutter_s=float(random.choice(device.shutters_s)),
            aperture=float(random.choice(device.apertures)),
        )
        for number in range(3)
    }
    middle = tuple((most + 1) // 2 for most in full)
    settings["middle"] = Settings(
        lights=middle, shutter_s=device.reference.shutter_s, aperture=device.reference.aperture
    )
    for name, wanted in settings.items():
        frame = simulator.capture(wanted)
        exposure = relative_exposure(wanted.shutter_s, wanted.aperture, device.reference) * device.camera.gain
        images.add(name, frame.pixels, exposure, device.camera.gamma)
    model = load_model(find_target(scene.target))
    assert simulator.seed_pose is not None
    rows = []
    for names in SETS:
        found = estimate_pose(
            images, names, model, camera, simulator.seed_pose, PipelineSettings(seed=scene.seed)
        )
        row: dict[str, Any] = {**vars(scene), "images": len(names), "pose": found.pose is not None}
        if found.pose is not None:
            error = found.pose.error_to(simulator.true_pose)
            row |= {
                "right": error.within(*LIMITS),
                "rotation_deg": error.rotation_deg,
                "fraction_of_range": error.translation_fraction_of_range,
                "score": found.score,
                "rms_px": found.rms_px,
                "uncertainty": found.uncertainty,
                "ambiguity": found.ambiguity,
                "supported_fraction": found.supported_fraction,
                "normalised_error_squared": normalised_error(found, simulator.true_pose),
            }
        rows.append(row)
    return rows


def summaries(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """What passes each threshold, and how honest the covariance of the right poses is."""
    found = [row for row in rows if row["pose"]]
    right, wrong = ([row for row in found if row["right"] is flag] for flag in (True, False))
    out: list[dict[str, Any]] = []
    for threshold in THRESHOLDS:
        kept = sum(row["score"] >= threshold for row in right)
        out.append(
            {
                "name": f"score >= {threshold:g}: share of the right poses",
                "value": kept / max(1, len(right)),
                "unit": "share",
                "right": len(right),
                "wrong": len(wrong),
                "wrong_passing": sum(row["score"] >= threshold for row in wrong),
                "no_pose": len(rows) - len(found),
            }
        )
    for hard in (False, True):
        squares = [row["normalised_error_squared"] for row in right if row["hard"] is hard]
        if squares:
            out.append(
                {
                    "name": f"normalised error squared, {'hard' if hard else 'mild'} conditions",
                    "value": float(np.median(squares)),
                    "unit": "median; 5.35 expected",
                    "p90": float(np.percentile(squares, 90)),
                    "trials": len(squares),
                }
            )
    return out


def main(
    seeds: Annotated[str, typer.Option(help="FIRST-LAST")] = "30-32",
    scenarios: str = "nominal",
    quiet: Annotated[bool, typer.Option(help="Print the summaries alone.")] = False,
) -> None:
    """Run all scenes on all cores."""
    first, last = (int(part) for part in seeds.split("-"))
    scenes = [
        Scene(target, scenario, seed, sun, hard)
        for scenario in scenarios.split(",")
        for seed in range(first, last + 1)
        for target in TARGETS
        for sun, hard in CONDITIONS
    ]
    rows = []
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        for part in pool.map(run_scene, scenes):
            rows.extend(part)
            if not quiet:
                print("\n".join(json.dumps(row) for row in part), flush=True)
    for row in summaries(rows):
        print(json.dumps(row))


if __name__ == "__main__":
    typer.run(main)
