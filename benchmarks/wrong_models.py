"""Whether the evidence that a model does not fit tells wrong models from true ones.

    .venv/bin/python -m benchmarks.wrong_models [SCENE...] [--seeds 2] [--rows]

A scene is as `benchmarks.surprises` has it. Of each, two and five images under settings drawn at random are
estimated with its model, and with one that is 2 % too long along each axis in turn. One JSON object for true
and for wrong models: sets of images with a pose that is worth the look, in how many of them the model is said
to be wrong (`named`), along the right axis (`axis_right`), and how many poses are wrong (1 degree, 1 % of the
range). With `--rows`, an object a set, too.
"""

from __future__ import annotations

import json
import tempfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import msgspec
import numpy as np
import typer

from benchmarks.planted_faults import Planted, with_stretched_model
from benchmarks.surprises import SCENES, candidates
from bridge.start_messages import StartArgs
from geometry.pose import RIGHT
from numerics.two_cores import use_one_core
from vision_server.serve.opening import open_task

SIZES = (2, 5)  # images: the least that is believed, and about as many as a session takes in hard light


def sets(scene: str, seed: int, axis: int | None) -> Iterator[dict[str, Any]]:
    """What is found in nested sets of images with a model that is true, or too long along an axis."""
    with tempfile.TemporaryDirectory() as folder:
        device = Planted(scene, seed, "nothing", SIZES[-1] + 1, Path(folder))
        describe = device.describe()
        told = describe if axis is None else with_stretched_model(describe, axis, Path(folder))
        task = open_task(msgspec.convert({"seed": seed}, StartArgs), told)
    offered = candidates(describe)
    drawn = np.random.default_rng([seed, 9]).permutation(len(offered))[: SIZES[-1]]
    names: tuple[str, ...] = ()
    for number, row in enumerate(drawn, start=1):
        frame = device.capture(offered[row])
        names += (f"i{number}",)
        task.add(names[-1], np.asarray(frame.pixels), frame.applied)
        if number in SIZES:
            found = task.estimate(names)
            if found.pose is None or found.misfit is None:
                continue
            said = found.misfit.excess
            yield {
                "scene": Path(scene).name,
                "images": number,
                "axis": axis,
                "named": said is not None,
                "axis_right": said is not None and said.axis == axis and said.share > 0.0,
                "wrong_poses": not found.pose.error_to(device.true).within(*RIGHT),
                "share": None if said is None else round(said.share, 4),
                "significance": round(found.misfit.significance, 2),
                "gain": round(found.misfit.gain, 2),
            }


def main(
    scenes: Annotated[list[str] | None, typer.Argument(metavar="SCENE...")] = None,
    seeds: Annotated[int, typer.Option(min=1)] = 2,
    rows: Annotated[bool, typer.Option(help="Print each set, too.")] = False,
) -> None:
    """Count what is said of true and of wrong models."""
    use_one_core()
    counts = {kind: Counter[str]() for kind in ("true", "wrong")}
    for scene in scenes or SCENES:
        for seed in range(1, seeds + 1):
            for axis in (None, 0, 1, 2):
                count = counts["true" if axis is None else "wrong"]
                for row in sets(scene, seed, axis):
                    count["sets"] += 1
                    for what in ("named", "axis_right", "wrong_poses"):
                        count[what] += int(row[what])
                    if rows:
                        print(json.dumps(row), flush=True)
    for kind, count in counts.items():
        told = {what: count[what] for what in ("sets", "named", "axis_right", "wrong_poses")}
        print(json.dumps({"name": f"{kind}-models", **told}))


if __name__ == "__main__":
    typer.run(main)
