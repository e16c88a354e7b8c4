"""Calibration of `vision_server check`: poses that are right and wrong, judged on simulated frames.

    .venv/bin/python -m benchmarks.referee [--scenes 250] [--first 0] [--fit] [--plot OUT.png]

Each scene is a target of the project under a scenario drawn from the simulator's, or a frame of a simulated
film before clutter, seen in one to three images. Of each, poses are judged that are off by 0.02 to 30
degrees and as much of the image, and poses as programs get them wrong: refined from a start too far away,
and turned onto a near symmetry. One JSON object: the expected error of the probability (the mean distance
between it and the share that is right, in ten bins of equal count), Brier score, and shares of states.
``--fit`` also prints the coefficients that a logistic regression gives on even scenes, and what these are
worth on odd ones.
"""

from __future__ import annotations

import json
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray
from scipy.optimize import minimize

from benchmarks.films import CAMERA, film
from bridge.errors import BadInput
from bridge.messages import Settings
from geometry.camera import Camera
from geometry.model import Model
from geometry.near_symmetries import near_symmetries
from geometry.pose import Pose
from geometry.rotation import matrix_of
from image_server.simulator import Simulator
from vision_server.image_set import ImageSet
from vision_server.pose.observation import PoseProblem
from vision_server.pose.refinement import refine
from vision_server.tracking import referee
from vision_server.tracking.referee import LIMITS, Evidence, judged, terms

Floats = NDArray[np.float64]

POSES = 8  # of a scene
SCENARIOS = ("nominal", "textured", "harsh", "eclipse", "grazing", "back-lit", "blur", "glint")
BINS = 10
RIDGE = 1e-3


@dataclass(frozen=True)
class Row:
    """One judged pose."""

    scene: int
    right: bool
    probability: float
    evidence: Evidence | None
    rotation_deg: float


def scene(number: int) -> tuple[ImageSet, Model, Camera, Pose]:
    """A scene by number: images, and the true pose."""
    rng = np.random.default_rng([number, 77])
    if number % 3 == 0:
        model, shown = film(number, "lights", 3)
        frames = list(islice(shown, int(rng.integers(1, 2))))
        images = ImageSet(CAMERA.width, CAMERA.height)
        images.add("i1", frames[0].pixels, 1.0, 1.0)
        return images, model, CAMERA, frames[0].pose
    target = ("cube", "fixture", "satellite")[int(rng.integers(3))]
    device = Simulator(target, str(rng.choice(SCENARIOS)), number)
    told = device.describe()
    images = ImageSet(device.camera.width, device.camera.height)
    reference = told.reference
    for k in range(int(rng.integers(1, 4))):
        settings = Settings(
            lights=tuple(int(rng.integers(0, light.levels)) for light in told.lights),
            shutter_s=float(rng.choice(told.shutters_s)),
            aperture=float(rng.choice(told.apertures)),
            focal_length_mm=told.focal_lengths_mm[0] if told.focal_lengths_mm else None,
            focus_m=told.focuses_m[0] if told.focuses_m else None,
        )
        exposure = settings.shutter_s / settings.aperture**2 * reference.aperture**2 / reference.shutter_s
        images.add(f"i{k + 1}", device.capture(settings).pixels, exposure, 1.0)
    return images, device.model, device.camera, device.true_pose


def given_poses(number: int, images: ImageSet, model: Model, camera: Camera, true: Pose) -> list[Pose]:
    """Poses right and wrong."""
    rng = np.random.default_rng([number, 78])
    problem = PoseProblem.at_scale(images.gradients(list(images.images)), model, camera)
    turns = near_symmetries(model)
    poses = []
    for k in range(POSES):
        pose = _off(rng, model, true, 10.0 ** rng.uniform(-1.7, 1.48))
        if k >= POSES - 2:  # as programs get them: refined from too far away
            solution = refine(problem, _off(rng, model, true, rng.uniform(2.0, 15.0)))
            pose = pose if solution is None else solution.pose
        elif k == 0 and len(turns):
            pose = _off(rng, model, true.compose(turns[int(rng.integers(len(turns)))]), 0.05)
        poses.append(pose)
    return [pose for pose in poses if pose.apply(model.pivot[None])[0, 2] > 0.0]


