"""Simulated films of targets that move, with known truth: models in flat greys, and printed boxes."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.docking_gear import write_gear
from benchmarks.patches import of_faces
from benchmarks.printed_boxes import Box, random_box, sharp, taken
from benchmarks.synthetic_parts import random_part, rasterised
from geometry.camera import Camera
from geometry.model import TARGETS, Model, load_model
from geometry.pose import Pose
from geometry.rotation import matrix_of, vector_of
from numerics.arrays import Flags, Floats, Grey
from vision_server.trust.stretch import stretched

CAMERA = Camera(640, 480, 768.0, 768.0, 319.5, 239.5)
KINDS = ("calm", "fast", "eighth", "arm", "lights", "leaving", "another", "printed", "stretched")
MOST = {"calm": (4.0, 0.5), "eighth": (4.0, 0.5), "printed": (10.0, 2.0)}  # px and degrees a frame; else:
FASTEST = (20.0, 3.0)
PERIOD_S = 1.0 / 30.0
OPEN = 0.4  # of it, the shutter, where the motion blurs
MOMENTS = 5  # of an exposure
FILLS = 0.35  # of the frame's height, the target's diameter
STRETCHED = (0.6, 1.4)  # another part's axes
TOO_LONG = (0.05, 0.15)  # a stretched model along one of its axes
NOISE_GREY, BLUR_PX = 1.5, 0.8


@dataclass(frozen=True, eq=False)
class Shown:
    """One frame of a film, with what is true of it."""

    pixels: Grey
    pose: Pose
    time_s: float
    visible: float
    turns: Sequence[Pose]


def waves(rng: np.random.Generator, count: int, dimensions: int, most: float, frames: float) -> Floats:
    """A smooth path (count, dimensions) whose fastest step is ``most`` long; it turns in so many frames."""
    place = np.arange(count)[:, None, None]
    rates = rng.uniform(0.3, 1.0, (1, 3, dimensions)) * 2.0 * np.pi / frames
    sums = np.sin(place * rates + rng.uniform(0, 2 * np.pi, rates.shape)).sum(axis=1)
    return np.asarray(sums * most / np.linalg.norm(np.diff(sums, axis=0), axis=1).max())


def path(rng: np.random.Generator, model: Model, kind: str, count: int) -> list[Pose]:
    """True poses of a film."""
    most_px, most_deg = MOST.get(kind, FASTEST)
    turn = matrix_of(rng.normal(size=3))
    range_m = CAMERA.fy * model.diameter / (FILLS * CAMERA.height)
    aside = waves(rng, count, 2, most_px, 60.0)
    aside *= min(1.0, 110.0 / np.abs(aside).max())
    if kind == "leaving":
        aside[:, 0] += 700.0 * np.exp(-((np.arange(count) / count - 0.5) ** 2) / 0.06)
    nearer = 1.0 + 0.15 * np.sin(np.arange(count) / 25.0 + rng.uniform(0, 6))
    rates = np.radians(waves(rng, count + 1, 3, 1.0, 40.0))
    rates *= np.radians(most_deg) / np.linalg.norm(rates, axis=1).max()
    poses = []
    for k in range(count):
        turn = matrix_of(rates[k]) @ turn
        away = range_m * nearer[k]
        middle = np.array([*(aside[k] * away / CAMERA.fx), away])
        poses.append(Pose.from_matrix(turn, middle - turn @ model.middle))
    return poses


def film(number: int, kind: str, count: int, target: str = "") -> tuple[Model, Iterator[Shown]]:
    """A film by number; of docking gear where a ``target`` names it."""
    rng = np.random.default_rng([number, KINDS.index(kind)])
    if kind == "printed":
        box = random_box(rng)
        return sharp(box), _photographed(rng, box, path(rng, sharp(box), kind, count + 1))
    names = ("cube", "fixture", "satellite")
    if target:
        with TemporaryDirectory() as folder:
            model = load_model(write_gear(target, Path(folder)))
    elif number % 4 < 3:
        model = load_model(TARGETS / f"{names[number % 4]}.cao")
    else:
        model = Model.of_surface("part", random_part(rng, 40))
    step = 8 if kind == "eighth" else 1
    poses = path(rng, model, kind, count * step)[::step]
    drawn = model
    if kind == "another":
        part = random_part(rng, 60)  # on a plate of its own: that of all random parts is the same
        stretch = rng.uniform(*STRETCHED, 3)
        drawn = Model.of_surface("another", replace(part, vertices=part.vertices * stretch))
    if kind == "stretched":
        strain = np.log1p(rng.uniform(*TOO_LONG)) * np.eye(3)[rng.integers(3)]
        model = stretched(model, strain)
    patch = of_faces(drawn) if target else np.arange(len(drawn.faces))
    return model, _shown(rng, drawn, poses, kind, step, patch)


def _shown(
    rng: np.random.Generator, model: Model, poses: list[Pose], kind: str, step: int, patch: NDArray[np.intp]
) -> Iterator[Shown]:
    """Frames of a path; faces of one ``patch`` (F,) are of one grey."""
    clutter, turns = _clutter(rng), same_after(model)
    lamps = rng.uniform(-1.0, 1.0, (3, 2)) if kind == "lights" else rng.uniform(-1.0, 1.0, (1, 2))
    greys = rng.uniform(0.5, 1.0, len(model.faces))[patch]
    for k, pose in enumerate(poses):
        lamp = np.array([*lamps[k % len(lamps)], -1.0])
        normals = model.face_normals @ pose.matrix.T
        lit = greys * (0.15 + 0.7 * np.maximum(0.0, normals @ (lamp / np.linalg.norm(lamp))))
        picture, inside = rasterised(model, CAMERA, pose, lit, clutter)
        visible = _in_frame(model, pose)
        if kind == "arm":
            visible *= _arm(picture, inside, k / len(poses))
        visible = 0.0 if kind == "another" else visible
        yield Shown(_sensed(rng, picture), pose, k * step * PERIOD_S, visible, turns)


def _photographed(rng: np.random.Generator, box: Box, poses: list[Pose]) -> Iterator[Shown]:
    """A printed box, blurred by its motion; the pose is that of the exposure's middle."""
    model = sharp(box)
    clutter = _clutter(rng) * rng.uniform(0.7, 2.0) + rng.uniform(0.0, 0.4)
    lamp, turns = np.array([*rng.uniform(-1.0, 1.0, 2), -1.0]), same_after(model)
    for k, (pose, after) in enumerate(itertools.pairwise(poses)):
        turn, shift = vector_of(after.matrix @ pose.matrix.T), after.translation - pose.translation
        moments = [
            Pose.from_matrix(matrix_of(share * turn) @ pose.matrix, pose.translation + share * shift)
            for share in np.linspace(-0.5 * OPEN, 0.5 * OPEN, MOMENTS)
        ]
        picture = taken(box, moments, CAMERA, lamp / np.linalg.norm(lamp), clutter)
        yield Shown(_sensed(rng, picture), pose, k * PERIOD_S, _in_frame(model, pose), turns)


