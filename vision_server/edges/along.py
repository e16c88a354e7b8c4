"""Means along edges, of each edgel and its neighbours: these are of one kind, so that noise averages out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from numerics.arrays import Field
from numerics.kernels import kernel
from vision_server.edges.edge_map import EdgeMap

# Chosen by hand: `python -m benchmarks.edge_kinds`.
REACH_PX = 12  # along the edge, to either side
STEP_PX = 4
LEAST_COSINE = np.float32(0.92)  # 23 degrees between the axes of neighbours on one edge


def mean_along(edges: EdgeMap, values: Field) -> Field:
    """Mean of the values of each edgel and of the others within reach on its edge.

    Parameters
    ----------
    edges
        N edgels.
    values
        float32 (K, N).

    Returns
    -------
    float32 (K, N).
    """
    columns = np.ascontiguousarray(values.T, np.float32)
    return np.ascontiguousarray(_means(edges.index, edges.points, edges.normals, columns).T)


@kernel(nogil=True)
def _means(number_at: NDArray[np.int32], points: Field, normals: Field, values: Field) -> Field:
    rows, columns = number_at.shape
    means = np.zeros_like(values)
    for i in range(len(points)):
        nx, ny = normals[i, 0], normals[i, 1]
        count = 0
        for step in range(-REACH_PX, REACH_PX + 1, STEP_PX):
            for across in (0, 1, -1):
                x = points[i, 0] - np.float32(step) * ny + np.float32(across) * nx
                y = points[i, 1] + np.float32(step) * nx + np.float32(across) * ny
                u, v = int(x + np.float32(0.5)), int(y + np.float32(0.5))
                if u < 0 or v < 0 or u >= columns or v >= rows:
                    continue
                at = number_at[v, u]
                if at >= 0 and abs(normals[at, 0] * nx + normals[at, 1] * ny) >= LEAST_COSINE:
                    count += 1
                    for k in range(values.shape[1]):
                        means[i, k] += values[at, k]
                    break
        for k in range(values.shape[1]):
            means[i, k] /= np.float32(count)
    return means
