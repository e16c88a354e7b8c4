"""What each part of the default matcher brings: from refinement alone over the paper's GA to the search.

    .venv/bin/python -m benchmarks.matching_ablation [FOLDER ...] [--starts 4] [--seeds 0-3] [--row NAME ...]

Every row is a way from the segments of one image to candidate poses; the same refinement follows each. A
FOLDER is one of `pose_accuracy` with exact poses, or a stack folder (one image, all lights at middle level);
without any, simulated images of three targets before a textured background serve. One JSON object per row:
share of the trials within 1 degree and 1 % of the range, and the median time of the matching.
"""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from benchmarks.photographs import Photograph, middle_of_stack, recorded, simulated
from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import RIGHT, Pose, disturbed
from numerics.arrays import Floats
from vision_server.baselines.genetic import GENERATIONS, POPULATION, evolved, match_genetic
from vision_server.image_set import ImageSet
from vision_server.matching import SearchRange, match_search
from vision_server.matching.draws import even_numbers, poses_around, reach_m
from vision_server.matching.icp import Lookup, score_poses
from vision_server.matching.match import Problem, distinct, matching_problem
from vision_server.matching.nearest_edges import NearestEdges, nearest_edges
from vision_server.matching.search import COARSE_SPACING_PX, MOST_HYPOTHESES, Effort, finished
from vision_server.pose.observation import PoseProblem
from vision_server.segments.extraction import extract_segments
from vision_server.trust.ranking import best_first

Matcher = Callable[[Floats, Model, Camera, Pose, int], list[Pose]]

RANGE = SearchRange()


def from_the_start(_segments: Floats, _model: Model, _camera: Camera, seed: Pose, _number: int) -> list[Pose]:
    """No matching at all."""
    return [seed]


def paper(segments: Floats, model: Model, camera: Camera, seed: Pose, number: int) -> list[Pose]:
    """The paper's genetic algorithm and numbers."""
    found = match_genetic(segments, model, camera, seed, number, RANGE)
    return [one.pose for one in found]


def genetic_on_edges(
    segments: Floats,
    model: Model,
    camera: Camera,
    seed: Pose,
    number: int,
    aligned: bool = False,
    restarts: int = 1,
) -> list[Pose]:
    """The same evolution, with the score of the search as its fitness; then aligned with the edges or not."""
    nearer_m = reach_m(seed, camera, RANGE)
    problem = matching_problem(segments, model, camera, seed, nearer_m, COARSE_SPACING_PX)
    if len(problem.segments) == 0:
        return []
    edges = nearest_edges(problem.segments, problem.camera)
    costs = partial(_edge_costs, edges, problem)
    runs = [
        evolved(costs, seed, problem.camera, RANGE, number + restart, POPULATION, GENERATIONS)
        for restart in range(restarts)
    ]
    rotations, translations, cost = (np.concatenate(part) for part in zip(*runs, strict=True))
    if aligned:
        found = finished(edges, model, problem.camera, (rotations, translations), -cost)
        return [one.pose for one in found]
    best = distinct(rotations, translations, -cost, MOST_HYPOTHESES)
    return [Pose.from_matrix(rotations[i], translations[i]) for i in best]


def _edge_costs(edges: NearestEdges, problem: Problem, rotations: Floats, translations: Floats) -> Floats:
    view = problem.views.of(rotations, translations)
    lookup = Lookup(edges, problem.views.table(), problem.camera.intrinsics)
    return -np.asarray(score_poses(lookup, view, rotations, translations, 0.0))


def even_draws(segments: Floats, model: Model, camera: Camera, seed: Pose, number: int) -> list[Pose]:
    """The search's draws and score, without anything after them."""
    nearer_m = reach_m(seed, camera, RANGE)
    problem = matching_problem(segments, model, camera, seed, nearer_m, COARSE_SPACING_PX)
    if len(problem.segments) == 0:
        return []
    edges = nearest_edges(problem.segments, problem.camera)
    poses = poses_around(seed, problem.camera, RANGE, even_numbers(Effort().draws, number))
    best = distinct(*poses, -_edge_costs(edges, problem, *poses), MOST_HYPOTHESES)
    return [Pose.from_matrix(poses[0][i], poses[1][i]) for i in best]


def search(
    segments: Floats, model: Model, camera: Camera, seed: Pose, number: int, effort: Effort
) -> list[Pose]:
    """The default matcher, with this effort."""
    found = match_search(segments, model, camera, seed, number, RANGE, effort)
    return [one.pose for one in found]


