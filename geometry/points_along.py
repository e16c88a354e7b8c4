"""Points along lines, evenly, as symmetries are tried on."""

from __future__ import annotations

import numpy as np

from numerics.arrays import Floats, Ints


def points_along(
    vertices: Floats, lines: Ints, spacing: float, most: int, least: int = 1
) -> tuple[Floats, Floats]:
    """Points (N, 3) along lines (L, 2), and the length (N,) that each stands for.

    Parameters
    ----------
    spacing : between them, in the vertices' unit; ...
    most : ... wider where they would be more than about so many.
    least : on each line, however short: the facets of a fine tessellation have one or two all the same.
    """
    start = vertices[lines[:, 0]]
    step = vertices[lines[:, 1]] - start
    length = np.linalg.norm(step, axis=1)
    apart = max(spacing, float(length.sum()) / most, 1e-30)
    counts = np.maximum(least, np.rint(length / apart)).astype(np.int64)
    line = np.repeat(np.arange(len(counts)), counts)
    number = np.arange(len(line)) - np.repeat(np.cumsum(counts) - counts, counts)
    points = start[line] + ((number + 0.5) / counts[line])[:, None] * step[line]
    return points, (length / counts)[line]
