"""Predicted against seen: how well each line is placed, and how bright both its sides are.

    .venv/bin/python -m benchmarks.predictions [SCENE...] [--seeds 2] [--images 5] [--figure PNG]
    .venv/bin/python -m benchmarks.predictions --times

Scenes and the choice of images are those of `benchmarks.surprises`. Before each image but the first, the
prediction says with which standard deviation the edge of each line will be placed; in the image, the edge
points' distances from the line at the true pose say how it was. One JSON object a scene: lines, the quartiles
of predicted over measured standard deviation, and those of predicted over seen brightness.
With --times, the vision server's processor time for one question, with rings of more and more lights. With
--figure, of the first scene's last image: brightness foreseen and seen, and the candidates' ranking.
"""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Annotated, NamedTuple

import matplotlib
import msgspec
import numpy as np
import typer

from benchmarks.planted_faults import opened, true_pose
from benchmarks.surprises import SCENES, candidates
from bridge.messages import Settings
from bridge.start_messages import StartArgs
from bridge.vision_messages import PredictArgs
from geometry.pose import RIGHT, Pose
from image_server.simulator.scenario import load_scenario
from image_server.simulator.scenario_tables import Light
from image_server.simulator.simulator import Simulator
from numerics.arrays import Floats
from stack.exposure import in_words
from vision_server.pose.observation import PoseProblem, observe
from vision_server.prediction.information import Forecast
from vision_server.prediction.response import read_beside
from vision_server.prediction.straying import line_scatter
from vision_server.serve.opening import open_task
from vision_server.serve.prediction import forecast, lit_images, numbers, predict
from vision_server.serve.task import PoseTask

REACH_PX, SPACING_PX = 4.0, 2.0
LEAST_SCATTER_PX = 0.02  # less is not measured


class Seen(NamedTuple):
    """An image with what was foreseen of it."""

    task: PoseTask
    known: Forecast
    settings: Settings
    name: str


def placed(seen: Seen, true: Pose) -> Floats:
    """Predicted over measured standard deviation of each line that was found, (n,)."""
    task = seen.task
    foreseen = seen.known.line_sd(numbers(task, [seen.settings]))[0]
    problem = PoseProblem.at_scale(task.images.gradients([seen.name]), task.model, task.camera)
    edges = observe(problem, true, REACH_PX, SPACING_PX)
    scatter = np.sqrt(line_scatter(edges)[0])
    usable = np.isfinite(scatter) & np.isfinite(foreseen)
    return np.asarray(foreseen[usable] / np.maximum(scatter[usable], LEAST_SCATTER_PX))


def lit(seen: Seen) -> tuple[Floats, Floats]:
    """Brightness foreseen and seen beside each sample, both sides, shares of full scale, (2, N) each."""
    asked = numbers(seen.task, [seen.settings])
    mean, _ = seen.known.response.brightness(asked.exposure, asked.lights)
    _, (image,) = lit_images(seen.task, [seen.name])
    values, sd, clipped = read_beside(seen.known.samples, [image])
    usable = np.isfinite(sd[0]) & ~clipped[0]
    return np.clip(mean[0], 0.0, 1.0), np.where(usable, values[0] * image.exposure, np.nan)


def play(scene: str, seed: int, images: int) -> list[tuple[Seen, Floats]]:
    """A session; each image that something was foreseen of, with `placed`."""
    device, _ = opened(scene, seed)
    task = open_task(msgspec.convert({"seed": seed}, StartArgs), device.describe())
    true, rng, out = true_pose(scene, device), np.random.default_rng(seed), []
    asked = candidates(task.describe)
    for number in range(1, images + 1):
        settings, known = asked[rng.integers(len(asked))], None
        found = task.estimate(tuple(task.applied)) if task.applied else None
        if found is not None and found.pose is not None:
            known = forecast(task, tuple(task.applied), found.pose)
            settings = asked[int(np.argmax(known.gains(numbers(task, asked))[0]))]
        frame = device.capture(settings)
        task.add(f"i{number}", frame.pixels, frame.applied)
        if known is not None and known.view.pose.error_to(true).within(*RIGHT):
            seen = Seen(task, known, settings, f"i{number}")
            out.append((seen, placed(seen, true)))
    return out


