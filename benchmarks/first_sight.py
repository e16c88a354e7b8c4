"""First sight: targets at random orientations, ranges and places, found without a seed pose.

    .venv/bin/python -m benchmarks.first_sight [--trials 12] [--clutter 0] [--width 640]

One JSON object per target: how often the right pose (1 degree, 1 % of the range) is the first or as probable
as the first, how often it is listed, how many wrong ones had a score over 0.8, and the processor's seconds.
"""

from __future__ import annotations

import time
from typing import Annotated

import cv2
import numpy as np
import typer
from numpy.typing import NDArray

from benchmarks.lines import show
from benchmarks.synthetic_parts import BLUR_PX, LIMITS, NOISE_GREY, random_part, rendered
from geometry.camera import Camera
from geometry.model import Model, find_target, load_model
from geometry.pose import Pose
from vision_server.image_set import ImageSet
from vision_server.matching import Anywhere
from vision_server.pipeline import estimate_pose

TARGETS = ("cube", "fixture", "satellite")
PARTS = (30, 100)  # lines
FILLS = (0.35, 0.9)  # of the frame's height, the target's diameter
SURE = 0.8
SAME_PROBABILITY = 0.999


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
    pixels: NDArray[np.uint8], model: Model, camera: Camera, pose: Pose, rng: np.random.Generator, count: int
) -> NDArray[np.uint8]:
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


def main(
    trials: int = 12,
    clutter: Annotated[int, typer.Option(help="Polygons behind the target.")] = 0,
    width: int = 640,
) -> None:
    """Targets found without a seed pose."""
    height = 3 * width // 4
    camera = Camera(width, height, 1.2 * width, 1.2 * width, 0.5 * width - 0.5, 0.5 * height - 0.5)
    models = [load_model(find_target(name)) for name in TARGETS]
    models += [
        Model.of_surface(f"part of {lines} lines", random_part(np.random.default_rng(lines), lines))
        for lines in PARTS
    ]
    for model in models:
        first, listed, sure, seconds = 0, 0, 0, []
        for number in range(trials):
            rng = np.random.default_rng((9, number))
            pose = any_pose(rng, model, camera)
            pixels = rendered(model, camera, pose, rng)
            if clutter:
                pixels = in_front_of_clutter(pixels, model, camera, pose, rng, clutter)
            images = ImageSet(width, height)
            images.add("i1", pixels, 1.0, 1.0)
            began = time.process_time()
            found = estimate_pose(images, ["i1"], model, camera, Anywhere())
            seconds.append(time.process_time() - began)
            right = [one for one in found.poses if one.pose.error_to(pose).within(*LIMITS)]
            listed += bool(right)
            first += bool(right) and right[0].probability >= SAME_PROBABILITY * found.poses[0].probability
            if found.pose is not None and not found.pose.error_to(pose).within(*LIMITS):
                sure += found.score > SURE
        show(
            f"first sight of {model.name}",
            first / trials,
            "share first",
            listed=round(listed / trials, 3),
            wrong_and_sure=sure,
            trials=trials,
            processor_s=round(float(np.median(seconds)), 2),
        )


if __name__ == "__main__":
    typer.run(main)
