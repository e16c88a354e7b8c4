import numpy as np
import pytest

from geometry.model import Model
from geometry.pose import Pose
from tests.vision_server.synthetic import CAMERA, POSE, linear_picture, photographed
from tests.vision_server.test_refinement import channels_of
from vision_server.line_scales import line_scales
from vision_server.line_weights import base_weights
from vision_server.measurement import Measurement, measure
from vision_server.sidesteps import LOOSENED_PX, laid_beside, loosened

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


def measured(model: Model, picture: np.ndarray) -> tuple[list, Measurement, np.ndarray]:
    channels = channels_of(photographed(picture))
    scale = line_scales(channels, model, CAMERA, POSE, 4.0)
    measurement = measure(channels, model, CAMERA, POSE, 4.0, scale, 1.0)
    return channels, measurement, base_weights(measurement, len(model.lines))


def pixels_apart(model: Model, pose: Pose, other: Pose) -> float:
    """Largest distance between the corners' images."""
    here, there = (CAMERA.project(one.apply(model.vertices)) for one in (pose, other))
    return float(np.linalg.norm(here - there, axis=1).max())


def test_lines_are_laid_on_a_printed_line_beside_them(model: Model) -> None:
    channels, measurement, base = measured(model, with_outline(model))
    beside = laid_beside(channels, model, CAMERA, POSE, measurement, base, 6)
    assert len(beside) == 6
    face, outline = printed(model)
    apart = CAMERA.project(POSE.apply(outline)) - CAMERA.project(
        POSE.apply(model.vertices[model.faces[face]])
    )
    moves = [pixels_apart(model, POSE, pose) for pose in beside]
    nearest, farthest = np.linalg.norm(apart, axis=1).min(), np.linalg.norm(apart, axis=1).max()
    assert any(0.3 * nearest < move < 3.0 * farthest for move in moves), (moves, nearest, farthest)


def test_without_other_edges_nothing_is_laid_elsewhere(model: Model) -> None:
    channels, measurement, base = measured(model, linear_picture(model, CAMERA, POSE, 6 * (0.6,)))
    assert laid_beside(channels, model, CAMERA, POSE, measurement, base, 6) == []


@pytest.mark.parametrize("motions", [1, 2])
def test_loosened_poses_lie_a_set_step_to_either_side(model: Model, motions: int) -> None:
    _, measurement, base = measured(model, linear_picture(model, CAMERA, POSE))
    poses = loosened(POSE, measurement, base, motions)
    assert len(poses) == 2 * motions
    for pose in poses:
        assert 0.5 * LOOSENED_PX < pixels_apart(model, POSE, pose) < 4.0 * LOOSENED_PX
    one, other = poses[:2]
    middle = 0.5 * (one.translation + other.translation)
    np.testing.assert_allclose(middle, POSE.translation, atol=1e-3)