def figure(seen: Seen, file: Path) -> None:
    """Brightness foreseen and seen beside the lines, and what the candidates were said to add."""
    matplotlib.use("Agg")
    from matplotlib import pyplot

    asked = candidates(seen.task.describe)
    bits = seen.known.gains(numbers(seen.task, asked))[0]
    best = np.argsort(-bits)[:12][::-1]
    panels, axes = pyplot.subplots(1, 3, figsize=(15, 4.2), layout="constrained")
    places = seen.known.samples.image + np.array([[[-4.0]], [[4.0]]]) * seen.known.samples.normal
    scale = {"cmap": "gray", "vmin": 0.0, "vmax": max(0.1, float(np.nanmax(lit(seen)[1]))), "s": 14}
    for axis, values, title in zip(axes, lit(seen), ("foreseen", "seen"), strict=False):
        axis.scatter(*places.reshape(-1, 2).T, c=values.ravel(), **scale)
        axis.set(title=f"brightness beside the lines, {title}", xticks=[], yticks=[], facecolor="#3050a0")
        axis.invert_yaxis()
        axis.set_aspect("equal")
    axes[2].barh([in_words(asked[index]) for index in best], bits[best], color="#3070b0")
    axes[2].set(title=f"the best of {len(asked)} candidates", xlabel="bits that the image would add")
    panels.savefig(file, dpi=90)


def times() -> None:
    """One question about all candidates and a search, after four random images."""
    for count in (3, 8, 24):
        angles = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
        ring = [(0.4 * float(np.cos(angle)), 0.4 * float(np.sin(angle)), 0.0) for angle in angles]
        lights = tuple(Light(f"l{n}", place, 8, 3.0 / count) for n, place in enumerate(ring))
        device = Simulator("cube", msgspec.structs.replace(load_scenario("nominal"), lights=lights), 1)
        task = open_task(StartArgs(), device.describe())
        asked, rng = candidates(task.describe), np.random.default_rng(1)
        for number in range(1, 5):
            frame = device.capture(asked[rng.integers(len(asked))])
            task.add(f"i{number}", frame.pixels, frame.applied)
        task.estimate(tuple(task.applied))
        question = PredictArgs(settings=asked, search=32)
        predict(task, question)
        began = time.process_time()
        for _ in range(5):
            task.lit.clear()
            predict(task, question)
        milliseconds = 200.0 * (time.process_time() - began)
        row = {"name": "prediction-time", "lights": count, "candidates": len(asked)}
        print(json.dumps({**row, "value": round(milliseconds, 1), "unit": "ms"}))


def main(
    scenes: Annotated[list[str] | None, typer.Argument(metavar="SCENE...")] = None,
    seeds: Annotated[int, typer.Option(min=1)] = 2,
    images: Annotated[int, typer.Option(min=2)] = 5,
    figure_file: Annotated[Path | None, typer.Option("--figure")] = None,
    only_times: Annotated[bool, typer.Option("--times")] = False,
) -> None:
    """Compare what was predicted with what was seen."""
    if only_times:
        times()
        return
    for scene in scenes or SCENES:
        told = [one for seed in range(1, seeds + 1) for one in play(scene, seed, images)]
        if not told:
            continue
        if figure_file is not None:
            figure(told[-1][0], figure_file)
            figure_file = None
        ratio = np.concatenate([ratios for _, ratios in told])
        pairs = [lit(seen) for seen, _ in told]
        shown = np.concatenate([(mean / np.maximum(real, 0.01)).ravel() for mean, real in pairs])
        row = {"name": "prediction", "scene": Path(scene).name, "images": len(told), "lines": len(ratio)}
        for name, values in (("sd_ratio", ratio), ("brightness_ratio", shown[np.isfinite(shown)])):
            row[name] = [round(float(one), 2) for one in np.quantile(values, [0.25, 0.5, 0.75])]
        print(json.dumps(row), flush=True)


if __name__ == "__main__":
    typer.run(main)
