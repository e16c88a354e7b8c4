"""Small symmetric systems of linear equations, solved inside kernels."""

from __future__ import annotations

import math

import numpy as np

from numerics.arrays import Floats
from numerics.kernels import kernel


@kernel()
def _factor(matrix: Floats, damping: float, floor: float) -> Floats:
    """Cholesky's lower factor (n, n), see `solve_positive`; (0, 0) when there is none."""
    size = len(matrix)
    lower = np.zeros((size, size))
    for i in range(size):
        for j in range(i + 1):
            value = matrix[i, j]
            if i == j:
                value += damping * matrix[i, i] + floor
            for k in range(j):
                value -= lower[i, k] * lower[j, k]
            if i == j:
                if not value > 0.0:
                    return np.zeros((0, 0))
                lower[i, i] = math.sqrt(value)
            else:
                lower[i, j] = value / lower[j, j]
    return lower


@kernel()
def solve_positive(matrix: Floats, vector: Floats, damping: float, floor: float) -> Floats:
    """Solution (n,) of a positive definite system (n, n), (n,); 0 when it is not positive definite.

    Only the lower triangle is read. Each diagonal value d counts as d * (1 + damping) + floor.
    """
    size = len(vector)
    out = np.zeros(size)
    lower = _factor(matrix, damping, floor)
    if len(lower) == 0:
        return out
    for i in range(size):
        value = vector[i]
        for k in range(i):
            value -= lower[i, k] * out[k]
        out[i] = value / lower[i, i]
    for i in range(size - 1, -1, -1):
        value = out[i]
        for k in range(i + 1, size):
            value -= lower[k, i] * out[k]
        out[i] = value / lower[i, i]
    return out


@kernel()
def inverse_positive(matrix: Floats) -> Floats:
    """Inverse (n, n) of a positive definite matrix (n, n); NaN when it is not positive definite.

    Only the lower triangle is read.
    """
    size = len(matrix)
    lower = _factor(matrix, 0.0, 0.0)
    if len(lower) == 0:
        return np.full((size, size), np.nan)
    inverse = np.zeros((size, size))
    for i in range(size):  # of the triangle, row by row
        inverse[i, i] = 1.0 / lower[i, i]
        for j in range(i):
            value = 0.0
            for k in range(j, i):
                value -= lower[i, k] * inverse[k, j]
            inverse[i, j] = value / lower[i, i]
    out = np.empty((size, size))
    for i in range(size):
        for j in range(i + 1):
            value = 0.0
            for k in range(i, size):
                value += inverse[k, i] * inverse[k, j]
            out[i, j] = out[j, i] = value
    return out
