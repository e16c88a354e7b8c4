"""Poses around a seed pose from numbers that fill -1 to 1 evenly, and how far a pose is beyond the range."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from geometry.camera import Camera
from geometry.pose import Pose
from geometry.rotation import euler_matrices
from numerics.arrays import Flags, Floats
from vision_server.matching.match import SearchRange

# By hand, beyond the search range, as a true pose at its border must not be lost to noise: a share of it, and
# what edges may pull a pose by in narrow ones.
MARGIN_SHARE, MARGIN_DEG, MARGIN_PX = 0.1, 3.0, 6.0
GOLDEN_RATIO_7 = 1.1127756842787055  # root of x^7 = x + 1


def even_numbers(count: int, seed: int) -> Floats:
    """Numbers (count, 6) between -1 and 1: the additive recurrence of the golden ratio in six dimensions.

    The seed shifts the whole set, which keeps it even (M. Roberts, "The unreasonable effectiveness of
    quasirandom sequences", 2018).
    """
    shift = np.random.default_rng(seed).uniform(size=6)
    steps = (1.0 / GOLDEN_RATIO_7) ** np.arange(1, 7)
    out: Floats = 2.0 * ((shift + np.outer(np.arange(1, count + 1), steps)) % 1.0) - 1.0
    return out


def poses_in_range(
    seed_pose: Pose, camera: Camera, search_range: SearchRange, numbers: Floats
) -> tuple[Floats, Floats]:
    """Rotations (N, 3, 3) and translations (N, 3) for numbers (N, 6) in -1..1 of Rx Ry Rz Tx Ty Tz.

    R = R_seed·Rx·Ry·Rz, T = T_seed + reach · Z_seed / f (docs/architecture.md).
    """
    angles = np.radians(search_range.rotation_deg) * numbers[:, :3]
    rotations: Floats = seed_pose.matrix @ euler_matrices(angles)
    return rotations, seed_pose.translation + reach_m(seed_pose, camera, search_range) * numbers[:, 3:]


def reach_m(seed_pose: Pose, camera: Camera, search_range: SearchRange) -> float:
    """How far the range reaches along each axis of the camera, m."""
    return float(search_range.translation_px * seed_pose.translation[2] / camera.fx)


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


def beyond(
    seed_pose: Pose, camera: Camera, search_range: SearchRange, rotations: Floats, translations: Floats
) -> Floats:
    """How far poses (N, 3, 3), (N, 3) lie beyond the range that a seed pose may be off, (N,).

    0 at its border, 1 where its margin ends, less than 0 within; of turn and place what is more.
    """
    turn = seed_pose.matrix.T @ rotations
    turned_deg = np.degrees(np.minimum(_largest_angle(turn), _largest_angle(turn.transpose(0, 2, 1))))
    moved_m = np.abs(translations - seed_pose.translation).max(axis=1)
    moved_px = moved_m * camera.fx / seed_pose.translation[2]
    most_deg, most_px = search_range.rotation_deg, search_range.translation_px
    turned = (turned_deg - most_deg) / (MARGIN_SHARE * most_deg + MARGIN_DEG)
    moved = (moved_px - most_px) / (MARGIN_SHARE * most_px + MARGIN_PX)
    return np.asarray(np.maximum(turned, moved))


def in_range(
    seed_pose: Pose, camera: Camera, search_range: SearchRange, rotations: Floats, translations: Floats
) -> Flags:
    """Which poses (N, 3, 3), (N, 3) lie in the range that `poses_around` fills, its margin included."""
    return np.asarray(beyond(seed_pose, camera, search_range, rotations, translations) <= 1.0)


def beyond_of(seed_pose: Pose, camera: Camera, search_range: SearchRange) -> Callable[[Pose], float]:
    """How far a pose lies `beyond` the range."""

    def one(pose: Pose) -> float:
        there = pose.matrix[None], pose.translation[None]
        return float(beyond(seed_pose, camera, search_range, *there)[0])

    return one


def in_range_of(seed_pose: Pose, camera: Camera, search_range: SearchRange) -> Callable[[Pose], bool]:
    """Whether a pose is `in_range`."""
    far = beyond_of(seed_pose, camera, search_range)
    return lambda pose: far(pose) <= 1.0


def _largest_angle(turn: Floats) -> Floats:
    """Largest of the angles of Rx·Ry·Rz, (N, 3, 3) to (N,), rad."""
    angles = [
        np.arctan2(-turn[:, 1, 2], turn[:, 2, 2]),
        np.arcsin(np.clip(turn[:, 0, 2], -1.0, 1.0)),
        np.arctan2(-turn[:, 0, 1], turn[:, 0, 0]),
    ]
    out: Floats = np.abs(np.stack(angles)).max(axis=0)
    return out
