"""What the constants of `vision_server.pose.trust` come from: estimates of drawn scenes, right and wrong.

    .venv/bin/python -m benchmarks.ray_traced_stacks SCENES MODEL... --hard
    .venv/bin/python -m benchmarks.trust_fit collect SCENES/* --out ROWS.jsonl
    .venv/bin/python -m benchmarks.trust_fit fit ROWS.jsonl [--plot FILE.png]

`collect` draws image sets of each stack, of any settings or of those that expose the scene, and estimates
the pose with its model, with the model stretched along one axis, and with another one; a stack that is in the
file already is left out. `fit` prints the constants, how many poses they would trust, each fold of scenes
judged by a fit to the others, and how often poses of each probability are right.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any
from zlib import crc32

import numpy as np
import typer
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.special import erf, expit

from benchmarks.hard_scenes import KINDS
from benchmarks.photographs import Photograph, Studio, image_set, stack_studio
from geometry.model import Model, find_target, load_model
from geometry.pose import disturbed
from vision_server.matching import SearchRange
from vision_server.pipeline import Estimate, PipelineSettings, estimate_pose
from vision_server.pose.stretch import stretched
from vision_server.pose.trust import (
    CLEAR_GAIN,
    LEAST_UNCERTAINTY,
    LIMIT,
    MOST_CONFIRMED,
    SOME,
    TAILS,
    USUAL,
)  # fmt: skip

Floats = NDArray[np.float64]
Row = dict[str, Any]

SETS = (("any", 3), ("exposed", 2), ("exposed", 6))
EXPOSED_GREY = (60, 250)  # the brightest twentieth of the image lies between
TRIES = 12
STRETCHES = (0.02, 0.03, 0.05, 0.08, 0.1, 0.12, 0.15, 0.2)
OTHERS = ("cube", "fixture", "satellite")
SIZE = (0.8, 1.2)  # of another model, over the target's
WRONG_MODELS = 0.3  # what an estimate with a wrong model counts in the fit, beside 1
RIDGE = 0.3  # on the squared coefficients
FOLDS = 5
NAMES = ("confirmed", "missing", "uncertainty", "root gain", "gain", "significance")

app = typer.Typer(help=__doc__, add_completion=False)


def drawn_set(studio: Studio, kind: str, count: int, rng: np.random.Generator) -> list[Photograph]:
    """Images under settings drawn at random; `exposed` ones are drawn again when too dark or too bright."""
    described, shots = studio.device.describe(), []
    for _ in range(count):
        for _ in range(TRIES if kind == "exposed" else 1):
            shot = studio.photograph(
                tuple(int(rng.integers(0, light.levels)) for light in described.lights),
                float(rng.choice(described.shutters_s)),
                float(rng.choice(described.apertures)),
            )
            if EXPOSED_GREY[0] <= np.percentile(shot.pixels, 95) <= EXPOSED_GREY[1]:
                break
        shots.append(shot)
    return shots


def models(model: Model, rng: np.random.Generator) -> Iterator[tuple[str, Model]]:
    """The true model, a stretched one and another one."""
    yield "true", model
    by = float(rng.choice(STRETCHES) * rng.choice([-1.0, 1.0]))
    axis = int(rng.integers(3))
    yield f"{'xyz'[axis]}{by:+.2f}", stretched(model, math.log(1.0 + by) * np.eye(3)[axis])
    other = load_model(find_target(str(rng.choice([name for name in OTHERS if name != model.name]))))
    size = math.log(model.diameter / other.diameter * rng.uniform(*SIZE))
    yield "other", stretched(other, np.full(3, size))


def row_of(studio: Studio, found: Estimate) -> Row:
    """What the fit needs of one estimate."""
    if found.pose is None or found.support is None:
        return {"pose": False}
    error = found.pose.error_to(studio.true)
    doubt = found.misfit
    return {
        "pose": True, "rotation_deg": error.rotation_deg, "translation": error.translation_fraction_of_range,
        "within": error.within(1.0, 0.01), "confirmed": found.support.confirmed,
        "missing": found.support.missing, "uncertainty": found.uncertainty, "ambiguity": found.ambiguity,
        "gain": doubt.gain if doubt else 0.0, "significance": doubt.significance if doubt else 0.0,
        "score": found.score,
    }  # fmt: skip


@app.command()
def collect(stacks: list[Path], out: Annotated[Path, typer.Option()], seed: int = 1) -> None:
    """Estimate poses of stacks, and append what the fit needs to a file."""
    known: set[str] = (
        {json.loads(line)["scene"] for line in out.read_text().splitlines()} if out.exists() else set()
    )
    reach = SearchRange()
    for folder in stacks:
        if str(folder) in known:
            continue
        studio, number = stack_studio(folder), int(folder.name.rpartition("-")[2])
        empty = KINDS[(number - 1) % len(KINDS)] == "N"
        rng = np.random.default_rng([seed, crc32(folder.name.encode())])
        rows = []
        for kind, count in SETS:
            shots = drawn_set(studio, kind, count, rng)
            images, start = image_set(shots), disturbed(
                studio.true, rng, reach.rotation_deg, reach.translation_px, studio.camera.fx
            )  # fmt: skip
            for name, model in models(studio.model, rng):
                settings = PipelineSettings(seed=seed, tone_sd_px=shots[0].tone_sd_px)
                found = estimate_pose(images, list(images.images), model, studio.camera, start, settings)
                rows.append(
                    {"scene": str(folder), "empty": empty, "set": f"{kind} {count}", "model": name}
                    | row_of(studio, found)
                )
        with out.open("a") as file:
            file.writelines(json.dumps(row) + "\n" for row in rows)
        print(folder, len(rows), flush=True)


def inputs(rows: Sequence[Row]) -> Floats:
    """A 1 and NAMES of each row, as `confidence` takes them, (N, 7)."""
    table = {key: np.array([float(row[key]) for row in rows]) for key in (
        "confirmed", "missing", "uncertainty", "gain", "significance")}  # fmt: skip
    return np.stack([
        np.ones(len(rows)),
        np.log2(1.0 + np.minimum(table["confirmed"], MOST_CONFIRMED)),
        np.log2(1.0 + table["missing"] / SOME),
        np.log(np.maximum(table["uncertainty"], LEAST_UNCERTAINTY) / LIMIT),
        np.sqrt(table["gain"]),
        np.maximum(0.0, table["gain"] - CLEAR_GAIN),
        np.log2(1.0 + table["significance"] / USUAL),
    ], axis=1)  # fmt: skip


def fitted(rows: Sequence[Row]) -> tuple[Callable[[Sequence[Row]], Floats], Floats]:
    """The probability that rows are right, by a fit to some, and its coefficients (7,)."""

    def chance(coefficients: Floats, of: Sequence[Row], x: Floats) -> Floats:
        spread = np.array([row["uncertainty"] for row in of])
        unclear = np.array([row["ambiguity"] for row in of])
        within = erf(LIMIT / (math.sqrt(2.0) * TAILS * np.maximum(spread, 1e-9)))
        return np.asarray(np.clip(within * expit(x @ coefficients) / (1.0 + unclear), 1e-9, 1.0 - 1e-9))

    x, right = inputs(rows), np.array([row["right"] for row in rows])
    weight = np.array([1.0 if row["model"] == "true" else WRONG_MODELS for row in rows])

    def loss(coefficients: Floats) -> float:
        p = chance(coefficients, rows, x)
        likely = weight @ np.where(right, np.log(p), np.log(1.0 - p))
        return float(RIDGE * coefficients[1:] @ coefficients[1:] - likely)

    found = minimize(loss, np.zeros(x.shape[1]), method="BFGS").x
    return (lambda of: chance(found, of, inputs(of))), found


@app.command()
def fit(files: list[Path], plot: Annotated[Path | None, typer.Option()] = None) -> None:
    """Fit the constants, and say how well the probability is calibrated."""
    every = [json.loads(line) for file in files for line in file.read_text().splitlines()]
    rows = [row for row in every if row["pose"]]
    for row in rows:
        row["right"] = bool(row["model"] == "true" and row["within"] and not row["empty"])
    # a pose that is right in spite of its model is neither to be believed nor to be doubted
    rows = [row for row in rows if row["right"] or row["model"] == "true" or not row["within"]]
    constants = dict(zip(("bias", *NAMES), np.round(fitted(rows)[1], 2).tolist(), strict=True))
    fold = np.array([crc32(row["scene"].encode()) % FOLDS for row in rows])
    p = np.zeros(len(rows))
    for number in range(FOLDS):
        others = [row for row, own in zip(rows, fold, strict=True) if own != number]
        held_out = np.flatnonzero(fold == number)
        if len(held_out):
            p[held_out] = fitted(others)[0]([rows[k] for k in held_out])
    right = np.array([row["right"] for row in rows])
    true = np.array([row["model"] == "true" for row in rows])
    print(json.dumps({"name": "trust constants", "estimates": len(rows), **constants}))
    for least in (0.8, 0.9, 0.93, 0.95, 0.98):
        over = p >= least
        print(json.dumps({
            "name": f"trusted from {least}", "right": int((over & right).sum()), "of": int(right.sum()),
            "wrong, true model": int((over & ~right & true).sum()), "of wrong": int((~right & true).sum()),
            "wrong model": int((over & ~true).sum()), "of wrong models": int((~true).sum()),
        }))  # fmt: skip
    bins = np.minimum((p[true] * 10).astype(int), 9)
    share = [(float(p[true][bins == k].mean()), float(right[true][bins == k].mean()), int((bins == k).sum()))
             for k in np.unique(bins)]  # fmt: skip
    error = sum(n * abs(said - seen) for said, seen, n in share) / true.sum()
    print(json.dumps({"name": "expected calibration error, true models", "value": round(error, 3),
                      "bins": [[round(a, 2), round(b, 2), n] for a, b, n in share]}))  # fmt: skip
    if plot is not None:
        _drawn(share, plot)


def _drawn(share: list[tuple[float, float, int]], file: Path) -> None:
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(figsize=(4.5, 4.0), layout="constrained")
    said, seen, count = (np.array(column) for column in zip(*share, strict=True))
    axes.plot([0, 1], [0, 1], color="0.7", linewidth=1)
    spread = 1.96 * np.sqrt(np.maximum(seen * (1 - seen), 0.25 / count) / count)
    axes.errorbar(said, seen, yerr=spread, fmt="o", capsize=2)
    axes.set(xlabel="probability that is stated", ylabel="share that is right", xlim=(0, 1), ylim=(0, 1.02))
    figure.savefig(file, dpi=120)


if __name__ == "__main__":
    app()
