"""What each mechanism of refinement and ranking is worth: each is left out in turn, on the same scenes.

    .venv/bin/python -m benchmarks.ablation [--stacks DIR ...] [--photographs DIR ...] [--starts 2]
        [--row NAME ...] [--off SHARE] [--tolerance SHARE] [--workers 1] [--trials FILE]

Of each light stack three fixed image sets are taken (one light each; all lights, three shutters; all lights,
three apertures); photographs are sets of one. A further group starts from seed poses that are turned onto a
near symmetry of the target. Every row sees the same images and the same disturbed seed poses. One JSON object
per row and group of scenes: estimates that are right and tight, wrong ones that are trusted, processor time,
and against the default on the same trials what was gained and lost, with a 95 % interval by resampling
scenes, and the geometric mean of the ratio of the errors where both are right; of the right poses the mean
squared normalised error and the share within its 99 % bound. With --off the models of stacks are longer by
that share along one axis and shorter by 0.8 of it along another, as parts are that were not made to measure;
--tolerance tells how far lines may be off, as a share of the model's size.
"""

from __future__ import annotations

import json
import math
import os
import time
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, Any
from unittest.mock import patch

import numpy as np
import typer

from benchmarks.photographs import Photograph, image_set, stack_studio
from benchmarks.pose_accuracy import TRACK_LIMITS_MM_DEG, true_poses
from experiments.kinds.estimate import normalised_error_squared
from geometry.camera import Camera
from geometry.model import Model, load_model
from geometry.near_symmetries import near_symmetries
from geometry.pose import RIGHT, TIGHT, Pose, disturbed
from numerics.arrays import Floats
from vision_server import pipeline
from vision_server.channels.gradients import SCALES_PX
from vision_server.channels.image_files import read_grey
from vision_server.channels.tone import file_tone
from vision_server.image_set import ImageSet
from vision_server.matching import SearchRange
from vision_server.pipeline import PipelineSettings, estimate_pose
from vision_server.pose import blending, edge_points, line_scales, observation, profiles
from vision_server.serve.inputs import read_camera
from vision_server.trust import judgement, likely, ranking, rivals, settling
from vision_server.trust.stretch import stretched

Patch = tuple[object, str, Any]

RANGE = SearchRange()
TIGHT_TRACK_MM_DEG = (2.5, 1.3)  # how far apart the two trackers are on the real frames, median
TRUSTED = 0.93  # score, see docs/trust.md
RESAMPLED = 1000
CHI_SQUARED_99 = 16.81  # of six degrees of freedom


def no_blending(samples: Any, softness: Any, blur: Any, edges: Any) -> Any:
    """No line moves its neighbour's edge."""
    return np.zeros(edges.offset.shape), np.zeros(edges.offset.shape)


def none_seen(samples: Any, softness: Any, blur: Any, edges: Any) -> Any:
    """Of no line's edge is it known how far its neighbour moves it."""
    return blending.blended(samples, softness, blur, edges._replace(strength=np.zeros(edges.offset.shape)))


def no_votes(line: Any, along: Any, offset: Any, quality: Any, lines: int, reach: float, width: Any) -> Any:
    """Every line's edge is where the pose has it; `nearest_point` makes nothing of that."""
    return np.zeros((lines, 2))


def nearest_point(line: Any, along: Any, offset: Any, shift: Any, width: Any) -> Any:
    """The edge point nearest to the line, however far."""
    away = np.where(np.isnan(offset), np.inf, np.abs(offset))
    return np.where(np.isfinite(away).any(axis=2), away.argmin(axis=2), -1)


def unbent(samples: Any, facets: Any, softness: Any, filter_px: Any) -> Any:
    """No bend of a line moves its edge."""
    return np.zeros(softness[:, samples.line].shape)


def no_outlines(model: Any, camera: Any, pose: Any, samples: Any) -> Any:
    """Outlines of curved surfaces are edges as others are."""
    return np.zeros(len(samples.line))


def as_meshed(model: Any, pose: Any, samples: Any, jacobian: Any) -> Any:
    """Every part has its model's facets."""
    return np.empty((len(samples.line), 0))


ROWS: dict[str, tuple[Patch, ...]] = {
    "default": (),
    "no association": ((observation, "associate", lambda *_: None),),
    "no hypotheses": ((ranking, "BESIDE_ROUNDS", 0),),
    "no Hough votes": ((observation, "vote", no_votes), (observation, "choose", nearest_point)),
    "no line scales": ((ranking, "with_line_scales", lambda problem, _: problem),),
    "filters as wide as the blur": (
        (observation, "FILTER_OF_SOFTNESS", np.arange(len(SCALES_PX))),
        (edge_points, "PREPARED_BEYOND_PX", 36),  # as far as flanks of outlines are looked at then
    ),
    "lines as sharp as they seem": ((line_scales, "_raise_to_median", lambda *_: None),),
    "no near symmetries": tuple((module, "near_symmetries", lambda _: ()) for module in (ranking, rivals)),
    "neighbours move no edge": ((observation, "blended", no_blending),),
    "neighbours' edges not moved back": ((observation, "blended", none_seen),),
    "bends move no edge": ((observation, "drawn_in", unbent),),
    "outlines as other edges": ((observation, "inside_of", no_outlines),),
    "facets as modelled": ((settling, "beyond_chords", as_meshed),),
    "no spin": ((ranking, "spun", lambda *_: []),),
    "no coarse look": ((pipeline, "MORE_IN_COARSE", math.inf),),
    "no restarts": ((judgement, "astray", lambda *_: None),),
    "no look the other way": ((judgement, "the_other_way", lambda *_: 0.0),),
    "no last step": ((likely, "settled", lambda _: None),),
    "no stretch in the last step": ((settling, "STRETCH_SDS", ()),),
    "no profiles": (
        (profiles, "SPREAD_PX", 0.06),
        (profiles, "SPREAD_POWER", 0.0),
        (profiles, "MOST_MOVED_PX", 0.0),
    ),
}