ROWS: dict[str, Matcher] = {
    "refinement from the start": from_the_start,
    "paper's GA": paper,
    "GA, oriented distances": genetic_on_edges,
    "GA, oriented distances, aligned": partial(genetic_on_edges, aligned=True),
    "same, 5 restarts": partial(genetic_on_edges, aligned=True, restarts=5),
    "4096 even draws": even_draws,
    "200 even draws, all aligned": partial(search, effort=Effort(200, 200, 200, 200)),
    "512 even draws, 50 aligned": partial(search, effort=Effort(512, 512, 50, 50)),
    "2048 even draws, 50 aligned": partial(search, effort=Effort(2048, 2048, 50, 50)),
    "4096 even draws, 100 aligned": partial(search, effort=Effort(4096, 4096, 100, 100)),
    "default: screened, half dropped midway": partial(search, effort=Effort()),
}


@dataclass(frozen=True)
class Trial:
    """One photograph with so many starts; its source is opened in the worker."""

    source: Callable[[], Photograph]
    starts: int
    rows: tuple[str, ...]


def run_trial(trial: Trial) -> dict[str, list[tuple[bool, float]]]:
    """Whether each row is right, and its seconds, start by start."""
    photograph = trial.source()
    camera, model = photograph.camera, photograph.model
    images = ImageSet(camera.width, camera.height)
    images.add("i1", photograph.pixels, photograph.exposure, photograph.gamma)
    segments = extract_segments(images.edge_map(["i1"])).endpoints
    channels = images.gradients(["i1"])
    problem = PoseProblem.at_scale(channels, model, camera, tone_sd_px=photograph.tone_sd_px)
    out: dict[str, list[tuple[bool, float]]] = {name: [] for name in trial.rows}
    for number in range(trial.starts):
        rng = np.random.default_rng([photograph.number, number])
        seed = disturbed(photograph.true, rng, RANGE.rotation_deg, RANGE.translation_px, camera.fx)
        for name in trial.rows:
            began = time.perf_counter()
            poses = ROWS[name](segments, model, camera, seed, number)
            seconds = time.perf_counter() - began
            best = best_first(problem, poses)
            right = bool(best) and best[0].solution.pose.error_to(photograph.true).within(*RIGHT)
            out[name].append((right, seconds))
    return out


def sources(folders: list[Path], seeds: range) -> Iterator[Callable[[], Photograph]]:
    """Where the photographs come from."""
    for folder in folders:
        if (folder / "stack.toml").is_file():
            yield partial(middle_of_stack, folder)
        else:
            for index in range(len(list(folder.glob("Camera_L_*.txt")))):
                yield partial(recorded, folder, index)
    if not folders:
        for number in seeds:
            for target in ("cube", "fixture", "satellite"):
                yield partial(simulated, target, "textured", number)


def main(
    folders: Annotated[list[Path] | None, typer.Argument()] = None,
    starts: Annotated[int, typer.Option(min=1)] = 4,
    seeds: Annotated[str, typer.Option(help="FIRST-LAST, of the simulated images.")] = "0-5",
    row: Annotated[list[str] | None, typer.Option(help="One of the rows; all unless given.")] = None,
) -> None:
    """Run all rows on all photographs."""
    names = tuple(row or ROWS)
    unknown = [name for name in names if name not in ROWS]
    if unknown:
        raise typer.BadParameter(f"unknown row {unknown[0]!r}; known: {', '.join(ROWS)}")
    first, last = (int(part) for part in seeds.split("-"))
    todo = [
        Trial(source, starts, names)
        for source in sources([folder.resolve() for folder in folders or []], range(first, last + 1))
    ]
    if not todo:
        named = ", ".join(map(str, folders or []))
        raise typer.BadParameter(f"no stack.toml and no Camera_L_*.txt in {named}")
    found: dict[str, list[tuple[bool, float]]] = {name: [] for name in names}
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        for part in pool.map(run_trial, todo):
            for name in names:
                found[name] += part[name]
    for name, trials in found.items():
        right, seconds = zip(*trials, strict=True)
        share = round(sum(right) / len(right), 4)
        line = {"name": name, "value": share, "unit": "share right", "trials": len(right)}
        print(json.dumps(line | {"matching_ms": round(1e3 * float(np.median(seconds)), 1)}), flush=True)


if __name__ == "__main__":
    typer.run(main)
