"""Rotation vectors and matrices (Rodrigues' formula).

Plain functions of numbers, which kernels compile for themselves: a process without kernels can use poses."""

import math

import numpy as np

from numerics.arrays import Floats

SMALL_ANGLE_RAD = 1e-8  # below this the series of sin and cos to second order is exact in float64


def matrix_of(vector: Floats) -> Floats:
    """Rotation matrix (3, 3) of a rotation vector (3,) in rad."""
    x, y, z = float(vector[0]), float(vector[1]), float(vector[2])
    angle = math.sqrt(x * x + y * y + z * z)
    if angle < SMALL_ANGLE_RAD:
        a, b = 1.0, 0.5
    else:
        a = math.sin(angle) / angle
        b = (1.0 - math.cos(angle)) / (angle * angle)
    out = np.empty((3, 3))
    out[0, 0] = 1.0 - b * (y * y + z * z)
    out[0, 1] = b * x * y - a * z
    out[0, 2] = b * x * z + a * y
    out[1, 0] = b * x * y + a * z
    out[1, 1] = 1.0 - b * (x * x + z * z)
    out[1, 2] = b * y * z - a * x
    out[2, 0] = b * x * z - a * y
    out[2, 1] = b * y * z + a * x
    out[2, 2] = 1.0 - b * (x * x + y * y)
    return out


def cross_matrix(vector: Floats) -> Floats:
    """The matrix (3, 3) that multiplies by a vector (3,) from the left: cross_matrix(v) @ w = v x w."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def vector_of(matrix: Floats) -> Floats:
    """Rotation vector (3,) in rad, of length at most pi, of a rotation matrix (3, 3).

    Goes through the unit quaternion with the largest pivot (Shepperd 1978): exact near 0 and near pi.
    """
    (a, b, c), (d, e, f), (g, h, i) = np.asarray(matrix, dtype=np.float64).tolist()
    four = 1.0 + a + e + i, 1.0 + a - e - i, 1.0 - a + e - i, 1.0 - a - e + i  # squares of 2w, 2x, 2y, 2z
    pivot = four.index(max(four))
    w, x, y, z = (
        (four[0], h - f, c - g, d - b),
        (h - f, four[1], b + d, c + g),
        (c - g, b + d, four[2], f + h),
        (d - b, c + g, f + h, four[3]),
    )[pivot]
    sine = math.sqrt(x * x + y * y + z * z)
    length = math.copysign(math.hypot(w, sine), w)
    scale = 2.0 / length if sine < SMALL_ANGLE_RAD * abs(length) else 2.0 * math.atan2(sine, abs(w)) / sine
    scale = math.copysign(scale, length)
    return np.array([scale * x, scale * y, scale * z])


def euler_matrices(angles: Floats) -> Floats:
    """Rx(x)·Ry(y)·Rz(z) of angles (N, 3) in rad, shape (N, 3, 3)."""
    cx, cy, cz = np.cos(angles).T
    sx, sy, sz = np.sin(angles).T
    rows = [
        [cy * cz, -cy * sz, sy],
        [cx * sz + sx * sy * cz, cx * cz - sx * sy * sz, -sx * cy],
        [sx * sz - cx * sy * cz, sx * cz + cx * sy * sz, cx * cy],
    ]
    out: Floats = np.stack([np.stack(row, axis=1) for row in rows], axis=1)
    return out


def euler_matrix(x: float, y: float, z: float) -> Floats:
    """Rx(x)·Ry(y)·Rz(z), angles in rad, shape (3, 3)."""
    out: Floats = euler_matrices(np.array([[x, y, z]]))[0]
    return out