def _off(rng: np.random.Generator, model: Model, pose: Pose, degrees: float) -> Pose:
    """A pose that is off by so many degrees at most, and shifted as far as that moves its corners."""
    axis = rng.normal(size=3)
    turn = matrix_of(np.radians(degrees) * rng.uniform(0.2, 1.0) * axis / np.linalg.norm(axis))
    centre = pose.apply(model.middle[None])[0]
    shift = np.radians(degrees) * 0.5 * model.diameter * rng.normal(size=3) * [1.0, 1.0, 2.0]
    return Pose.from_matrix(turn @ pose.matrix, centre + shift + turn @ (pose.translation - centre))


def rows_of(number: int) -> list[Row]:
    """Judge the poses of one scene."""
    try:
        images, model, camera, true = scene(number)
    except BadInput:
        return []  # the scenario has no light or sun there
    rows = []
    for pose in given_poses(number, images, model, camera, true):
        error = pose.error_to(true)
        found = judged(images, list(images.images), model, camera, pose)
        rows.append(Row(number, error.within(*LIMITS), found.probability, found.evidence, error.rotation_deg))
    return rows


def expected_error(probability: Floats, right: NDArray[np.bool_]) -> float:
    """Mean distance between probability and share, in bins of equal count."""
    order = np.array_split(np.argsort(probability, kind="stable"), BINS)
    gaps = [abs(float(probability[part].mean() - right[part].mean())) for part in order]
    return float(np.average(gaps, weights=[len(part) for part in order]))


def fitted(features: Floats, right: NDArray[np.bool_]) -> Floats:
    """Coefficients of a logistic regression."""

    def loss(beta: Floats) -> float:
        logit = features @ beta
        return float(np.logaddexp(0.0, logit).sum() - logit[right].sum() + RIDGE * beta @ beta)

    return np.asarray(minimize(loss, np.zeros(features.shape[1])).x)


def plotted(probability: Floats, right: NDArray[np.bool_], out: Path) -> None:
    """Share that is right by probability, with exact intervals."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib.figure import Figure

    from experiments.statistics import exact_interval

    figure = Figure(figsize=(4.6, 4.2), layout="constrained")
    axes = figure.subplots()
    axes.plot([0, 1], [0, 1], color="0.7", lw=1)
    for part in np.array_split(np.argsort(probability, kind="stable"), BINS):
        low, high = exact_interval(int(right[part].sum()), len(part))
        place, share = float(probability[part].mean()), float(right[part].mean())
        axes.plot([place, place], [low, high], color="#0072b2", lw=1.2)
        axes.plot(place, share, "o", color="#0072b2", ms=4)
    axes.set(xlabel="stated probability", ylabel="share that is right")
    figure.supxlabel(f"n = {len(right)} poses", fontsize=7, color="0.4")
    figure.savefig(out, dpi=120)


def main(
    scenes: int = 250,
    first: int = 0,
    workers: int = 2,
    fit: Annotated[bool, typer.Option(help="Fit the coefficients, too.")] = False,
    plot: Path | None = None,
) -> None:
    """Judge, and print."""
    with ProcessPoolExecutor(workers) as pool:
        rows = [row for part in pool.map(rows_of, range(first, first + scenes), chunksize=2) for row in part]
    right = np.array([row.right for row in rows])
    stated = np.array([row.probability for row in rows])
    states = np.where(stated >= referee.OK, "ok", np.where(stated < referee.LOST, "lost", "doubtful"))
    print(json.dumps({
        "name": "referee", "value": expected_error(stated, right), "unit": "expected error",
        "poses": len(rows), "right": float(right.mean()), "brier": float(np.mean((stated - right) ** 2)),
        **{state: int((states == state).sum()) for state in ("ok", "doubtful", "lost")},
        "ok_and_wrong": int(((states == "ok") & ~right).sum()),
        "lost_and_right": int(((states == "lost") & right).sum()),
    }))  # fmt: skip
    if plot is not None:
        plotted(stated, right, plot)
    if fit:
        known = [row for row in rows if row.evidence is not None]
        features = np.array([terms(row.evidence) for row in known if row.evidence is not None])
        truth = np.array([row.right for row in known])
        even = np.array([row.scene % 2 == 0 for row in known])
        beta = fitted(features[even], truth[even])
        held_out = 1.0 / (1.0 + np.exp(-features[~even] @ beta))
        print(json.dumps({
            "name": "fit", "value": expected_error(held_out, truth[~even]), "unit": "expected error",
            "even_scenes": beta.round(3).tolist(), "all_scenes": fitted(features, truth).round(3).tolist(),
        }))  # fmt: skip


if __name__ == "__main__":
    typer.run(main)
