"""Means along edges, of each edgel and its neighbours: these are of one kind, so that noise averages out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from numerics.arrays import Field
from numerics.kernels import kernel
from numerics.logarithm import ONE, ZERO
from vision_server.edges.edge_map import EdgeMap

# Chosen by hand: `python -m benchmarks.edge_kinds`.
REACH_PX = 12  # along the edge, to either side
STEP_PX = 4
WIDTH = 6  # values of an edgel whose means are taken at once
LEAST_COSINE = np.float32(0.92)  # 23 degrees between the axes of neighbours on one edge


def mean_along(edges: EdgeMap, values: Field) -> Field:
    """Mean of the values of each edgel and of the others within reach on its edge.

    Parameters
    ----------
    edges
        N edgels.
    values
        float32 (K, N), of six kinds at most.

    Returns
    -------
    float32 (K, N).
    """
    columns = np.zeros((len(edges), WIDTH), np.float32)
    columns[:, : len(values)] = values.T
    means = _means(edges.index, edges.points, edges.normals, columns)
    return np.ascontiguousarray(means.T[: len(values)])


@kernel()
def _means(number_at: NDArray[np.int32], points: Field, normals: Field, values: Field) -> Field:
    rows, columns = number_at.shape
    means, half = np.empty_like(values), np.float32(0.5)
    for i in range(len(points)):
        nx, ny = normals[i, 0], normals[i, 1]
        count, a, b, c, d, e, f = 0, ZERO, ZERO, ZERO, ZERO, ZERO, ZERO  # in registers, unlike an array
        for step in range(-REACH_PX, REACH_PX + 1, STEP_PX):
            for across in (0, 1, -1):
                x = points[i, 0] - np.float32(step) * ny + np.float32(across) * nx
                y = points[i, 1] + np.float32(step) * nx + np.float32(across) * ny
                u, v = int(x + half), int(y + half)
                if u < 0 or v < 0 or u >= columns or v >= rows:
                    continue
                at = number_at[v, u]
                if at >= 0 and abs(normals[at, 0] * nx + normals[at, 1] * ny) >= LEAST_COSINE:
                    count, of = count + 1, values[at]
                    a, b, c, d, e, f = a + of[0], b + of[1], c + of[2], d + of[3], e + of[4], f + of[5]
                    break
        share, mean = ONE / np.float32(count), means[i]
        mean[0], mean[1], mean[2] = share * a, share * b, share * c
        mean[3], mean[4], mean[5] = share * d, share * e, share * f
    return means
