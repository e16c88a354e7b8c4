"""What the constants of `vision_server.trust.probability` come from: estimates of drawn scenes.

    .venv/bin/python -m benchmarks.ray_traced_stacks SCENES MODEL... --hard
    .venv/bin/python -m benchmarks.trust_fit collect SCENES/* --simulated 140 [--seed 1] --out ROWS.jsonl
    .venv/bin/python -m benchmarks.trust_fit fit ROWS.jsonl [--plot FILE.png] [--by-lines] [--today]

`collect` draws image sets of each stack and each scene of the simulator, of any settings or of those that
expose the scene, and estimates the pose with its model, with the model stretched along one axis, and with
one that is sheared, mirrored, upside down or another; a scene that is in the file already is left out.
`fit` prints the coefficients, how many poses they would trust, each fold of scenes judged by a fit to the
others, and how often poses of each stratum are right, beside the calibration error that exact probabilities
of as many estimates have by chance; left out are wrong models that look like the true one where they were
found; with `--today`, by the constants in use. Fitted are those of the last step; with `--by-lines` those
of poses that have not taken it, as tracking's have not.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from itertools import compress
from pathlib import Path
from types import SimpleNamespace
from typing import Annotated, Any
from zlib import crc32

import numpy as np
import typer
from scipy.optimize import minimize

from benchmarks import trust_rows
from benchmarks.photographs import Studio
from benchmarks.trust_rows import Row
from numerics.arrays import Flags, Floats
from vision_server.trust import probability
from vision_server.trust.probability import Coefficients, LineAgreement

WRONG_MODELS = 0.3  # what an estimate with a wrong model counts in the fit, beside 1
RIDGE = 0.3  # on the squared coefficients
FOLDS = 5
TRUSTED = 0.933  # a merit of 1 px, the default threshold
SAME_PX = 0.5  # a wrong model whose visible lines are nearer to those of the true one looks the same
LEAST_CHANCE = 1e-9  # of a pose's being right, or wrong
DRAWS = 200  # of what is right, by the probabilities themselves
CHI_SQUARED_99 = 16.81  # of six degrees of freedom
STRATA = ("mild", "dark", "blurred", "hidden", "few lines", "symmetric")
BY_LINES = Coefficients._fields[:5]
OF_LAST_STEP = ("settled_bias", "agreeing", "log_scatter", "log2_stretch")

app = typer.Typer(help=__doc__, add_completion=False)


@app.command()
def collect(
    out: Annotated[Path, typer.Option()],
    stacks: Annotated[list[Path] | None, typer.Argument()] = None,
    simulated: Annotated[int, typer.Option(min=0, help="Scenes of the simulator.")] = 0,
    seed: int = 1,
) -> None:
    """Estimate poses of stacks and of simulated scenes, and append what the fit needs to a file."""
    known = {json.loads(line)["scene"] for line in out.read_text().splitlines()} if out.exists() else set()

    def scenes() -> Iterator[tuple[str, Studio, bool]]:
        for folder in stacks or ():
            yield trust_rows.stack_scene(folder)
        for number in range(simulated):
            yield trust_rows.simulated(number, seed)

    for name, studio, empty in scenes():
        if name not in known:
            rows = trust_rows.rows_of(name, studio, empty, seed)
            with out.open("a") as file:
                file.write("".join(json.dumps(row) + "\n" for row in rows))
            print(name, len(rows), flush=True)


def inputs(rows: Sequence[Row], settled: bool = True) -> list[dict[str, Any]]:
    """What `confidence` takes, for each row; without ``settled`` as of poses without the last step."""
    return [
        {
            "support": SimpleNamespace(confirmed=row["confirmed"], missing=row["missing"]),
            "ambiguity": row["ambiguity"],
            "uncertainty": row["uncertainty"],
            "doubt": SimpleNamespace(
                gain=row["gain"],
                borne_out=row["borne_out"],
                significance=row["significance"],
                otherwise=row["otherwise"],
                suspected=row["surely_wrong"] or None,
            ),
            "agreement": _agreement(row) if settled else None,
        }
        for row in rows
    ]


def _agreement(row: Row) -> LineAgreement:
    return LineAgreement(row["agreeing"], row["scatter"], row["astray"], row["contested"])


def chance(by: Coefficients, evidence: Sequence[dict[str, Any]]) -> Floats:
    """Probability that poses are right (N,), by these coefficients, from their `inputs`."""
    told = [probability.confidence(**one, by=by) for one in evidence]
    return np.clip(told, LEAST_CHANCE, 1.0 - LEAST_CHANCE)


def fitted(rows: Sequence[Row], settled: bool = True) -> Coefficients:
    """A fit to some rows of the coefficients of the last step, or those by lines; the others are in use."""
    evidence, right = inputs(rows, settled), np.array([row["right"] for row in rows])
    weight = np.array([1.0 if row["model"] == "true" else WRONG_MODELS for row in rows])
    free = OF_LAST_STEP if settled else BY_LINES

    def with_own(own: Floats) -> Coefficients:
        return probability.FITTED._replace(**dict(zip(free, own.tolist(), strict=True)))

    def loss(own: Floats) -> float:
        p = chance(with_own(own), evidence)
        likely = weight @ np.where(right, np.log(p), np.log(1.0 - p))
        return float(RIDGE * own[1:] @ own[1:] - likely)

    return with_own(minimize(loss, np.zeros(len(free)), method="BFGS").x)


@app.command()
def fit(
    files: list[Path],
    plot: Annotated[Path | None, typer.Option()] = None,
    today: Annotated[bool, typer.Option(help="Judge the constants that are in use; fit nothing.")] = False,
    by_lines: Annotated[bool, typer.Option(help="As of poses without the last step.")] = False,
) -> None:
    """Fit the constants, and say how well the probability is calibrated."""
    every = [json.loads(line) for file in files for line in file.read_text().splitlines()]
    rows = [row for row in every if row["pose"]]
    for row in rows:
        row["right"] = bool(row["model"] == "true" and row["within"] and not row["empty"])
    # a pose that is right in spite of its model, or looks so, is neither to be believed nor to be doubted
    rows = [row for row in rows if row["right"] or row["model"] == "true" or not _looks_right(row)]
    if today:
        p = chance(probability.FITTED, inputs(rows, not by_lines))
    else:
        constants = {name: round(value, 2) for name, value in fitted(rows, not by_lines)._asdict().items()}
        print(json.dumps({"name": "trust coefficients", "estimates": len(rows), **constants}))
        p = _held_out(rows, not by_lines)
    right = np.array([row["right"] for row in rows])
    true = np.array([row["model"] == "true" for row in rows])
    for least in (0.8, 0.9, TRUSTED, 0.95, 0.98):
        over = p >= least
        print(json.dumps({
            "name": f"trusted from {least}", "right": int((over & right).sum()), "of": int(right.sum()),
            "wrong, true model": int((over & ~right & true).sum()), "of wrong": int((~right & true).sum()),
            "wrong model": int((over & ~true).sum()), "of wrong models": int((~true).sum()),
        }))  # fmt: skip
    weight = np.where(true, 1.0, WRONG_MODELS)
    of = {name: np.array([name in row["strata"] for row in rows]) for name in STRATA}
    strata = {name: true & part for name, part in of.items()}
    for name, part in {"all": weight > 0.0, "true models": true, **strata, "wrong models": ~true}.items():
        if part.any():
            own = [row["normalised"] for row in compress(rows, part & right)]
            show_stratum(name, p[part], right[part], weight[part], own)
    for name, part in of.items():
        if part.any():
            error = calibration_error(p[part], right[part], weight[part])
            print(json.dumps({
                "name": f"of all models, {name}", "calibration error": round(error, 3),
                "by chance": round(error_by_chance(p[part], weight[part]), 3),
            }))  # fmt: skip
    if plot is not None:
        _drawn(calibration(p, right, weight), plot)


def _looks_right(row: Row) -> bool:
    apart_px = row.get("apart_px")
    return bool(row["within"]) or (apart_px is not None and apart_px < SAME_PX)


def _held_out(rows: Sequence[Row], settled: bool) -> Floats:
    """Probability of each row by a fit to the other folds of scenes."""
    fold = np.array([crc32(row["scene"].encode()) % FOLDS for row in rows])
    p = np.zeros(len(rows))
    for number in range(FOLDS):
        others = [row for row, own in zip(rows, fold, strict=True) if own != number]
        held_out = np.flatnonzero(fold == number)
        if len(held_out):
            p[held_out] = chance(fitted(others, settled), inputs([rows[int(k)] for k in held_out], settled))
    return p


def calibration(p: Floats, right: Flags, weight: Floats) -> list[tuple[float, float, float]]:
    """Mean probability, share that is right, and weight, of each tenth of the probabilities."""
    tenth = np.minimum((p * 10).astype(int), 9)
    out = []
    for number in np.unique(tenth):
        own = weight * (tenth == number)
        out.append((float(own @ p / own.sum()), float(own @ right / own.sum()), float(own.sum())))
    return out


def calibration_error(p: Floats, right: Flags, weight: Floats) -> float:
    """Expected calibration error, from tenths of the probabilities (N,)."""
    bins = calibration(p, right, weight)
    return float(sum(n * abs(said - seen) for said, seen, n in bins) / weight.sum())


def error_by_chance(p: Floats, weight: Floats) -> float:
    """The calibration error, in the median, of probabilities (N,) that are exact."""
    rng = np.random.default_rng(0)
    return float(np.median([calibration_error(p, rng.random(len(p)) < p, weight) for _ in range(DRAWS)]))


def show_stratum(name: str, p: Floats, right: Flags, weight: Floats, normalised: Sequence[float]) -> None:
    """Print how well one stratum is calibrated, and the squared normalised errors of its right poses."""
    error = calibration_error(p, right, weight)
    told = {
        "name": f"stratum {name}", "estimates": len(p), "right": int(right.sum()),
        "mean probability": round(float(weight @ p / weight.sum()), 3),
        "share right": round(float(weight @ right / weight.sum()), 3), "calibration error": round(error, 3),
        "right and trusted": int((right & (p >= TRUSTED)).sum()),
        "wrong and trusted": int((~right & (p >= TRUSTED)).sum()),
    }  # fmt: skip
    if normalised:
        squares = np.array(normalised)
        told |= {
            "normalised error, mean": round(float(squares.mean()), 2),
            "median": round(float(np.median(squares)), 2),
            "within the 99 % bound": round(float((squares <= CHI_SQUARED_99).mean()), 3),
        }
    print(json.dumps(told))


def _drawn(share: list[tuple[float, float, float]], file: Path) -> None:
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