def _sensed(rng: np.random.Generator, picture: Floats) -> Grey:
    """A linear picture as a camera gives it."""
    grey = cv2.GaussianBlur(255.0 * picture.astype(np.float32), (0, 0), BLUR_PX)
    noisy = grey + NOISE_GREY * rng.standard_normal(picture.shape, dtype=np.float32)
    return np.asarray(np.clip(np.rint(noisy), 0, 255), dtype=np.uint8)


def _clutter(rng: np.random.Generator) -> Floats:
    """Rectangles and slow shading behind the target, linear 0..1."""
    size = (CAMERA.height, CAMERA.width)
    picture = cv2.resize(rng.uniform(0.05, 0.25, (6, 8)), size[::-1], interpolation=cv2.INTER_CUBIC)
    for _ in range(12):
        place, sides = rng.uniform(0, size[::-1]).tolist(), rng.uniform(20, 200, 2).tolist()
        box = cv2.boxPoints((place, sides, rng.uniform(0, 90)))
        cv2.fillPoly(picture, [np.round(box).astype(np.int32)], rng.uniform(0.05, 0.4), cv2.LINE_AA)
    return np.asarray(picture, dtype=np.float64)


def _in_frame(model: Model, pose: Pose) -> float:
    pixels = CAMERA.project(pose.apply(model.vertices))
    return float(np.mean(((pixels >= 0) & (pixels < [CAMERA.width, CAMERA.height])).all(axis=1)))


def _arm(picture: Floats, inside: Flags, passed: float) -> float:
    """Draw an arm that crosses the target and hides most of it half-way; the share that is left."""
    _, columns = np.nonzero(inside)
    if len(columns) == 0:
        return 0.0
    left, right = columns.min(), columns.max() + 1
    wide = int(0.62 * (right - left))
    at = int(left - 2.2 * wide + (right - left + 3.4 * wide) * passed)
    covered = inside[:, max(0, at) : max(0, at + wide)].sum()
    picture[:, max(0, at) : max(0, at + wide)] = 0.3
    return float(1.0 - covered / len(columns))


def same_after(model: Model) -> list[Pose]:
    """Turns of a cube about the target's middle that leave its corners where corners are."""
    turns = []
    for first, second in itertools.permutations(np.vstack([np.eye(3), -np.eye(3)]), 2):
        if abs(first @ second) > 0.5:
            continue
        turn = np.column_stack([first, second, np.cross(first, second)])
        points = (model.vertices - model.middle) @ turn.T + model.middle
        apart = np.linalg.norm(points[:, None] - model.vertices[None], axis=2).min(axis=1)
        if apart.max() < 1e-3 * model.diameter and not np.allclose(turn, np.eye(3)):
            turns.append(Pose.turn_about(model.middle, turn))
    return turns
