"""Ear clipping tiles simple polygons, convex or not."""

import tracemalloc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.errors import GeometryError
from geometry.polygon import area_vector, triangulate


@settings(deadline=None)
@given(st.lists(st.floats(0.2, 2.0), min_size=3, max_size=14), st.booleans())
def test_triangles_tile_a_star_shaped_polygon(radii: list[float], turned: bool) -> None:
    angles = np.arange(len(radii)) * 2 * np.pi / len(radii)
    flat = np.array(radii)[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
    corners = flat @ np.array([[0.6, 0.0, 0.8], [-0.48, 0.8, 0.36]]) + [1.0, 2.0, 3.0]
    corners = corners[::-1] if turned else corners
    triangles = triangulate(corners)
    assert len(triangles) == len(corners) - 2
    areas = np.array([area_vector(corners[t]) for t in triangles])
    whole = area_vector(corners)
    np.testing.assert_allclose(areas.sum(axis=0), whole, atol=1e-9)
    assert np.linalg.norm(areas, axis=1).sum() == pytest.approx(np.linalg.norm(whole))


def test_corners_on_a_straight_side_are_allowed() -> None:
    corners = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]], dtype=float)
    areas = [np.linalg.norm(area_vector(corners[t])) for t in triangulate(corners)]
    assert sum(areas) == pytest.approx(4.0)


@pytest.mark.slow
def test_thousands_of_corners_take_little_memory() -> None:
    turn = np.arange(4000) * 2 * np.pi / 4000
    radius = 1 + 0.05 * np.sin(40 * turn)
    corners = np.column_stack([radius * np.cos(turn), radius * np.sin(turn), np.zeros(4000)])
    tracemalloc.start()
    triangles = triangulate(corners)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 200e6
    areas = [np.linalg.norm(area_vector(corners[t])) for t in triangles]
    assert sum(areas) == pytest.approx(np.linalg.norm(area_vector(corners)))


@pytest.mark.parametrize(
    ("corners", "message"),
    [
        ([[0, 0, 0], [1, 0, 0]], "at least 3"),
        ([[0, 0, 0], [1, 0, 0], [2, 0, 0]], "no area"),
        ([[0, 0, 0], [3, 0, 0], [0, 1, 0], [3, 2, 0], [2, -2, 0]], "cross"),
    ],
)
def test_what_is_no_polygon_is_refused(corners: list[list[float]], message: str) -> None:
    with pytest.raises(GeometryError, match=message):
        triangulate(np.array(corners, dtype=float))
