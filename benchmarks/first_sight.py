"""First sight: targets at random orientations, ranges and places, found without a seed pose.

    .venv/bin/python -m benchmarks.first_sight [--trials 12] [--targets plate,wheel] [--images 3] [--seed 9]
        [--clutter 0] [--width 640] [--write FOLDER]

Six targets: parts that are drawn anew for each trial (machined ones, prisms, plates, and wheels, which are
turned onto themselves but for one block), a flange that is turned onto itself by 60 degrees, and a satellite;
others if named, as gear, shaft, bracket, lumpy, statue and bottle, drawn anew too.
While a pose is not trusted, another image of the same place under another lamp is added, up to so many. One
JSON object per target: how often the right pose (1 degree, 1 % of the range, up to the target's symmetry) is
the first or as probable as the first, how often it is listed, both after all images and after the first one;
(a turn that an estimate calls free counts as right); how many wrong ones were trusted; and the processor's
seconds of a first image, of all cores. ``--write`` leaves a picture of each trial in which the first pose is
not right, and a line of each trial in ``trials.jsonl``: what is there is not run again, and counts with
the rest, so that runs of several seeds add up.
"""

from __future__ import annotations

import json
import time
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import cv2
import numpy as np
import typer

from benchmarks.cad_parts import CAD
from benchmarks.drawn_parts import PARTS, part_file
from benchmarks.free_form import FREE_FORM
from benchmarks.lines import show
from benchmarks.machined_parts import ROUND
from benchmarks.synthetic_parts import BLUR_PX, NOISE_GREY, error_of, part_of, rendered
from geometry.camera import Camera
from geometry.model import Model, find_target, load_model
from geometry.pose import RIGHT, Pose
from geometry.symmetries import Symmetry, symmetry_of
from numerics.arrays import Grey
from report.overlay import draw_overlay
from vision_server.image_set import ImageSet
from vision_server.matching import Anywhere
from vision_server.pipeline import estimate_pose
from vision_server.trust.judgement import Estimate

TARGETS = ("machined", "prisms", "plate", "satellite", "wheel", "flange")
# Segments to a circle, or lines.
COUNTS = {"machined": 48, "prisms": 60, **dict.fromkeys(ROUND, 128), **dict.fromkeys(CAD, 96)}
COUNTS |= dict.fromkeys(FREE_FORM, 64)
FILLS = (0.35, 0.9)  # of the frame's height, the target's diameter
TRUSTED = 0.93  # score, docs/trust.md
SAME_PROBABILITY = 0.999
TRIALS = "trials.jsonl"  # in the folder of results


def target_of(name: str, rng: np.random.Generator) -> Model:
    """The target of a name; a part of another draw for each state of the generator."""
    if name in COUNTS:
        return Model.of_surface(name, part_of(name, COUNTS[name], rng))
    if name in PARTS:
        with TemporaryDirectory() as folder:
            return load_model(part_file(name, Path(folder), rng))
    return load_model(find_target(name))


def any_pose(rng: np.random.Generator, model: Model, camera: Camera) -> Pose:
    """Any orientation, with the target within the frame."""
    axis = rng.normal(size=4)
    axis /= np.linalg.norm(axis)  # a unit quaternion is an even rotation
    half = float(np.linalg.norm(axis[1:]))
    turn = axis[1:] / half * 2.0 * np.arctan2(half, axis[0])
    fills = rng.uniform(*FILLS)
    range_m = camera.fy * model.diameter / (fills * camera.height)
    spare = max(0.0, 0.5 - 0.4 * fills) * range_m / camera.fx
    aside = rng.uniform(-1.0, 1.0, 2) * spare * [camera.width, camera.height]
    rotation = Pose(turn, np.zeros(3)).matrix
    return Pose.from_matrix(rotation, np.array([*aside, range_m]) - rotation @ model.middle)


def in_front_of_clutter(
    pixels: Grey, model: Model, camera: Camera, pose: Pose, rng: np.random.Generator, count: int
) -> Grey:
    """The picture with so many polygons of random greys behind the target."""
    behind = np.full(pixels.shape, 20.0)
    for _ in range(count):
        angle = np.sort(rng.uniform(0.0, 2.0 * np.pi, rng.integers(3, 7)))
        middle, reach = rng.uniform(0.0, 1.0, 2) * pixels.shape[::-1], rng.uniform(0.03, 0.25) * camera.width
        corners = middle + reach * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        cv2.fillPoly(
            behind, [np.round(corners).astype(np.int32)], float(rng.uniform(5.0, 140.0)), cv2.LINE_AA
        )
    mask, points = np.zeros(pixels.shape, np.uint8), camera.project(pose.apply(model.vertices))
    for triangle in model.triangles:
        cv2.fillConvexPoly(mask, np.round(points[triangle] * 16).astype(np.int32), 255, cv2.LINE_AA, 4)
    share = cv2.GaussianBlur(mask / 255.0, (0, 0), BLUR_PX)
    behind = cv2.GaussianBlur(behind, (0, 0), BLUR_PX) + rng.normal(0.0, NOISE_GREY, pixels.shape)
    return np.asarray(np.clip(np.round(share * pixels + (1.0 - share) * behind), 0, 255), dtype=np.uint8)


def is_right(pose: Pose, true: Pose, symmetry: Symmetry) -> bool:
    """Whether a pose looks like the true one."""
    return error_of(pose, true, symmetry).within(*RIGHT)


