"""Edges beside a line, for which its own may have been taken."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from geometry.model import Model
from geometry.pose import Pose
from tests.vision_server.synthetic import CAMERA, POSE, linear_picture
from tests.vision_server.tracking.films import GREYS
from vision_server.pose.line_scales import line_scales
from vision_server.pose.observation import PoseProblem
from vision_server.pose.sampling import spacing_for
from vision_server.tracking.beside import TAKEN, beside_px2
from vision_server.tracking.fitting import Habits, fitted
from vision_server.tracking.frame import Tone, problem_of, window

GAP_PX = 4.0


def front(model: Model) -> int:
    """The face that is seen most squarely."""
    normals = model.face_normals @ POSE.matrix.T
    return int(np.argmin(normals[:, 2]))


def problem(model: Model, printed: bool) -> PoseProblem:
    """The cuboid, perhaps with a frame printed inside of its front face."""
    picture = linear_picture(model, CAMERA, POSE, GREYS)
    if printed:
        corners = CAMERA.project(POSE.apply(model.vertices[model.faces[front(model)]]))
        middle = corners.mean(axis=0)
        inner = middle + (corners - middle) * (1.0 - 2.6 * GAP_PX / np.ptp(corners, axis=0).mean())
        points = np.round(16 * inner).astype(np.int32)
        grey = 0.5 * float(picture[int(middle[1]), int(middle[0])])
        cv2.fillPoly(picture, [points], grey, cv2.LINE_AA, 4)
    pixels = np.asarray(np.clip(np.round(255.0 * picture), 0, 255), dtype=np.uint8)
    seen = window(pixels, model, CAMERA, POSE, 40.0)
    assert seen is not None
    found = problem_of(seen, model, Tone.of(1.0, 0.01))
    return replace(found, scale=line_scales(found, POSE))


def front_lines(model: Model) -> np.ndarray:
    return np.flatnonzero((model.line_faces == front(model)).any(axis=1))


def test_plain_faces_have_nothing_beside_their_lines(model: Model) -> None:
    assert not beside_px2(problem(model, printed=False), POSE).any()


def test_a_printed_frame_makes_lines_doubtful_by_what_is_between(model: Model) -> None:
    found = beside_px2(problem(model, printed=True), POSE)
    lines = front_lines(model)
    assert (found[lines] > 0.25 * TAKEN * GAP_PX**2).sum() >= 3
    assert found.max() <= TAKEN * 36.0
    assert not found[np.setdiff1d(np.arange(len(found)), lines)].any()


def test_doubtful_lines_widen_the_covariance(model: Model) -> None:
    spreads = []
    for beside in (None, beside_px2(problem(model, printed=True), POSE)):
        seen = problem(model, printed=False)
        fit = fitted(seen, POSE, 3.0, spacing_for(model, seen.camera, POSE), Habits.of(model), beside)
        assert fit is not None
        spreads.append(np.sqrt(np.diag(fit.covariance)))
    assert (spreads[1] > 1.05 * spreads[0]).all()


def test_a_target_out_of_sight_has_nothing(model: Model) -> None:
    away = Pose(POSE.rotation_vector, POSE.translation * [1.0, 1.0, -1.0])
    assert beside_px2(problem(model, printed=False), away).tolist() == pytest.approx([0.0] * len(model.lines))
