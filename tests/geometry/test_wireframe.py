"""What is drawn of a model follows its arcs and lens-bent lines; straight ones are their two ends."""

import cv2
import numpy as np
import pytest

from benchmarks.machined_parts import ROUND, surface_of
from geometry.camera import Camera
from geometry.model import Model, find_target, load_model
from geometry.pose import Pose
from geometry.visibility import visible_samples
from geometry.wireframe import MOST_CHORD_PX, visible_runs

CAMERA = Camera(640, 480, 768.0, 768.0, 319.5, 239.5)
OFF_PX = 0.5  # of a chord of an arc's middle, and more than samples' own zigzag


@pytest.mark.parametrize("name", ["cylinder", "body"])
def test_arcs_of_facets_are_drawn_along_their_facets(name: str) -> None:
    model = Model.of_surface(name, surface_of(ROUND[name](64)))
    pose = Pose(np.array([2.2, 0.3, 0.2]), np.array([0.0, 0.0, 0.4]))
    drawn = np.zeros((480, 640), np.uint8)
    for run in visible_runs(model, CAMERA, pose):
        cv2.polylines(drawn, [np.round(16 * run.points).astype(np.int32)], False, 255, 1, cv2.LINE_8, 4)
    away = cv2.distanceTransform(255 - drawn, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    samples = visible_samples(model, CAMERA, pose, 2.0).image
    off = away[tuple(np.round(samples[:, ::-1]).astype(np.int64).T)]
    assert off.max() <= 1.0 + OFF_PX


@pytest.mark.parametrize("range_m", [0.4, 1.5, 4.0])
def test_no_arc_is_left_however_small_it_is(range_m: float) -> None:
    """A ring of 64 sides from 120 to 12 px wide."""
    model = Model.of_surface("ring", surface_of(ROUND["cylinder"](64)))
    pose = Pose(np.array([2.2, 0.3, 0.2]), np.array([0.0, 0.0, range_m]))
    samples = visible_samples(model, CAMERA, pose, 1.0)
    segments: dict[int, list[np.ndarray]] = {}
    for run in visible_runs(model, CAMERA, pose):
        segments.setdefault(run.line, []).append(np.stack([run.points[:-1], run.points[1:]], axis=1))
    for line, found in segments.items():
        (start, end), points = np.moveaxis(np.concatenate(found), 1, 0), samples.image[samples.line == line]
        aside, chord = points[:, None] - start, end - start
        along = np.clip((aside * chord).sum(axis=2) / (chord**2).sum(axis=1), 0.0, 1.0)
        away = np.linalg.norm(aside - along[..., None] * chord, axis=2).min(axis=1)
        assert away.max() <= MOST_CHORD_PX + 1e-6


def test_a_straight_line_is_its_ends() -> None:
    model = load_model(find_target("cube"))
    pose = Pose(np.array([0.5, 0.7, 0.1]), np.array([0.0, 0.0, 5.0 * model.diameter]))
    assert all(len(run.points) == 2 for run in visible_runs(model, CAMERA, pose))
