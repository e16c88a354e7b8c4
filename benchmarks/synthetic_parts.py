"""Parts drawn at random, of as many lines as asked for, and images of them by a plain rasteriser.

    .venv/bin/python -m benchmarks.synthetic_parts [--shape prisms] [--counts 12,100,500,1000] [--trials 12]
        [--width 640] [--away-m 0] [--occluded 0] [--rotation-deg 25] [--translation-px 40] [--seed 0]
        [--model-count 0] [--same-views]

Prisms on a plate have so many lines; all other parts so many segments to a circle. One JSON object
per count: how many poses from disturbed starts are right (1 degree, 1 % of the range, up to symmetry), the
median error in millimetres, and the processor's seconds of an estimate. ``--away-m`` puts the origin so far
outside of the part; ``--occluded`` puts a rectangle of another grey over that share of its pixels. With
``--model-count`` the model has so many segments, whatever the picture's are; with ``--same-views`` a
round part is seen from the same ones at all counts.
"""

from __future__ import annotations

import math
import time
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import cv2
import numpy as np
import typer

from benchmarks.cad_parts import CAD
from benchmarks.free_form import FREE_FORM
from benchmarks.lines import show
from benchmarks.machined_parts import ROUND, machined, surface_of
from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import RIGHT, Pose, PoseError, disturbed, search_translation_px
from geometry.rotation import matrix_of
from geometry.surface import Surface
from geometry.symmetries import Symmetry, symmetry_of, turned_towards
from numerics.arrays import Flags, Floats, Grey, Ints
from numerics.kernels import kernel
from vision_server.image_set import ImageSet
from vision_server.pipeline import PipelineSettings, estimate_pose
from vision_server.trust.judgement import Estimate

PLATE_M = (0.20, 0.15, 0.03)
FINER = 4  # samples across a pixel
BACKGROUND, AMBIENT, LIT = 0.06, 0.12, 0.75  # linear intensities
BLUR_PX, NOISE_GREY = 0.6, 1.0
FILLS = 0.75  # of the frame's height, the part's diameter
SURE = 0.8
DRAWN = {"machined": machined, **CAD, **FREE_FORM}


