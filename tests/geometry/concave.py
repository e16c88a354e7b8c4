"""Outlines of concave prisms, in 0.1 m, and the area of a model."""

import numpy as np

from geometry.model import Model

C_SHAPE = [(3, 0), (3, 1), (1, 1), (1, 2), (3, 2), (3, 3), (0, 3), (0, 0)]
ARROW = [(-2, -1), (0, 0), (2, -1), (0, 2)]
HEIGHT = 0.1


def areas(model: Model) -> float:
    """Of all triangles, in square metres."""
    a, b, c = model.vertices[model.triangles].swapaxes(0, 1)
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)
