"""Is a model believed that lies upside down or is mirrored?

    .venv/bin/python -m benchmarks.other_ways [SHAPE...] [--seed 1] [--rows]

Of each shape (the project's satellite and fixture, drawn parts, docking gear) the simulator draws a view in
each of SCENARIOS. Two images under settings drawn at random are estimated with its model, and with this one
turned by half and mirrored about each axis of its file. One JSON object for true models and for others: how
many estimates, how many of these have a pose that is right (1 degree, 1 % of the range) and how many are
trusted, with a right pose or a wrong one. Other models are left out where their visible lines lie within
ALIKE_PX of those of the true one: no image tells. With `--rows`, an object an estimate, too.
"""

from __future__ import annotations

import json
import tempfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from benchmarks.docking_gear import GEAR
from benchmarks.drawn_parts import PARTS, part_file
from benchmarks.photographs import Studio, image_set
from benchmarks.trust_rows import apart_px, drawn_set, studio_of
from geometry.deformed import deformed
from geometry.pose import RIGHT, disturbed
from image_server.simulator.scenario import load_scenario
from numerics.two_cores import use_one_core
from vision_server.matching import SearchRange
from vision_server.pipeline import SURE_SCORE, PipelineSettings, estimate_pose
from vision_server.trust.other_hand import WAYS

SHAPES = ("satellite", "fixture", *PARTS, *GEAR)
SCENARIOS = ("nominal", "textured", "grazing")
IMAGES = 2
ALIKE_PX = 0.5
COUNTED = ("estimates", "right", "trusted and right", "trusted and wrong")


def scene(shape: str, scenario: str, rng: np.random.Generator) -> Studio:
    """A view of a shape, drawn anew."""
    with tempfile.TemporaryDirectory() as scratch:
        file = part_file(shape, Path(scratch), rng)
        return studio_of(f"{scenario} {shape}", file, load_scenario(scenario), int(rng.integers(1 << 30)))


def rows(shape: str, seed: int) -> Iterator[dict[str, Any]]:
    """An estimate of each scene of a shape with each model, the true one first."""
    for number, scenario in enumerate(SCENARIOS):
        rng = np.random.default_rng([seed, number, sum(map(ord, shape))])
        studio, reach = scene(shape, scenario, rng), SearchRange()
        shots = drawn_set(studio, "exposed", IMAGES, rng)
        images, middle = image_set(shots), studio.model.middle
        start = disturbed(
            studio.true, rng, reach.rotation_deg, reach.translation_px, studio.camera.fx, middle
        )
        settings = PipelineSettings(seed=seed, tone_sd_px=shots[0].tone_sd_px)
        for way in (np.eye(3), *WAYS):
            model = deformed(studio.model, way)
            found = estimate_pose(images, list(images.images), model, studio.camera, start, settings)
            apart = apart_px(studio, model, found)
            true = np.array_equal(way, np.eye(3))
            if not true and apart is not None and apart <= ALIKE_PX:
                continue
            yield {
                "scene": studio.name, "way": np.diag(way).astype(int).tolist(), "true": true,
                "right": found.pose is not None and found.pose.error_to(studio.true).within(*RIGHT),
                "score": found.score, "apart_px": apart,
            }  # fmt: skip


def counted(told: dict[str, Any]) -> Counter[str]:
    """What an estimate adds to the row of its kind."""
    right, trusted = bool(told["right"]), told["score"] >= SURE_SCORE
    return Counter({
        "estimates": 1, "right": int(right), "trusted and right": int(trusted and right),
        "trusted and wrong": int(trusted and not right),
    })  # fmt: skip


def main(
    shapes: Annotated[list[str] | None, typer.Argument(metavar="SHAPE...")] = None,
    seed: int = 1,
    show_rows: Annotated[bool, typer.Option("--rows", help="Print each estimate, too.")] = False,
) -> None:
    """Estimate poses with models as they are and the other way round."""
    use_one_core()
    counts = {True: Counter[str](), False: Counter[str]()}
    for shape in shapes or SHAPES:
        for told in rows(shape, seed):
            counts[told["true"]] += counted(told)
            if show_rows:
                print(json.dumps(told), flush=True)
    for true, count in counts.items():
        name = "true models" if true else "models the other way round"
        print(json.dumps({"name": name, **{what: count[what] for what in COUNTED}}))


if __name__ == "__main__":
    typer.run(main)
