"""Frames printed beside the edges of faces, and the outlines outside of them."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from benchmarks.printed_boxes import sharp
from geometry.model import Model
from geometry.pose import Pose
from geometry.visibility import visible_samples
from tests.vision_server.synthetic import CAMERA, POSE
from tests.vision_server.tracking.boxes import TURNS, framed_box, pictured, plain_box, seen_at
from tests.vision_server.tracking.framed import problem
from vision_server.pose.roundings import outward_of
from vision_server.tracking.beside import beside
from vision_server.tracking.fitting import Habits
from vision_server.tracking.following import Foreseen, Sight, on_lines
from vision_server.tracking.frame import Tone
from vision_server.tracking.outermost import outer_edges, outermost


def farther(pose: Pose, times: float) -> Pose:
    return Pose(pose.rotation_vector, pose.translation * times)


def test_outlines_end_where_the_background_begins(model: Model) -> None:
    samples = visible_samples(model, CAMERA, POSE, 4.0)
    outward = outward_of(model, CAMERA, POSE, samples)
    corners = CAMERA.project(POSE.apply(model.vertices)).astype(np.float32)
    silhouette = cv2.convexHull(corners)
    beside_them = samples.image + 2.0 * outward[:, None] * samples.normal
    inside = np.array([cv2.pointPolygonTest(silhouette, tuple(map(float, at)), True) for at in beside_them])
    assert np.allclose(inside[outward != 0.0], -2.0, atol=0.5)
    assert len(np.unique(samples.line[outward != 0.0])) == 6
    assert len(np.unique(samples.line[outward == 0.0])) == 3


def test_an_outline_has_nothing_outside_of_it(model: Model) -> None:
    seen = problem(model, printed=True)
    found = beside(seen, POSE)
    assert np.isnan(outer_edges(found, outward_of(model, CAMERA, POSE, found.samples))).all()
    assert outermost(seen, POSE, found) is None


def test_the_pose_on_the_outermost_edges_is_nearer(model: Model) -> None:
    seen, start = problem(model, printed=False), farther(POSE, 1.04)
    found = beside(seen, start)
    outward = outward_of(model, CAMERA, start, found.samples)
    assert np.isfinite(outer_edges(found, outward)).sum() >= 4
    pose = outermost(seen, start, found)
    assert pose is not None
    assert abs(pose.translation[2] / POSE.translation[2] - 1.0) < 0.02


@pytest.mark.parametrize(("turn", "inset"), [(0, 5), (1, 5), (3, 3), (3, 5)])
def test_a_box_is_not_taken_for_the_frames_on_its_faces(turn: int, inset: int) -> None:
    box, pose = framed_box(inset), seen_at(TURNS[turn])
    sight = Sight(sharp(box), CAMERA, Tone.of(1.0, 0.01))
    found = sight.near(pictured(box, pose), farther(pose, 1.08), Habits.of(sight.model))
    assert found is not None
    assert abs(found.pose.translation[2] / pose.translation[2] - 1.0) < 0.005


def test_print_is_asked_about_of_what_seems_farther_than_it_was_foreseen() -> None:
    box, pose = framed_box(5), seen_at(TURNS[0])
    sight, habits = Sight(sharp(box), CAMERA, Tone.of(1.0, 0.01)), Habits.of(sharp(box))
    found = sight.near(pictured(box, pose), farther(pose, 1.08), habits, Foreseen(outer=False))
    assert found is not None
    assert found.pose.translation[2] / pose.translation[2] - 1.0 > 0.01  # as far as it was expected
    again = on_lines(found.problem, found.pose, found.softness, habits, as_far=pose)
    assert again is not None
    assert abs(again.pose.translation[2] / pose.translation[2] - 1.0) < 0.005


def test_a_plain_box_stays_where_it_is() -> None:
    box, pose = plain_box(0.0008), seen_at(TURNS[0])
    sight = Sight(sharp(box), CAMERA, Tone.of(1.0, 0.01))
    found = sight.near(pictured(box, pose), farther(pose, 1.005), Habits.of(sight.model))
    assert found is not None
    assert found.pose.error_to(pose).within(1.0, 0.01)
