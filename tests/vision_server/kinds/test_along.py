"""Means along edges."""

from __future__ import annotations

import numpy as np

from vision_server.edges.edge_map import EdgeMap
from vision_server.kinds.along import REACH_PX, mean_along


def test_the_mean_is_over_the_edge_and_not_over_one_that_crosses() -> None:
    ridge, axis, offset = np.zeros((3, 40, 60), np.float32)
    ridge[20, 5:55] = 1.0  # along x, across y
    axis[20, 5:55] = np.pi / 2
    ridge[5:35, 30] = 1.0
    axis[5:35, 30] = 0.0
    edges = EdgeMap.from_fields(ridge, axis, offset, 1.0)
    y, x = np.divmod(edges.places, 60)
    values = np.stack([x == 30, x]).astype(np.float32)
    crossing, mean_x = mean_along(edges, values)
    beside = (y == 20) & (abs(x - 30) > 1)
    assert crossing[beside].max() < 0.35  # one of the seven places, and its rounding
    assert np.all(crossing[(x == 30) & (abs(y - 20) > REACH_PX + 1)] == 1.0)
    inner = (y == 20) & (x > 5 + REACH_PX) & (x < 54 - REACH_PX) & (abs(x - 30) > REACH_PX + 1)
    np.testing.assert_allclose(mean_x[inner], x[inner], atol=1e-4)
