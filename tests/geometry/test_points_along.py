"""Points along lines."""

import numpy as np
import pytest

from geometry.points_along import points_along

VERTICES = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.01, 0.0], [1.0, 0.01, 3.0]])
LINES = np.array([[0, 1], [1, 2], [2, 3]])


def test_points_lie_evenly_and_stand_for_all_of_the_length() -> None:
    points, length = points_along(VERTICES, LINES, 0.1, 1000)
    assert length.sum() == pytest.approx(4.01)
    assert len(points) == 10 + 1 + 30
    assert np.linalg.norm(np.diff(points[:10], axis=0), axis=1) == pytest.approx(0.1)
    assert length @ points / length.sum() == pytest.approx(  # the centroid of the lines themselves
        (1.0 * np.array([0.5, 0, 0]) + 0.01 * np.array([1, 0.005, 0]) + 3.0 * np.array([1, 0.01, 1.5])) / 4.01
    )


def test_there_are_no_more_than_so_many_and_some_on_each_line() -> None:
    points, length = points_along(VERTICES, LINES, 0.0, 40, least=2)
    assert len(points) == 10 + 2 + 30
    assert length[10:12] == pytest.approx(0.005)
