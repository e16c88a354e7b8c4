"""Intricate parts, and parts far from their file's origin, are found from poor starts."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.synthetic_parts import error_of, estimated, part_of, random_part, random_view, rendered
from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose, disturbed
from geometry.symmetries import symmetry_of

CAMERA = Camera(640, 480, 768.0, 768.0, 319.5, 239.5)


@pytest.mark.parametrize(("lines", "aside_m"), [(12, 0.0), (100, 3.0), (500, 1.0), (1000, 0.0)])
def test_a_part_is_found_however_intricate_and_wherever_its_origin(lines: int, aside_m: float) -> None:
    rng = np.random.default_rng((lines, 99))
    surface = random_part(rng, lines)
    model = Model.of_surface("part", surface)
    assert len(model.lines) >= lines
    true = random_view(rng, model, CAMERA)
    pixels = rendered(model, CAMERA, true, rng)
    shift = np.array([0.6, 0.0, -0.8]) * aside_m  # so that the far ones lie behind the camera or beside it
    moved = Model.of_surface("part", replace(surface, vertices=surface.vertices + shift))
    to_origin = Pose(np.zeros(3), -shift)
    start = disturbed(true, rng, 25.0, 40.0, CAMERA.fx)
    estimate = estimated(pixels, moved, CAMERA, start.compose(to_origin))
    assert estimate.pose is not None
    assert estimate.pose.compose(to_origin.inverse()).error_to(true).within(0.1, 0.001)
    assert estimate.score > 0.8


@pytest.mark.slow
@pytest.mark.parametrize(
    "draw",
    [
        (33101, 1000, 9),  # nearly all that is aligned comes to one wrong place
        (31542, 5000, 36),  # so much of it out of the search range
        (31742, 5000, 16),  # only a second, thorough look finds it
        (32004, 5000, 40),
    ],
)
def test_dense_parts_are_found_whose_edges_suggest_other_poses(draw: tuple[int, int, int]) -> None:
    rng = np.random.default_rng(draw)
    model = Model.of_surface("part", random_part(rng, draw[1]))
    true = random_view(rng, model, CAMERA)
    pixels = rendered(model, CAMERA, true, rng)
    estimate = estimated(pixels, model, CAMERA, disturbed(true, rng, 25.0, 40.0, CAMERA.fx, model.middle))
    assert estimate.pose is not None
    assert estimate.pose.error_to(true).within(0.5, 0.002)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("shape", "segments"),
    [("cylinder", 256), ("cylinder", 1024), ("ring", 256), ("body", 32), ("machined", 96)],
)
def test_a_round_part_is_found_however_fine_its_mesh(shape: str, segments: int) -> None:
    rng = np.random.default_rng((segments, 0))
    model = Model.of_surface(shape, part_of(shape, segments, rng))
    true = random_view(rng, model, CAMERA)
    pixels = rendered(model, CAMERA, true, rng)
    estimate = estimated(pixels, model, CAMERA, disturbed(true, rng, 25.0, 40.0, CAMERA.fx))
    assert estimate.pose is not None
    assert error_of(estimate.pose, true, symmetry_of(model)).within(0.3, 0.001)
