"""Whether the images that are foreseen to add most are those that do, of all that was on offer.

    .venv/bin/python -m benchmarks.choices STACK... [--seed 1] [--choices 14]

After a first image, all lights full under the shortest shutter and the smallest aperture, the same settings
are on offer in each scene, drawn at random. `predict` says what each would add; then each is taken and
estimated with the first. One JSON object a scene and one of all: rank correlation of what was foreseen with
the log odds of the score (base 2), and with the accuracy; log odds gained, and the natural logarithm of the
error (1 is what is right), by the one that was foreseen to add most and in the mean of all; the most log odds
that any of them gained.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from scipy.stats import spearmanr

from benchmarks.oracles import Trial
from benchmarks.surprises import candidates
from bridge.messages import Settings
from bridge.vision_messages import PredictArgs
from stack.exposure import full_levels
from vision_server.serve.prediction import predict

LEAST, MOST = 0.001, 50.0  # doubt, and error: what is less or more says no more
DRAWN_BY = 7  # seed of what is on offer


def log_odds(score: float) -> float:
    """Of a probability, base 2."""
    inside = min(max(score, LEAST), 1.0 - LEAST)
    return math.log2(inside / (1.0 - inside))


def log_error(error: float) -> float:
    """Natural logarithm of an error in units of what is right."""
    return math.log(min(max(error, LEAST), MOST))


def compared(scene: str, seed: int, choices: int) -> dict[str, float] | None:
    """What was foreseen after the first image against what came of it; None without a pose."""
    trial = Trial(scene, seed)
    device = trial.device.describe()
    asked = candidates(device)
    drawn = np.random.default_rng(DRAWN_BY).choice(len(asked), choices, replace=False)
    offered = [asked[row] for row in drawn]
    first = trial.take(
        Settings(
            lights=full_levels(device.lights),
            shutter_s=min(device.shutters_s),
            aperture=max(device.apertures),
        )
    )
    before = log_odds(trial.task.estimate((first,)).score)
    gains = predict(trial.task, PredictArgs(settings=tuple(offered))).gains
    if gains is None:
        return None
    foreseen = np.array([gain.bits for gain in gains])
    odds, errors = [], []
    for settings in offered:
        name = trial.take(settings)
        odds.append(log_odds(trial.task.estimate((first, name)).score) - before)
        errors.append(log_error(trial.error((first, name))))
        trial.task.discard(name)
    best = int(np.argmax(foreseen))
    return {
        "rank_score": float(spearmanr(foreseen, odds)[0]),
        "rank_accuracy": float(-spearmanr(foreseen, errors)[0]),
        "odds_chosen": odds[best],
        "odds_all": float(np.mean(odds)),
        "odds_best": max(odds),
        "error_chosen": errors[best],
        "error_all": float(np.mean(errors)),
    }


def main(
    scenes: Annotated[list[str], typer.Argument(metavar="STACK...")],
    seed: Annotated[int, typer.Option(min=0)] = 1,
    choices: Annotated[int, typer.Option(min=3)] = 14,
) -> None:
    """Compare what is foreseen with what comes of it."""
    rows = []
    for scene in scenes:
        row = compared(scene, seed, choices)
        if row is not None:
            rows.append(row)
            told = {key: round(value, 2) for key, value in row.items()}
            print(json.dumps({"name": "choices", "scene": Path(scene).name, **told}), flush=True)
    if rows:
        mean = {key: round(float(np.nanmean([row[key] for row in rows])), 2) for key in rows[0]}
        print(json.dumps({"name": "choices-all", "scenes": len(rows), **mean}))


if __name__ == "__main__":
    typer.run(main)
