"""Calibration of `vision_server check`: poses that are right and wrong, judged on simulated frames.

    .venv/bin/python -m benchmarks.referee [--scenes 250] [--first 0] [--rows FILE] [--fit] [--plot OUT.png]
    .venv/bin/python -m benchmarks.referee --stacks STACK_FOLDER [--stacks ...]

Each scene is a target of the project under a scenario drawn from the simulator's, or a frame of a simulated
film before clutter, of a random part or of a printed box with rounded edges, seen in one to three images; or
three sets of images of each light stack (``--stacks``, once for each). Of each, poses are judged that are off
by 0.02 to 30 degrees and as much of the image, and poses as programs get them wrong: refined from a start too
far away, from corners of which two are interchanged, and turned onto a near symmetry. One JSON object: the
expected error of the probability (the mean distance between it and the share that is right, in ten bins of
equal count), Brier score, and shares of states. With ``--rows`` poses that were judged are kept, and not
judged again. ``--fit`` prints the calibration by maximum likelihood, and what they are worth: the poses
of each target judged by a fit to the others' (all random parts are one, and all boxes), which is also what is
plotted.
"""

from __future__ import annotations

import json
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated
from zlib import crc32

import cv2
import msgspec
import numpy as np
import typer
from numpy.typing import NDArray
from scipy.optimize import minimize

from benchmarks.films import CAMERA, film
from benchmarks.photographs import image_set, stack_studio
from benchmarks.trust_rows import SETS, drawn_set
from bridge.errors import BadInput
from bridge.messages import Settings
from geometry.camera import Camera
from geometry.model import Model
from geometry.near_symmetries import near_symmetries
from geometry.pose import Pose
from geometry.rotation import matrix_of
from image_server.simulator import Simulator
from stack.exposure import relative_exposure
from vision_server.image_set import ImageSet
from vision_server.pose.observation import PoseProblem
from vision_server.pose.refinement import refine
from vision_server.segments.extraction import extract_segments
from vision_server.tracking import referee
from vision_server.tracking.chances import CALIBRATION, Calibration, Chances, probability
from vision_server.tracking.referee import LIMITS, judged

Floats = NDArray[np.float64]

POSES = 8  # of a scene
SCENARIOS = ("nominal", "textured", "harsh", "eclipse", "grazing", "back-lit", "blur", "glint")
BINS = 10
RIDGE = 1e-5  # a hundred times as much keeps `elsewhere` at -7 where poses tell -2
LEAST_LIKELY = 1e-6
CORNERS, MOST_OFF_PX, INTERCHANGED = 8, 3.0, 0.3


@dataclass(frozen=True)
class Row:
    """One judged pose, and where it is from: drawn, turned, corners or refined."""

    scene: str
    shape: str
    source: str
    right: bool
    chances: Chances
    rotation_deg: float


def scene(number: int) -> tuple[ImageSet, Model, Camera, Pose]:
    """A scene by number: images, and the true pose."""
    rng = np.random.default_rng([number, 77])
    if number % 3 == 0:
        model, shown = film(number, "printed", 3) if number % 2 else film(4 * number + 3, "lights", 3)
        frame = next(shown)
        images = ImageSet(CAMERA.width, CAMERA.height)
        images.add("i1", frame.pixels, 1.0, 1.0)
        return images, model, CAMERA, frame.pose
    target = ("cube", "fixture", "satellite")[int(rng.integers(3))]
    device = Simulator(target, str(rng.choice(SCENARIOS)), number)
    told = device.describe()
    images = ImageSet(device.camera.width, device.camera.height)
    for k in range(int(rng.integers(1, 4))):
        settings = Settings(
            lights=tuple(int(rng.integers(0, light.levels)) for light in told.lights),
            shutter_s=float(rng.choice(told.shutters_s)),
            aperture=float(rng.choice(told.apertures)),
            focal_length_mm=told.focal_lengths_mm[0] if told.focal_lengths_mm else None,
            focus_m=told.focuses_m[0] if told.focuses_m else None,
        )
        exposure = relative_exposure(settings.shutter_s, settings.aperture, told.reference)
        images.add(f"i{k + 1}", device.capture(settings).pixels, exposure, 1.0)
    return images, device.model, device.camera, device.true_pose


