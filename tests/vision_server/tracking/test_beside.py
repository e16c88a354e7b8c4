"""Edges beside a line, for which its own may have been taken."""

from __future__ import annotations

import numpy as np

from geometry.model import Model
from geometry.pose import Pose
from tests.vision_server.synthetic import POSE
from tests.vision_server.tracking.framed import GAP_PX, front, problem
from vision_server.pose.sampling import spacing_for
from vision_server.tracking.beside import TAKEN_CHANCE, beside
from vision_server.tracking.fitting import Habits, fitted


def front_lines(model: Model) -> np.ndarray:
    return np.flatnonzero((model.line_faces == front(model)).any(axis=1))


def test_plain_faces_have_nothing_beside_their_lines(model: Model) -> None:
    assert not beside(problem(model, printed=False), POSE).variance_px2.any()


def test_a_printed_frame_makes_lines_doubtful_by_what_is_between(model: Model) -> None:
    found = beside(problem(model, printed=True), POSE).variance_px2
    lines = front_lines(model)
    assert (found[lines] > 0.25 * TAKEN_CHANCE * GAP_PX**2).sum() >= 3
    assert found.max() <= TAKEN_CHANCE * 36.0
    assert not found[np.setdiff1d(np.arange(len(found)), lines)].any()


def test_doubtful_lines_widen_the_covariance(model: Model) -> None:
    spreads = []
    for variance in (None, beside(problem(model, printed=True), POSE).variance_px2):
        seen = problem(model, printed=False)
        fit = fitted(seen, POSE, 3.0, spacing_for(model, seen.camera, POSE), Habits.of(model), variance)
        assert fit is not None
        spreads.append(np.sqrt(np.diag(fit.covariance)))
    assert (spreads[1] > 1.05 * spreads[0]).all()


def test_a_target_out_of_sight_has_nothing(model: Model) -> None:
    away = Pose(POSE.rotation_vector, POSE.translation * [1.0, 1.0, -1.0])
    assert not beside(problem(model, printed=False), away).variance_px2.any()
