import numpy as np
import pytest

from vision_server.pose.covariance import uncertainty


def test_one_per_cent_of_the_range_counts_as_one_hundredth() -> None:
    covariance = np.diag([1e-12] * 3 + [0.006**2] * 3)
    assert uncertainty(covariance, np.array([0.0, 0.0, 0.6])) == pytest.approx(0.01, rel=1e-3)


def test_one_degree_counts_as_one_hundredth() -> None:
    # a turn about the optical axis leaves an origin on that axis where it is
    covariance = np.diag([0.0, 0.0, np.radians(1.0) ** 2] + [1e-12] * 3)
    assert uncertainty(covariance, np.array([0.0, 0.0, 0.6])) == pytest.approx(0.01, rel=1e-3)


def test_a_turn_about_the_camera_moves_the_origin() -> None:
    covariance = np.diag([0.02**2, 0.0, 0.0] + [1e-12] * 3)
    assert uncertainty(covariance, np.array([0.0, 0.0, 2.0])) == pytest.approx(0.02, rel=1e-3)


def test_a_turn_about_the_origin_does_not() -> None:
    """Rotation errors and translation errors that cancel at the origin leave the rotation alone to count."""
    turn = np.array([0.01, 0.0, 0.0])
    t = np.array([0.1, 0.2, 1.0])
    step = np.r_[turn, -np.cross(turn, t)]
    covariance = np.outer(step, step) + 1e-14 * np.eye(6)
    assert uncertainty(covariance, t) == pytest.approx(np.degrees(0.01) / 100.0, rel=1e-3)