def given_poses(
    number: int, images: ImageSet, model: Model, camera: Camera, true: Pose
) -> list[tuple[str, Pose]]:
    """Poses right and wrong, and where each is from."""
    rng = np.random.default_rng([number, 78])
    problem = PoseProblem.at_scale(images.gradients(list(images.images)), model, camera)
    turns = near_symmetries(model)
    poses = []
    for k in range(POSES):
        source, pose = "drawn", _off(rng, model, true, 10.0 ** rng.uniform(-1.7, 1.48))
        if k >= POSES - 2:  # as programs get them: refined from too far away
            solution = refine(problem, _off(rng, model, true, rng.uniform(2.0, 15.0)))
            if solution is not None:
                source, pose = "refined", solution.pose
        elif k == POSES - 3:  # and from corners that a network found
            found = _of_corners(rng, model, camera, true)
            if found is not None:
                source, pose = "corners", found
        elif k == 0 and len(turns):
            turned = true.compose(turns[int(rng.integers(len(turns)))])
            source, pose = "turned", _off(rng, model, turned, 0.05)
        poses.append((source, pose))
    return [(source, pose) for source, pose in poses if pose.apply(model.pivot[None])[0, 2] > 0.0]


def _of_corners(rng: np.random.Generator, model: Model, camera: Camera, true: Pose) -> Pose | None:
    """A pose from corners that are off by some px, now and then with two of them interchanged."""
    chosen = rng.permutation(len(model.vertices))[:CORNERS]
    points = model.vertices[chosen]
    pixels = camera.project(true.apply(points)) + rng.uniform(0.0, MOST_OFF_PX) * rng.normal(
        size=(len(points), 2)
    )
    if rng.random() < INTERCHANGED:
        pixels[:2] = pixels[1::-1].copy()
    rays = (pixels - [camera.cx, camera.cy]) / [camera.fx, camera.fy]
    found, turn, shift = cv2.solvePnP(points, rays, np.eye(3), None, flags=cv2.SOLVEPNP_SQPNP)
    return Pose(np.asarray(turn[:, 0], np.float64), np.asarray(shift[:, 0], np.float64)) if found else None


def _off(rng: np.random.Generator, model: Model, pose: Pose, degrees: float) -> Pose:
    """A pose that is off by so many degrees at most, and shifted as far as that moves its corners."""
    axis = rng.normal(size=3)
    turn = matrix_of(np.radians(degrees) * rng.uniform(0.2, 1.0) * axis / np.linalg.norm(axis))
    centre = pose.apply(model.middle[None])[0]
    shift = np.radians(degrees) * 0.5 * model.diameter * rng.normal(size=3) * [1.0, 1.0, 2.0]
    return Pose.from_matrix(turn @ pose.matrix, centre + shift + turn @ (pose.translation - centre))


def judged_poses(
    number: int, name: str, images: ImageSet, model: Model, camera: Camera, true: Pose
) -> list[Row]:
    """Judge poses of one scene."""
    rows, names = [], list(images.images)
    endpoints = extract_segments(images.edge_map(names)).endpoints
    for source, pose in given_poses(number, images, model, camera, true):
        error = pose.error_to(true)
        found = judged(images, names, model, camera, pose, endpoints=endpoints)
        right = error.within(*LIMITS)
        rows.append(Row(name, model.name, source, right, found.chances, error.rotation_deg))
    return rows


def simulated_rows(number: int) -> list[Row]:
    """Judge the poses of one scene by number."""
    try:
        return judged_poses(number, str(number), *scene(number))
    except BadInput:
        return []  # the scenario has no light or sun there


def stack_rows(first: int, folder: Path) -> list[Row]:
    """Judge poses of a light stack in three image sets."""
    studio, rows = stack_studio(folder), []
    rng = np.random.default_rng([first, crc32(folder.name.encode())])
    for kind, count in SETS:
        images = image_set(drawn_set(studio, kind, count, rng))
        number = int(rng.integers(2**31))
        rows += judged_poses(number, folder.name, images, studio.model, studio.camera, studio.true)
    return rows