def random_part(rng: np.random.Generator, lines: int) -> Surface:
    """A plate with tapered prisms of three to eight sides on it, of at least so many lines."""
    width, depth, height = PLATE_M
    polygons = [_prism(rng, (0.0, 0.0), (width, depth), -height, 0.0, 4, plain=True)]
    sides: list[int] = []
    while 12 + 3 * sum(sides) < lines:
        sides.append(int(rng.integers(3, 9)))
    across = max(1, math.ceil(math.sqrt(len(sides) * width / depth)))
    down = max(1, math.ceil(len(sides) / across))
    cell = (width / across, depth / down)
    for number, count in enumerate(sides):
        middle = (
            (number % across + 0.5) * cell[0] - 0.5 * width,
            (number // across + 0.5) * cell[1] - 0.5 * depth,
        )
        tall = rng.uniform(0.3, 1.0) * min(0.05, 1.2 * min(cell))
        polygons.append(_prism(rng, middle, cell, 0.0, tall, count))
    vertices: list[Floats] = []
    faces: list[Ints] = []
    for corners, around in polygons:
        first = sum(map(len, vertices))
        vertices.append(corners)
        faces += [first + np.array(face) for face in around]
    return Surface(
        np.concatenate(vertices), faces, np.full(len(faces), -1), np.empty((0, 2), np.int64), 0.01, 20.0
    )


def _prism(
    rng: np.random.Generator,
    middle: tuple[float, float],
    cell: tuple[float, float],
    low: float,
    high: float,
    sides: int,
    plain: bool = False,
) -> tuple[Floats, list[list[int]]]:
    """Corners (2 sides, 3) and faces of a tapered prism in a cell; a plain one is the cell's own box."""
    angle = 2.0 * np.pi * (np.arange(sides) + 0.5) / sides
    turn, taper, reach = rng.uniform(0.0, np.pi), rng.uniform(0.6, 1.0), rng.uniform(0.3, 0.46)
    ring = reach * min(cell) * np.stack([np.cos(angle + turn), np.sin(angle + turn)], axis=1)
    if plain:
        ring, taper = np.sign(np.stack([np.cos(angle), np.sin(angle)], axis=1)) * 0.5 * np.array(cell), 1.0
    corners = np.vstack(
        [
            np.column_stack([ring + middle, np.full(sides, low)]),
            np.column_stack([taper * ring + middle, np.full(sides, high)]),
        ]
    )
    walls = [[i, (i + 1) % sides, sides + (i + 1) % sides, sides + i] for i in range(sides)]
    return corners, [list(range(sides))[::-1], list(range(sides, 2 * sides)), *walls]


def random_view(rng: np.random.Generator, model: Model, camera: Camera) -> Pose:
    """The part from above and aslant, filling FILLS of the frame, near its middle."""
    spin, tilt = rng.uniform(-np.pi, np.pi), np.pi - rng.uniform(0.3, 0.9)
    lean = np.array([math.cos(spin), math.sin(spin), 0.0]) * tilt
    rotation = matrix_of(np.array([0.0, 0.0, rng.uniform(-np.pi, np.pi)])) @ matrix_of(lean)
    range_m = camera.fy * model.diameter / (FILLS * camera.height)
    aside = rng.uniform(-0.06, 0.06, 2) * range_m * camera.height / camera.fy
    return Pose.from_matrix(rotation, np.array([*aside, range_m]) - rotation @ model.middle)


@kernel()
def _drawn(corners: Floats, triangles: Ints, grey: Floats, picture: Floats, depth: Floats) -> None:
    """Triangles by depth buffer; ``corners`` (V, 3): x, y in pixels of the picture, inverse depth."""
    for m in range(len(triangles)):
        a, b, c = corners[triangles[m, 0]], corners[triangles[m, 1]], corners[triangles[m, 2]]
        area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        if area == 0.0:
            continue
        top, bottom = min(a[1], b[1], c[1]), max(a[1], b[1], c[1])
        for y in range(max(0, int(top)), min(len(picture), int(bottom) + 2)):
            left, right = np.inf, -np.inf
            for p, q in ((a, b), (b, c), (c, a)):
                if p[1] != q[1] and min(p[1], q[1]) <= y <= max(p[1], q[1]):
                    x_there = p[0] + (q[0] - p[0]) * (y - p[1]) / (q[1] - p[1])
                    left, right = min(left, x_there), max(right, x_there)
            if left > right:
                continue
            for x in range(max(0, int(left)), min(picture.shape[1], int(right) + 2)):
                u = ((b[0] - x) * (c[1] - y) - (b[1] - y) * (c[0] - x)) / area
                v = ((c[0] - x) * (a[1] - y) - (c[1] - y) * (a[0] - x)) / area
                if u < 0.0 or v < 0.0 or u + v > 1.0:
                    continue
                near = u * a[2] + v * b[2] + (1.0 - u - v) * c[2]
                if near > depth[y, x]:
                    depth[y, x], picture[y, x] = near, grey[m]


def rasterised(
    model: Model, camera: Camera, pose: Pose, grey: Floats, behind: Floats
) -> tuple[Floats, Flags]:
    """Faces of a model, each in its ``grey``, before a picture (H, W); and where it covers that."""
    points = pose.apply(model.vertices)
    pixels = camera.project(points)
    low = np.clip(np.floor(pixels.min(axis=0)) - 1, 0, None).astype(int)
    high = np.minimum(np.ceil(pixels.max(axis=0)) + 2, behind.shape[::-1]).astype(int)
    small, inside = behind.copy(), np.zeros(behind.shape, dtype=np.bool_)
    if min(high - low) <= 0:
        return small, inside
    part = np.s_[low[1] : high[1], low[0] : high[0]]
    picture = np.repeat(np.repeat(behind[part], FINER, axis=0), FINER, axis=1)
    depth = np.zeros_like(picture)
    fine = (pixels - low + 0.5) * FINER - 0.5
    corners = np.column_stack([fine, 1.0 / points[:, 2]])
    _drawn(corners, model.triangles, grey[model.triangle_face], picture, depth)
    small[part], covered = (
        cv2.resize(one, (high - low).tolist(), interpolation=cv2.INTER_AREA) for one in (picture, depth)
    )
    inside[part] = covered > 0.0
    return small, inside


def rendered(model: Model, camera: Camera, pose: Pose, rng: np.random.Generator) -> Grey:
    """8-bit linear image of a model in front of the camera, under one distant lamp and even light."""
    lamp = np.array([rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0), -1.0])
    normals = model.face_normals @ pose.matrix.T
    grey = AMBIENT + LIT * np.maximum(0.0, normals @ (lamp / np.linalg.norm(lamp)))
    behind = np.full((camera.height, camera.width), BACKGROUND)
    small, _ = rasterised(model, camera, pose, grey, behind)
    grey8 = 255.0 * cv2.GaussianBlur(small, (0, 0), BLUR_PX) + rng.normal(0.0, NOISE_GREY, small.shape)
    return np.asarray(np.clip(np.round(grey8), 0, 255), dtype=np.uint8)


def occluded(
    pixels: Grey,
    model: Model,
    camera: Camera,
    pose: Pose,
    rng: np.random.Generator,
    share: float,
) -> Grey:
    """The picture with a rectangle before it, aslant, that hides a share of the model's pixels."""
    _, inside = rasterised(model, camera, pose, np.zeros(len(model.faces)), np.zeros(pixels.shape))
    angle, y, x = rng.uniform(0.0, 2.0 * np.pi), *np.mgrid[: pixels.shape[0], : pixels.shape[1]]
    across, along = x * math.cos(angle) + y * math.sin(angle), y * math.cos(angle) - x * math.sin(angle)
    rim = 0.05 * camera.height
    low, high = along[inside].min() - rim, along[inside].max() + rim
    near, far = np.quantile(across[inside], share), across[inside].min() - rim
    hides = (across < near) & (across > far) & (along > low) & (along < high)
    soft = cv2.GaussianBlur(hides.astype(np.float64), (0, 0), BLUR_PX)
    grey = rng.uniform(20.0, 200.0) + rng.normal(0.0, NOISE_GREY, pixels.shape)
    return np.asarray(np.clip(np.round((1.0 - soft) * pixels + soft * grey), 0, 255), dtype=np.uint8)


