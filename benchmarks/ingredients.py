"""What each ingredient of `informed` is worth: each is left out in turn, in the same sessions.

    .venv/bin/python -m benchmarks.ingredients SCENE... [--seeds 2] [--first-seed 1] [--row NAME ...]
        [--kind KIND ...] [--workers 1]

A scene is as `benchmarks.surprises` has it. What is left out of the choice of images is left out in Golog
(`benchmarks/strategies/`), what the vision server does is switched off in it. Every row runs the same
sessions by `swipl main.pl`: of "nothing", in which nothing goes wrong, or with a fault after the first image
(`benchmarks.planted_faults`). One JSON object a row: sessions whose fault had happened; shares that are right
(1 degree, 1 % of the range), tight (a fifth of it), trusted, wrong and trusted; images; and what `informed`
is ahead of it, paired, with a 95 % interval over scenes and seeds (kinds of faults count as seeds).
"""

from __future__ import annotations

import json
import math
import tempfile
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from functools import partial
from itertools import product
from pathlib import Path
from typing import Annotated, Any
from unittest.mock import patch

import numpy as np
import typer

from benchmarks.faulty_sessions import is_right, session
from benchmarks.planted_faults import KINDS, Planted
from experiments.statistics import paired
from experiments.version import ROOT
from experiments.warm_servers import served_vision
from geometry.pose import RIGHT
from numerics.arrays import Floats
from numerics.two_cores import use_one_core
from vision_server.prediction.belief import Belief
from vision_server.serve import prediction, surprises

Patch = tuple[object, str, Any]

STRATEGIES = ROOT / "benchmarks" / "strategies"
WHOLE = "nothing left out"
TIGHT = 0.2  # of what is right
MEASURES = ("right", "tight", "trusted", "wrong_and_trusted", "images")


def no_bits(_: Belief, shown: Floats) -> Floats:
    """Lines that are shown for the first time speak for no pose."""
    return np.zeros(len(shown))


ROWS: dict[str, tuple[str, tuple[Patch, ...]]] = {
    WHOLE: ("informed", ()),
    "safe first image": (str(STRATEGIES / "random_first.pl"), ()),
    "prediction line by line": (str(STRATEGIES / "unpredicted.pl"), ()),
    "what new lines speak for the pose": ("informed", ((Belief, "gains", no_bits),)),
    "search from the best candidate": ("informed", ((prediction, "_searched", lambda *_: ()),)),
    "keeping what does no harm": (str(STRATEGIES / "choosy.pl"), ()),
    "a second image": (str(STRATEGIES / "credulous.pl"), ()),
    "test images": (str(STRATEGIES / "untested.pl"), ()),
    "surprise": ("informed", ((surprises, "surprise_of", lambda *_: surprises.Surprise()),)),
}
"""What is left out: the strategy, and what is put in the place of parts of the vision server."""


def outcome(device: Planted, controller: str, vision_server: str, folder: Path, seed: int) -> list[float]:
    """MEASURES of one session; NaN where its fault has not happened."""
    ended = session(device, vision_server, folder, controller, seed)
    right = is_right(device, ended.pose)
    degrees, share = (TIGHT * limit for limit in RIGHT)
    tight = ended.pose is not None and ended.pose.error_to(device.true).within(degrees, share)
    return [right, tight, ended.trusted, ended.trusted and not right, ended.images]


def of_scene(rows: Sequence[str], kinds: Sequence[str], seeds: range, scene: str) -> Floats:
    """Outcomes of all rows in one scene, (rows, seeds x kinds, MEASURES)."""
    use_one_core()
    table = np.full((len(rows), len(seeds) * len(kinds), len(MEASURES)), np.nan)
    with tempfile.TemporaryDirectory() as scratch:
        vision = served_vision(f"ipc://{scratch}/vision", recorded=False)
        for number, row in enumerate(rows):
            controller, patches = ROWS[row]
            with ExitStack() as patched:
                for place, name, instead in patches:
                    patched.enter_context(patch.object(place, name, instead))
                for column, (kind, seed) in enumerate(product(kinds, seeds)):
                    with tempfile.TemporaryDirectory() as folder:
                        device = Planted(scene, seed, kind, 2, Path(folder))
                        told = outcome(device, controller, vision.endpoint, Path(folder), seed)
                        if kind == "nothing" or device.fault is not None:
                            table[number, column] = told
        vision.stop()
    return table


def summary(row: str, whole: Floats, without: Floats) -> dict[str, Any]:
    """A row, from outcomes (scenes, seeds x kinds, MEASURES) of `informed` and without an ingredient."""
    there = np.isfinite(without[..., 0])
    told: dict[str, Any] = {"name": "without", "ingredient": row, "sessions": int(there.sum())}
    for number, measure in enumerate(MEASURES):
        told[measure] = round(float(without[there][:, number].mean()), 4)
        if row != WHOLE:
            ahead = paired(whole[..., number], without[..., number])
            three = (ahead.value, ahead.low, ahead.high)
            told[f"{measure}_ahead"] = [round(x, 3) if math.isfinite(x) else None for x in three]
    return told


def main(
    scenes: Annotated[list[str], typer.Argument(metavar="SCENE...")],
    seeds: Annotated[int, typer.Option(min=1)] = 2,
    first_seed: Annotated[int, typer.Option(min=0)] = 1,
    row: Annotated[list[str] | None, typer.Option(metavar="NAME", help="Only these.")] = None,
    kind: Annotated[list[str] | None, typer.Option(metavar="KIND", help="Of fault; nothing.")] = None,
    workers: Annotated[int, typer.Option(min=1)] = 1,
) -> None:
    """Run sessions with and without each ingredient."""
    rows, kinds = [WHOLE, *(row or [name for name in ROWS if name != WHOLE])], kind or ["nothing"]
    for given, known in ((rows, ROWS), (kinds, ("nothing", *KINDS))):
        if unknown := [one for one in given if one not in known]:
            raise typer.BadParameter(f"{unknown[0]} is none of: {', '.join(known)}.")
    with ProcessPoolExecutor(workers) as pool:
        scene = partial(of_scene, rows, kinds, range(first_seed, first_seed + seeds))
        tables = np.array(list(pool.map(scene, scenes)))
    for number, name in enumerate(rows):
        print(json.dumps(summary(name, tables[:, 0], tables[:, number])), flush=True)


if __name__ == "__main__":
    typer.run(main)
