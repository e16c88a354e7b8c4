import numpy as np
import pytest

from geometry.model import Model
from geometry.pose import Pose
from tests.vision_server.refined_poses import channels_of
from tests.vision_server.synthetic import CAMERA, POSE, linear_picture, photographed
from vision_server.pose.observation import PoseProblem
from vision_server.pose.refinement import prior_precision
from vision_server.trust.hypotheses import (
    LOOSENED_MOTIONS,
    LOOSENED_PX,
    EdgesAround,
    edges_around,
    explained,
    followed,
    hypotheses_beside,
    loosened_steps,
)

SMALLER = 0.9
"""The printed outline's size, as a share of the face's."""


def printed(model: Model) -> tuple[int, np.ndarray]:
    """A visible face, and an outline printed on it, (4, 3) in the target frame."""
    points = POSE.apply(model.vertices)
    normals = model.face_normals @ POSE.matrix.T
    face = next(
        index for index, corners in enumerate(model.faces) if normals[index] @ points[corners[0]] < 0.0
    )
    corners = model.vertices[model.faces[face]]
    middle = corners.mean(axis=0)
    return face, middle + SMALLER * (corners - middle)


def with_outline(model: Model) -> np.ndarray:
    """Picture of the cuboid with a dark line along the edges of one face."""
    import cv2

    picture = linear_picture(model, CAMERA, POSE)
    _, outline = printed(model)
    pixels = CAMERA.project(POSE.apply(outline))
    thick = np.zeros(picture.shape, np.uint8)
    cv2.polylines(thick, [np.round(16 * pixels).astype(np.int32)], True, 255, 2, cv2.LINE_AA, 4)
    return picture * (1.0 - 0.6 * thick / 255.0)


def around(model: Model, picture: np.ndarray) -> EdgesAround:
    return edges_around(PoseProblem.at_scale(channels_of(photographed(picture)), model, CAMERA), POSE)


def pixels_apart(model: Model, pose: Pose, other: Pose) -> float:
    """Largest distance between the corners' images."""
    here, there = (CAMERA.project(one.apply(model.vertices)) for one in (pose, other))
    return float(np.linalg.norm(here - there, axis=1).max())


def test_lines_are_laid_on_a_printed_line_beside_them(model: Model) -> None:
    beside = hypotheses_beside(around(model, with_outline(model)), POSE, len(model.lines), 6)
    assert beside
    face, outline = printed(model)
    apart = CAMERA.project(POSE.apply(outline)) - CAMERA.project(
        POSE.apply(model.vertices[model.faces[face]])
    )
    moves = [pixels_apart(model, POSE, pose) for pose in beside]
    nearest, farthest = np.linalg.norm(apart, axis=1).min(), np.linalg.norm(apart, axis=1).max()
    assert any(0.3 * nearest < move < 3.0 * farthest for move in moves), (moves, nearest, farthest)


def test_without_other_edges_there_is_nothing_beside(model: Model) -> None:
    near = around(model, linear_picture(model, CAMERA, POSE))
    assert hypotheses_beside(near, POSE, len(model.lines), 6) == []


def test_a_pose_is_explained_by_its_own_edges(model: Model) -> None:
    near = around(model, linear_picture(model, CAMERA, POSE))
    own = explained(near.jacobian, near.offset, near.samples.px, np.zeros(6))
    off = explained(near.jacobian, near.offset, near.samples.px, np.array([0.0, 0.03, 0.0, 0.004, 0.0, 0.0]))
    assert own > 0.95
    assert off < 0.6 * own


def test_a_small_step_settles_where_it_came_from(model: Model) -> None:
    near = around(model, linear_picture(model, CAMERA, POSE))
    step = np.array([0.0, 0.02, 0.0, 0.002, 0.0, 0.0])
    assert np.abs(near.jacobian @ step).max() > 2.0
    followed(near.jacobian, near.offset, near.samples.px, prior_precision(0.4, 1.0)[:6], step)
    assert np.abs(near.jacobian @ step).max() < 0.3


def test_loosened_steps_go_a_set_way_to_either_side(model: Model) -> None:
    near = around(model, linear_picture(model, CAMERA, POSE))
    steps = loosened_steps(near.jacobian, near.samples.px, prior_precision(0.4, 1.0)[:6], 0.4)
    assert len(steps) == 2 * LOOSENED_MOTIONS
    for step in steps:
        assert np.abs(near.jacobian @ step).max() == pytest.approx(LOOSENED_PX)
    np.testing.assert_allclose(steps[0], -steps[1])


def test_edge_points_of_several_channels_at_one_place_are_one(model: Model) -> None:
    channels = channels_of(photographed(linear_picture(model, CAMERA, POSE)))
    one, three = (
        edges_around(PoseProblem.at_scale(count * channels, model, CAMERA), POSE) for count in (1, 3)
    )
    np.testing.assert_array_equal(one.offset, three.offset)