def judged(found: Estimate, true: Pose, symmetry: Symmetry) -> tuple[bool, bool, bool]:
    """Whether the right pose is first (or as probable as that), is listed, and a wrong one trusted.

    Where the images are said to leave a turn free, poses so turned are the same.
    """
    if found.free and symmetry.free_axis is None:
        symmetry = replace(symmetry, free_axis=found.free[0])
    right = [one for one in found.poses if is_right(one.pose, true, symmetry)]
    first = bool(right) and right[0].probability >= SAME_PROBABILITY * found.poses[0].probability
    wrong = found.pose is not None and not is_right(found.pose, true, symmetry)
    return first, bool(right), wrong and found.score > TRUSTED


@dataclass(frozen=True)
class Conditions:
    """Under what a trial is made: its target, width of the frame px, images at most, polygons behind it."""

    target: str
    width: int
    most: int
    clutter: int


@dataclass(frozen=True)
class Trial:
    """What came of one trial; verdicts are those of `judged`, after one image and after all."""

    seed: int
    number: int
    one: tuple[bool, bool, bool]
    all: tuple[bool, bool, bool]
    images: int
    seconds: float
    score: float
    size_px: float


def looked_at(
    model: Model, camera: Camera, pose: Pose, rng: np.random.Generator, given: Conditions
) -> tuple[Grey, list[tuple[Estimate, float]]]:
    """The first of the images until a pose is trusted; what each told and its processor's seconds."""
    images, behind = ImageSet(camera.width, camera.height), rng.integers(2**32)
    names: list[str] = []
    told: list[tuple[Estimate, float]] = []
    while len(names) < given.most and not (told and told[-1][0].score > TRUSTED):
        pixels = rendered(model, camera, pose, rng)
        if given.clutter:
            other = np.random.default_rng(behind)
            pixels = in_front_of_clutter(pixels, model, camera, pose, other, given.clutter)
        if not names:
            first = pixels
        names.append(f"i{len(names) + 1}")
        images.add(names[-1], pixels, 1.0, 1.0)
        began = time.process_time()
        found = estimate_pose(images, names, model, camera, Anywhere())
        told.append((found, time.process_time() - began))
    return first, told


def tried(given: Conditions, seed: int, number: int, write: Path | None) -> Trial:
    """One trial; its picture into a folder where the first pose is not right."""
    height = 3 * given.width // 4
    focal = 1.2 * given.width
    camera = Camera(given.width, height, focal, focal, 0.5 * given.width - 0.5, 0.5 * height - 0.5)
    rng = np.random.default_rng((seed, number))
    model = target_of(given.target, rng)
    pose, symmetry = any_pose(rng, model, camera), symmetry_of(model)
    pixels, told = looked_at(model, camera, pose, rng, given)
    found = told[-1][0]
    one, last = judged(told[0][0], pose, symmetry), judged(found, pose, symmetry)
    if write is not None and not last[0]:
        file = write / f"{given.target}-{seed}-{number}.png"
        cv2.imwrite(str(file), picture(pixels, model, camera, pose, found))  # type: ignore[call-overload]
    size = focal * model.diameter / float(pose.apply(model.middle[None])[0, 2])
    return Trial(seed, number, one, last, len(told), told[0][1], found.score, size)


def known(folder: Path, given: Conditions) -> list[Trial]:
    """The trials under these conditions that a folder tells of."""
    file, wanted = folder / TRIALS, asdict(given)
    rows = [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []
    mine = [row for row in rows if {key: row[key] for key in wanted} == wanted]
    return [Trial(**{key: row[key] for key in row if key not in wanted}) for row in mine]


def picture(pixels: Grey, model: Model, camera: Camera, true: Pose, found: Estimate) -> object:
    """The true pose and the first one found, beside each other."""
    poses = (true, found.pose)
    return np.hstack([draw_overlay(pixels, model, camera, pose, inset=False) for pose in poses])


def main(
    trials: int = 12,
    targets: Annotated[str, typer.Option(help="Of those above, or under targets/.")] = ",".join(TARGETS),
    images: Annotated[int, typer.Option(min=1, help="Images at most.")] = 3,
    seed: Annotated[int, typer.Option(help="Draws parts, poses and lamps.")] = 9,
    clutter: Annotated[int, typer.Option(help="Polygons behind the target.")] = 0,
    width: int = 640,
    write: Annotated[Path | None, typer.Option(help="Folder for pictures of what is not right.")] = None,
) -> None:
    """Targets found without a seed pose."""
    if write is not None:
        write.mkdir(parents=True, exist_ok=True)
    for name in targets.split(","):
        given = Conditions(name, width, images, clutter)
        done = [] if write is None else known(write, given)
        for number in range(trials):
            if (seed, number) in [(one.seed, one.number) for one in done]:
                continue
            done.append(tried(given, seed, number, write))
            if write is not None:
                with (write / TRIALS).open("a") as file:
                    file.write(json.dumps({**asdict(given), **asdict(done[-1])}) + "\n")
        if not done:
            continue
        first, listed, trusted = np.mean([one.all for one in done], axis=0)
        once = np.mean([one.one for one in done], axis=0)
        seconds = [one.seconds for one in done]
        show(
            f"first sight of {name}",
            first,
            "share first",
            listed=listed,
            wrong_and_trusted=round(len(done) * trusted),
            first_of_one=once[0],
            listed_of_one=once[1],
            trials=len(done),
            images=float(np.mean([one.images for one in done])),
            processor_s=float(np.median(seconds)),
            slowest=max(seconds),
        )


if __name__ == "__main__":
    typer.run(main)
