"""Poses of the search range from numbers between -1 and 1, and numbers that fill it evenly."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from geometry.camera import Camera
from geometry.pose import Pose
from geometry.rotation import euler_matrix
from vision_server.matching.match import SearchRange

Floats = NDArray[np.float64]

MARGIN = 0.15  # of the search range; a true pose at its border must not be lost to noise
MARGIN_DEG = 1.0
GOLDEN = 1.1127756842787055  # root of x^7 = x + 1


def even_numbers(count: int, seed: int) -> Floats:
    """Numbers (count, 6) between -1 and 1: the additive recurrence of the golden ratio in six dimensions.

    The seed shifts the whole set, which keeps it even (M. Roberts, "The unreasonable effectiveness of
    quasirandom sequences", 2018).
    """
    shift = np.random.default_rng(seed).uniform(size=6)
    steps = (1.0 / GOLDEN) ** np.arange(1, 7)
    out: Floats = 2.0 * ((shift + np.outer(np.arange(1, count + 1), steps)) % 1.0) - 1.0
    return out


def poses_in_range(
    seed_pose: Pose, camera: Camera, search_range: SearchRange, numbers: Floats
) -> tuple[Floats, Floats]:
    """Rotations (N, 3, 3) and translations (N, 3) for numbers (N, 6) in -1..1 of Rx Ry Rz Tx Ty Tz.

    R = R_seed·Rx·Ry·Rz, T = T_seed + reach · Z_seed / f (DESIGN.md §6).
    """
    angles = np.radians(search_range.rotation_deg) * numbers[:, :3]
    reach_m = search_range.translation_px * seed_pose.translation[2] / camera.fx
    rotations: Floats = _turned(seed_pose.matrix, np.ascontiguousarray(angles))
    return rotations, seed_pose.translation + reach_m * numbers[:, 3:]


def in_range(
    seed_pose: Pose, camera: Camera, search_range: SearchRange, rotations: Floats, translations: Floats
) -> NDArray[np.bool_]:
    """Which poses (N, 3, 3), (N, 3) lie in the search range, MARGIN included."""
    turn = seed_pose.matrix.T @ rotations
    angles = np.stack(
        [
            np.arctan2(-turn[:, 1, 2], turn[:, 2, 2]),
            np.arcsin(np.clip(turn[:, 0, 2], -1.0, 1.0)),
            np.arctan2(-turn[:, 0, 1], turn[:, 0, 0]),
        ],
        axis=1,
    )
    reach_m = search_range.translation_px * seed_pose.translation[2] / camera.fx
    turned = np.abs(angles) <= np.radians(search_range.rotation_deg * (1.0 + MARGIN) + MARGIN_DEG)
    moved = np.abs(translations - seed_pose.translation) <= reach_m * (1.0 + MARGIN)
    inside: NDArray[np.bool_] = turned.all(axis=1) & moved.all(axis=1)
    return inside


@njit(cache=True)
def _turned(rotation: Floats, angles: Floats) -> Floats:
    out = np.empty((len(angles), 3, 3))
    for i in range(len(angles)):
        out[i] = rotation @ euler_matrix(angles[i, 0], angles[i, 1], angles[i, 2])
    return out