def every_row(scenes: int, first: int, stacks: list[Path], workers: int, kept: Path | None) -> list[Row]:
    """All rows; those in the file ``kept`` are taken from there, the others are added to it."""
    known: dict[str, list[Row]] = {}
    if kept is not None and kept.exists():
        for row in map(partial(msgspec.json.decode, type=Row), kept.read_bytes().splitlines()):
            known.setdefault(row.scene, []).append(row)
    names = [folder.name for folder in stacks] or [str(first + k) for k in range(scenes)]
    rows = [row for name in names for row in known.get(name, [])]
    with ProcessPoolExecutor(workers) as pool:
        if stacks:
            left = [folder for folder in stacks if folder.name not in known]
            found = pool.map(partial(stack_rows, first), left)
        else:
            found = pool.map(simulated_rows, [int(name) for name in names if name not in known])
        for some in found:
            rows += some
            if kept is not None:
                with kept.open("ab") as file:
                    file.writelines(msgspec.json.encode(row) + b"\n" for row in some)
    return rows


def expected_error(probability: Floats, right: NDArray[np.bool_]) -> float:
    """Mean distance between probability and share, in bins of equal count."""
    order = np.array_split(np.argsort(probability, kind="stable"), BINS)
    gaps = [abs(float(probability[part].mean() - right[part].mean())) for part in order]
    return float(np.average(gaps, weights=[len(part) for part in order]))


def fitted(rows: list[Row]) -> Calibration:
    """By maximum likelihood, held near what it is."""
    start = np.array(CALIBRATION)
    right = np.array([row.right for row in rows])

    def loss(beta: Floats) -> float:
        stated = np.array([probability(row.chances, Calibration(*beta)) for row in rows])
        likely = np.log(np.maximum(np.where(right, stated, 1.0 - stated), LEAST_LIKELY))
        return float(RIDGE * len(rows) * np.sum((beta - start) ** 2) - likely.sum())

    return Calibration(*minimize(loss, start, method="Nelder-Mead", options={"maxfev": 1500}).x)


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


def cross_validated(rows: list[Row]) -> tuple[Calibration, Floats]:
    """The calibration, and the probability of each row by a fit to the other shapes."""
    stated = np.zeros(len(rows))
    for shape in {row.shape for row in rows}:
        beta = fitted([row for row in rows if row.shape != shape])
        for k, row in enumerate(rows):
            if row.shape == shape:
                stated[k] = probability(row.chances, beta)
    return fitted(rows), stated


def said(name: str, stated: Floats, right: NDArray[np.bool_]) -> dict[str, object]:
    """What is printed of probabilities."""
    states = np.where(stated >= referee.OK, "ok", np.where(stated < referee.LOST, "lost", "doubtful"))
    return {
        "name": name, "value": expected_error(stated, right), "unit": "expected error",
        "poses": len(right), "right": float(right.mean()), "brier": float(np.mean((stated - right) ** 2)),
        **{state: int((states == state).sum()) for state in ("ok", "doubtful", "lost")},
        "ok_and_wrong": int(((states == "ok") & ~right).sum()),
        "lost_and_right": int(((states == "lost") & right).sum()),
    }  # fmt: skip


def family(shape: str) -> str:
    """Of a shape: a box, a random part, or a target."""
    return shape if shape in ("box", "part") else "target"


def main(
    scenes: int = 250,
    first: int = 0,
    workers: int = 2,
    stacks: Annotated[list[Path] | None, typer.Option(help="Light stacks instead; may be repeated.")] = None,
    rows: Annotated[Path | None, typer.Option(help="Keep what was judged here.")] = None,
    fit: Annotated[bool, typer.Option(help="Fit the calibration, too.")] = False,
    plot: Path | None = None,
) -> None:
    """Judge, and print."""
    found = every_row(scenes, first, stacks or [], workers, rows)
    right = np.array([row.right for row in found])
    stated = np.array([probability(row.chances) for row in found])
    print(json.dumps(said("referee", stated, right)))
    kinds = {"shape": [family(row.shape) for row in found], "source": [row.source for row in found]}
    for name, values in kinds.items():
        for value in dict.fromkeys(values):
            chosen = np.array(values) == value
            print(json.dumps(said(f"referee, {name} {value}", stated[chosen], right[chosen])))
    if fit:
        beta, stated = cross_validated(found)
        print(json.dumps(said("referee, cross-validated", stated, right) | {"fit": beta._asdict()}))
    if plot is not None:
        plotted(stated, right, plot)


if __name__ == "__main__":
    typer.run(main)