@dataclass(frozen=True, eq=False)
class Scene:
    """Images of one target, and the poses that count as true.

    Attributes
    ----------
    group : of scenes, for the summary.
    name : scenes of one stack or photograph share it.
    tracked : the poses are tracks, not the truth.
    """

    group: str
    name: str
    images: ImageSet
    camera: Camera
    model: Model
    true: tuple[Pose, ...]
    tone_sd_px: float
    tracked: bool = False
    turned: Pose | None = None


def stack_scenes(group: str, folder: Path, off: float = 0.0) -> Iterator[Scene]:
    """Three sets of a stack, and the same with a seed pose that is turned; its model is ``off``."""
    studio = stack_studio(folder)
    axes = np.random.default_rng(sum(map(ord, folder.name))).permutation([off, -0.8 * off, 0.0])
    model = stretched(studio.model, axes) if off > 0.0 else studio.model
    described = studio.device.describe()
    shutters, apertures = sorted(described.shutters_s), sorted(described.apertures)
    bright = tuple(light.levels - 1 for light in described.lights)
    sets: dict[str, list[Photograph]] = {
        "lights": [studio.photograph(studio.full(only)) for only in range(len(described.lights))],
        "shutters": [studio.photograph(bright, shutter_s=shutters[k]) for k in (0, len(shutters) // 2, -1)],
        "apertures": [studio.photograph(bright, aperture=aperture) for aperture in apertures[:3]],
    }
    for shots in sets.values():
        scene = partial(
            Scene, name=folder.name, images=image_set(shots), camera=studio.camera, model=model,
            true=(studio.true,), tone_sd_px=shots[0].tone_sd_px,
        )  # fmt: skip
        yield scene(group)
        for turn in near_symmetries(studio.model)[:1]:
            yield scene("seed turned", turned=turn)


def photograph_scenes(group: str, folder: Path) -> Iterator[Scene]:
    """Recorded photographs with exact or tracked poses."""
    camera, table = read_camera(folder / "camera.toml")
    model = load_model(next(folder.glob("*.cao")))
    for path, true in sorted(true_poses(folder).items()):
        (exponent,), tone_sd_px = file_tone([path], table.get("gamma"))
        images = ImageSet(camera.width, camera.height)
        images.add("i0", read_grey(path), 1.0, exponent)
        yield Scene(group, path.name, images, camera, model, true, tone_sd_px, tracked=len(true) > 1)


def judged(scene: Scene, pose: Pose | None) -> tuple[bool, bool, float]:
    """Whether a pose is right and tight, and its error in units of the loose limits."""
    if pose is None:
        return False, False, math.inf
    errors = [pose.error_to(true) for true in scene.true]
    if scene.tracked:
        off = [(e.translation_m * 1e3, e.rotation_deg) for e in errors]
        right, tight = (
            any(mm <= limits[0] and deg <= limits[1] for mm, deg in off)
            for limits in (TRACK_LIMITS_MM_DEG, TIGHT_TRACK_MM_DEG)
        )
        return right, tight, min(max(mm / off_mm, deg / off_deg) for mm, deg in off
                                 for off_mm, off_deg in [TRACK_LIMITS_MM_DEG])  # fmt: skip
    (error,) = errors
    units = max(error.rotation_deg / RIGHT[0], error.translation_fraction_of_range / RIGHT[1])
    return error.within(*RIGHT), error.within(*TIGHT), units


def run_scene(
    make: Callable[[], Iterator[Scene]], rows: Sequence[str], starts: int, tolerance: float = 0.0
) -> list[dict[str, Any]]:
    """All rows on the scenes of one source."""
    out = []
    for index, scene in enumerate(make()):
        for number in range(starts):
            rng = np.random.default_rng([number, index, sum(map(ord, scene.name))])
            around = scene.true[0] if scene.turned is None else scene.true[0].compose(scene.turned)
            seed = disturbed(
                around, rng, RANGE.rotation_deg, RANGE.translation_px, scene.camera.fx, scene.model.middle
            )
            settings = PipelineSettings(
                seed=number, tone_sd_px=scene.tone_sd_px, tolerance_m=tolerance * scene.model.diameter
            )
            estimate = partial(
                estimate_pose, scene.images, list(scene.images.images), scene.model, scene.camera, seed,
                settings,
            )  # fmt: skip
            if number == 0:
                estimate()  # fills what is kept with the images
            for row in rows:
                with ExitStack() as patches:
                    for target, name, instead in ROWS[row]:
                        patches.enter_context(patch.object(target, name, instead))
                    began = time.process_time()
                    found = estimate()
                    seconds = time.process_time() - began
                right, tight, error = judged(scene, found.pose)
                told: dict[str, Any] = {"normalised": None}
                if right and found.pose is not None and not scene.tracked:
                    told["normalised"] = normalised_error_squared(
                        found.pose, judgement.stated(found).covariance, scene.true[0]
                    )
                out.append(
                    {"row": row, "group": scene.group, "scene": scene.name, "trial": (index, number)}
                    | {"right": right, "tight": tight, "error": error, "seconds": seconds}
                    | {"wrong_trusted": not right and found.score >= TRUSTED, "score": found.score}
                    | told
                )
    return out


def interval(scenes: Sequence[str], change: Floats) -> list[float]:
    """95 % interval of the mean change (N,) per trial, in percentage points, by resampling scenes."""
    by_scene: dict[str, list[float]] = defaultdict(list)
    for scene, value in zip(scenes, change.tolist(), strict=True):
        by_scene[scene].append(value)
    sums = np.array([[sum(values), len(values)] for values in by_scene.values()])
    drawn = np.random.default_rng(0).integers(0, len(sums), (RESAMPLED, len(sums)))
    total = sums[drawn].sum(axis=1)
    return [round(float(x), 1) for x in np.percentile(100.0 * total[:, 0] / total[:, 1], [2.5, 97.5])]


def summary(name: str, group: str, found: list[dict[str, Any]], base: list[dict[str, Any]]) -> dict[str, Any]:
    """One row on one group of scenes; ``base`` are the default's trials in the same order."""
    out: dict[str, Any] = {"name": name, "group": group, "trials": len(found)}
    for key in ("right", "tight", "wrong_trusted"):
        out[key] = sum(one[key] for one in found)
        change = np.array([float(a[key]) - float(b[key]) for a, b in zip(found, base, strict=True)])
        out[f"{key}_gained_lost"] = [int((change > 0).sum()), int((change < 0).sum())]
        out[f"{key}_interval"] = interval([one["scene"] for one in found], change)
    out["trusted"] = sum(one["right"] and one["score"] >= TRUSTED for one in found)
    both = [(a["error"], b["error"]) for a, b in zip(found, base, strict=True) if a["right"] and b["right"]]
    out["error_ratio"] = round(float(np.exp(np.mean([np.log(a / b) for a, b in both] or [0.0]))), 3)
    squares = np.array([one["normalised"] for one in found if one["normalised"] is not None])
    if squares.size:
        out["normalised"] = round(float(squares.mean()), 2)
        out["within_99"] = round(float((squares <= CHI_SQUARED_99).mean()), 3)
    out["ms"] = round(1e3 * float(np.mean([one["seconds"] for one in found])), 1)
    return out


def main(
    stacks: Annotated[list[Path] | None, typer.Option(help="Folder of stacks; may be given again.")] = None,
    photographs: Annotated[list[Path] | None, typer.Option(help="Folder as in pose_accuracy.")] = None,
    starts: Annotated[int, typer.Option(min=1)] = 2,
    off: Annotated[float, typer.Option(min=0.0, max=0.3, help="What models of stacks are off.")] = 0.0,
    tolerance: Annotated[float, typer.Option(min=0.0, max=0.05, help="What lines may be off.")] = 0.0,
    row: Annotated[list[str] | None, typer.Option(help="Besides the default; all unless given.")] = None,
    workers: Annotated[int, typer.Option(min=1)] = os.cpu_count() or 1,
    trials: Annotated[Path | None, typer.Option(help="Where each trial is written, JSON lines.")] = None,
) -> None:
    """Run all rows on all scenes."""
    rows = ["default", *(name for name in row or ROWS if name != "default")]
    sources: list[Callable[[], Iterator[Scene]]] = []
    for folder in stacks or []:
        sources += [
            partial(stack_scenes, folder.name, one.parent, off) for one in sorted(folder.glob("*/stack.toml"))
        ]
    sources += [partial(photograph_scenes, folder.name, folder) for folder in photographs or []]
    if not sources:
        raise typer.BadParameter("give at least one folder of --stacks or --photographs")
    found: list[dict[str, Any]] = []
    with ProcessPoolExecutor(workers) as pool:
        for part in pool.map(partial(run_scene, rows=rows, starts=starts, tolerance=tolerance), sources):
            found += part
            if trials is not None:
                with trials.open("a") as file:
                    file.writelines(json.dumps(one) + "\n" for one in part)
    for group in dict.fromkeys(one["group"] for one in found):
        of_row = {
            name: [one for one in found if (one["row"], one["group"]) == (name, group)] for name in rows
        }
        for name, own in of_row.items():
            print(json.dumps(summary(name, group, own, of_row["default"])), flush=True)


if __name__ == "__main__":
    typer.run(main)
