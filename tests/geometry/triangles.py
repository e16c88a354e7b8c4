"""Triangles that nothing joins."""

import numpy as np

from numerics.arrays import Floats, Ints


def soup(seed: int, count: int = 300) -> tuple[Floats, Ints]:
    """Triangles of all sizes, long thin ones among them, that nothing joins."""
    random = np.random.default_rng(seed)
    size = 10.0 ** random.uniform(-3.0, 0.0, (count, 1, 3))
    corners = random.uniform(-1.0, 1.0, (count, 1, 3)) + size * random.normal(size=(count, 3, 3))
    return corners.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3)
