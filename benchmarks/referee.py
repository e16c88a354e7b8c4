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

import msgspec
import numpy as np
import typer
from scipy.optimize import minimize

from benchmarks.given_poses import given_poses, scene
from benchmarks.photographs import image_set, stack_studio
from benchmarks.trust_rows import SETS, drawn_set
from bridge.errors import BadInput
from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import RIGHT, Pose
from numerics.arrays import Flags, Floats
from vision_server.image_set import ImageSet
from vision_server.segments.extraction import extract_segments
from vision_server.tracking import referee
from vision_server.tracking.chances import CALIBRATION, Calibration, Chances, probability
from vision_server.tracking.referee import judged

BINS = 10
RIDGE = 1e-5  # a hundred times as much keeps `elsewhere` at -7 where poses tell -2
LEAST_LIKELY = 1e-6


@dataclass(frozen=True)
class Row:
    """One judged pose, and where it is from: drawn, turned, corners or refined."""

    scene: str
    shape: str
    source: str
    right: bool
    chances: Chances
    rotation_deg: float


def judged_poses(
    number: int, name: str, images: ImageSet, model: Model, camera: Camera, true: Pose
) -> list[Row]:
    """Judge poses of one scene."""
    rows, names = [], list(images.images)
    endpoints = extract_segments(images.edge_map(names)).endpoints
    for source, pose in given_poses(number, images, model, camera, true):
        error = pose.error_to(true)
        found = judged(images, names, model, camera, pose, endpoints=endpoints)
        right = error.within(*RIGHT)
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


def expected_error(probability: Floats, right: Flags) -> float:
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


def plotted(probability: Floats, right: Flags, out: Path) -> None:
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


def said(name: str, stated: Floats, right: Flags) -> dict[str, object]:
    """What is printed of probabilities."""
    doubted = np.where(stated < referee.LOST_BELOW, "lost", "doubtful")
    states = np.where(stated >= referee.OK_FROM, "ok", doubted)
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