def estimated(pixels: Grey, model: Model, camera: Camera, seed_pose: Pose) -> Estimate:
    """The pipeline on one linear image; the search range grows with the frame."""
    images = ImageSet(camera.width, camera.height)
    images.add("i1", pixels, 1.0, 1.0)
    settings = PipelineSettings(translation_range_px=search_translation_px(camera.width))
    return estimate_pose(images, ["i1"], model, camera, seed_pose, settings)


def part_of(shape: str, count: int, rng: np.random.Generator) -> Surface:
    """A part of that shape, of so many lines or segments."""
    if shape == "prisms":
        return random_part(rng, count)
    if shape in DRAWN:
        return surface_of(DRAWN[shape](rng, count))
    return surface_of(ROUND[shape](count))


def error_of(pose: Pose, true: Pose, symmetry: Symmetry) -> PoseError:
    """How far a pose is from the nearest one that looks like the true pose."""
    found = []
    for turn in symmetry.turns:
        turned = pose.compose(turn)
        if symmetry.free_axis is not None:
            turned = turned_towards(turned, true, symmetry)
        found.append(turned.error_to(true))
    return min(found, key=lambda one: one.rotation_deg)


def main(  # noqa: PLR0913  # the options of a command
    shape: Annotated[str, typer.Option(help=f"prisms, {', '.join([*ROUND, *DRAWN])}.")] = "prisms",
    counts: Annotated[str, typer.Option(help="Numbers of lines, or of segments.")] = "12,100,500,1000",
    trials: int = 12,
    model_count: Annotated[int, typer.Option(help="Segments of the model, where it has others.")] = 0,
    width: int = 640,
    away_m: float = 0.0,
    hidden: Annotated[float, typer.Option("--occluded", help="Share of the part.")] = 0.0,
    rotation_deg: float = 25.0,
    translation_px: Annotated[float, typer.Option(help="At 640 px; more on wider frames.")] = 40.0,
    seed: Annotated[int, typer.Option(help="Draws parts, poses, lamps and starts.")] = 0,
    same_views: Annotated[bool, typer.Option(help="Draw all counts alike.")] = False,
    write: Annotated[Path | None, typer.Option(help="Folder for the images.")] = None,
) -> None:
    """Poses of random parts from disturbed starts."""
    height = 3 * width // 4
    camera = Camera(width, height, 1.2 * width, 1.2 * width, 0.5 * width - 0.5, 0.5 * height - 0.5)
    for count in map(int, counts.split(",")):
        errors, seconds, wrong, sure, drawn = [], [], 0, 0, []
        own_draws = 0 if same_views else count
        for number in range(trials):
            rng = np.random.default_rng((seed, own_draws, number))
            surface = part_of(shape, count, rng)
            model = Model.of_surface("part", surface)
            drawn.append(len(model.lines))
            true = random_view(rng, model, camera)
            pixels = rendered(model, camera, true, rng)
            if hidden:
                # the rest of the draw stays as it is
                aside_rng = np.random.default_rng((seed, own_draws, number, 1))
                pixels = occluded(pixels, model, camera, true, aside_rng, hidden)
            if write is not None:
                cv2.imwrite(str(write / f"{shape}_{count}_{number}.png"), pixels)
            # the start is disturbed about the part's middle, and the file's origin moved afterwards
            start = disturbed(true, rng, rotation_deg, translation_px * width / 640, camera.fx, model.middle)
            aside = rng.normal(size=3)
            aside *= away_m / np.linalg.norm(aside)
            told = part_of(shape, model_count or count, np.random.default_rng((seed, own_draws, number)))
            moved = Model.of_surface("part", replace(told, vertices=told.vertices + aside))
            shift = Pose(np.zeros(3), -aside)
            symmetry = symmetry_of(model)
            began = time.process_time()
            estimate = estimated(pixels, moved, camera, start.compose(shift))
            seconds.append(time.process_time() - began)
            if estimate.pose is None:
                continue
            error = error_of(estimate.pose.compose(shift.inverse()), true, symmetry)
            if error.within(*RIGHT):
                errors.append(1e3 * error.translation_m)
            else:
                wrong, sure = wrong + 1, sure + (estimate.score > SURE)
        show(
            f"{shape} from a poor start",
            len(errors) / trials,
            "share right",
            count=count,
            trials=trials,
            width=width,
            drawn=int(np.median(drawn)),
            wrong=wrong,
            wrong_and_sure=sure,
            median_mm=round(float(np.median(errors)), 3) if errors else None,
            processor_s=round(float(np.median(seconds)), 3),
        )


if __name__ == "__main__":
    typer.run(main)
