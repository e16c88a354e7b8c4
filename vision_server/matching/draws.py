"""Poses of the search range from numbers between -1 and 1, and numbers that fill it evenly."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera
from geometry.pose import Pose
from geometry.rotation import euler_matrices
from vision_server.matching.match import SearchRange

Floats = NDArray[np.float64]

# Chosen by hand where nothing else is said.
MARGIN = 0.1  # of the search range; a true pose at its border must not be lost to noise
MARGIN_DEG, MARGIN_PX = 3.0, 6.0  # for narrow ranges: what edges may pull a pose by
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

    R = R_seed·Rx·Ry·Rz, T = T_seed + reach · Z_seed / f (docs/architecture.md).
    """
    angles = np.radians(search_range.rotation_deg) * numbers[:, :3]
    reach_m = search_range.translation_px * seed_pose.translation[2] / camera.fx
    rotations: Floats = seed_pose.matrix @ euler_matrices(angles)
    return rotations, seed_pose.translation + reach_m * numbers[:, 3:]


def poses_around(
    seed_pose: Pose, camera: Camera, search_range: SearchRange, numbers: Floats
) -> tuple[Floats, Floats]:
    """Like `poses_in_range`, for a seed pose that was itself drawn around the true pose.

    The way back from such a draw turns by the inverse, Rz·Ry·Rx, which has other limits; so every second pose
    is drawn like that.
    """
    rotations, translations = poses_in_range(seed_pose, camera, search_range, numbers)
    seed = seed_pose.matrix
    rotations[1::2] = seed @ (seed.T @ rotations[1::2]).transpose(0, 2, 1)
    return rotations, translations


def in_range(
    seed_pose: Pose, camera: Camera, search_range: SearchRange, rotations: Floats, translations: Floats
) -> NDArray[np.bool_]:
    """Which poses (N, 3, 3), (N, 3) lie in the range that `poses_around` fills, MARGIN included."""
    turn = seed_pose.matrix.T @ rotations
    limit = np.radians(search_range.rotation_deg * (1.0 + MARGIN) + MARGIN_DEG)
    reach_px = search_range.translation_px * (1.0 + MARGIN) + MARGIN_PX
    reach_m = reach_px * seed_pose.translation[2] / camera.fx
    turned = np.minimum(_largest_angle(turn), _largest_angle(turn.transpose(0, 2, 1))) <= limit
    moved = np.abs(translations - seed_pose.translation) <= reach_m
    inside: NDArray[np.bool_] = turned & moved.all(axis=1)
    return inside


def in_range_of(seed_pose: Pose, camera: Camera, search_range: SearchRange) -> Callable[[Pose], bool]:
    """Whether a pose is `in_range`."""

    def within(pose: Pose) -> bool:
        return bool(in_range(seed_pose, camera, search_range, pose.matrix[None], pose.translation[None])[0])

    return within


def turned_beyond(seed_pose: Pose, search_range: SearchRange) -> Callable[[Pose], float]:
    """How far a pose is turned beyond the range that a seed pose may be off: 1 is all of the margin.

    0 within the range.
    """
    margin_deg = MARGIN * search_range.rotation_deg + MARGIN_DEG

    def beyond(pose: Pose) -> float:
        turn = (seed_pose.matrix.T @ pose.matrix)[None]
        angle = np.minimum(_largest_angle(turn), _largest_angle(turn.transpose(0, 2, 1)))
        return max(0.0, (float(np.degrees(angle[0])) - search_range.rotation_deg) / margin_deg)

    return beyond


def _largest_angle(turn: Floats) -> Floats:
    """Largest of the angles of Rx·Ry·Rz, (N, 3, 3) to (N,), rad."""
    angles = [
        np.arctan2(-turn[:, 1, 2], turn[:, 2, 2]),
        np.arcsin(np.clip(turn[:, 0, 2], -1.0, 1.0)),
        np.arctan2(-turn[:, 0, 1], turn[:, 0, 0]),
    ]
    out: Floats = np.abs(np.stack(angles)).max(axis=0)
    return out
