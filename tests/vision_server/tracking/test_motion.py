"""The filter: what it foresees, and what its innovations are worth."""

import numpy as np
import pytest

from geometry.pose import Pose
from geometry.rotation import matrix_of
from tests.vision_server.synthetic import CAMERA
from vision_server.tracking.motion import Motion, about

MIDDLE = np.array([0.1, -0.05, 0.2])
SD = np.repeat([1e-3, 5e-4], 3)
PERIOD_S = 1 / 30


def moving(seconds: float) -> Pose:
    """A target that turns about its middle at constant speed."""
    turn = matrix_of(np.array([0.3, -0.5, 0.2]) * seconds)
    centre = np.array([0.1, 0.0, 2.0]) + seconds * np.array([0.2, -0.1, 0.3])
    return Pose.from_matrix(turn, centre - turn @ MIDDLE)


def test_it_foresees_a_constant_velocity_and_is_surprised_as_much_as_it_says() -> None:
    rng = np.random.default_rng(0)
    motion, surprises = None, []
    covariance = about(-moving(0.0).apply(MIDDLE[None])[0], np.diag(SD**2))
    for k in range(200):
        true = moving(k * PERIOD_S)
        centre = true.apply(MIDDLE[None])[0]
        covariance = about(-centre, np.diag(SD**2))
        step = rng.normal(0, SD)
        turn = matrix_of(step[:3]) @ true.matrix
        measured = Pose.from_matrix(turn, centre + step[3:] - turn @ MIDDLE)
        if motion is None:
            motion = Motion.at_rest(measured, covariance, MIDDLE)
            continue
        motion = motion.after(PERIOD_S)
        innovation = motion.innovation(measured, covariance, MIDDLE)
        surprises.append(innovation.squared)
        motion = motion.corrected(innovation)
    assert motion is not None
    ahead = motion.after(PERIOD_S).pose(MIDDLE)
    assert ahead.error_to(moving(200 * PERIOD_S)).within(0.2, 0.002)
    assert 3.0 < np.mean(surprises[50:]) < 9.0  # 6 where it is honest
    jumped = Pose(ahead.rotation_vector, ahead.translation + np.array([0.2, 0.0, 0.0]))
    assert motion.after(PERIOD_S).innovation(jumped, covariance, MIDDLE).squared > 38.3


def test_the_covariance_of_a_step_about_the_middle_and_about_the_camera() -> None:
    centre = np.array([0.3, -0.2, 1.5])
    covariance = np.diag(SD**2)
    assert about(-centre, about(centre, covariance)) == pytest.approx(covariance)
    pose = Pose(np.zeros(3), centre)
    delta = np.array([0.01, 0.0, 0.0, 0.0, 0.0, 0.0])  # about the camera it moves what is far away
    moved = pose.stepped(delta).translation - centre
    spread = about(centre, np.outer(delta, delta))
    assert np.sqrt(np.diag(spread)[3:]) == pytest.approx(np.abs(moved), rel=1e-2, abs=1e-4)


def test_how_exactly_a_pose_is_foreseen_in_pixels() -> None:
    covariance = np.diag(np.repeat([0.01**2, 0.004**2], 3))
    motion = Motion(np.eye(3), np.array([0.0, 0.0, 2.0]), np.zeros(6), np.diag(np.repeat([1.0, 0.0], 6)))
    motion.covariance[:6, :6] = covariance
    rng = np.random.default_rng(0)
    steps = rng.normal(size=(4000, 6)) * np.repeat([0.01, 0.004], 3)
    point = np.array([0.0, 0.3, 0.0])  # from the middle, turned about axes across it
    across = steps[:, 3] - steps[:, 2] * point[1]
    foreseen = motion.spread_px(CAMERA, 0.3)
    assert foreseen == pytest.approx(CAMERA.fx / 2.0 * np.std(across), rel=0.05)
