"""What every matcher takes and gives: segments, a model, a seed pose or what is known without; hypotheses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geometry.camera import Camera
from geometry.errors import GeometryError
from geometry.model import Model
from geometry.pose import SEARCH_ROTATION_DEG, SEARCH_TRANSLATION_PX, Pose
from numerics.arrays import Flags, Floats
from vision_server.matching.views import Views, longest_straight_m

SEEN_SIZE_SHARES = (0.02, 4.0)  # of the target, over the frame's smaller side: beyond, nothing is told apart
TOLD_VIEW_DEG = 50.0  # around a direction of view that is told; chosen by hand

# By hand: poses that are closer than so many degrees and that share of the range are one hypothesis, or have
# come to one place. Without the latter all that were kept were one pose of a plate with 76 prisms.
ONE_HYPOTHESIS, ONE_PLACE = (2.0, 0.01), (0.2, 0.001)
# Bounds of the shortest segment that is used, this share of the model's typical line in the image; of more
# than so many the longest are used (by hand: see `long_enough`).
LEAST_SEGMENT_PX, MOST_SEGMENT_PX, SEGMENT_SHARE, MOST_SEGMENTS = 7.0, 14.0, 0.1, 5000
WORTH_REFINING_SHARE = 0.5  # of the best score; right poses were seen down to 0.68 of a wrong one's


@dataclass(frozen=True)
class SearchRange:
    """How far the pose may be from the seed pose (docs/architecture.md).

    Attributes
    ----------
    rotation_deg : reach of each of Rx, Ry, Rz about the target's axes, degrees.
    translation_px : reach of each component of the translation, in pixels at the seed's depth.
    """

    rotation_deg: float = SEARCH_ROTATION_DEG
    translation_px: float = SEARCH_TRANSLATION_PX

    def __post_init__(self) -> None:
        for name, value, most in (
            ("rotation_deg", self.rotation_deg, 180.0),
            ("translation_px", self.translation_px, 1e5),
        ):
            if not 0 <= value <= most:
                raise GeometryError(f"search range {name} must be between 0 and {most:g}, got {value}")


@dataclass(frozen=True)
class Anywhere:
    """What is known of a target of which there is no seed pose.

    Attributes
    ----------
    range_m : least and greatest distance of its middle, metres; None: whatever lets it fit the frame.
    view : direction from its middle to the camera in its own frame, roughly; None: any.
    """

    range_m: tuple[float, float] | None = None
    view: tuple[float, float, float] | None = None

    def __post_init__(self) -> None:
        if self.range_m is not None and not 0.0 < self.range_m[0] <= self.range_m[1] < np.inf:
            raise GeometryError(f"range_m must be two distances, the lesser first, got {self.range_m}")
        if self.view is not None and not 0.0 < float(np.linalg.norm(self.view)) < np.inf:
            raise GeometryError(f"view must be a direction, got {self.view}")

    def sees(self, direction: Floats) -> Flags:
        """Whether the target may be seen from unit directions (..., 3) from its middle, in its frame."""
        if self.view is None:
            return np.ones(direction.shape[:-1], dtype=bool)
        towards = np.array(self.view) / np.linalg.norm(self.view)
        return np.asarray(direction @ towards >= np.cos(np.radians(TOLD_VIEW_DEG)))

    def allows(self, pose: Pose, middle: Floats) -> bool:
        """Whether a pose shows a target of this middle (3,), in its frame, from where it may be seen."""
        to_camera = -pose.matrix.T @ pose.translation - middle
        return bool(self.sees(to_camera / np.linalg.norm(to_camera)))


def sizes_from_px(range_m: tuple[float, float], diameter: float, camera: Camera) -> tuple[float, float]:
    """The largest and the least diameter in the image, px, of a target that is so near and so far, metres."""
    near, far = range_m
    return diameter * camera.fx / near, diameter * camera.fx / far


def seen_sizes_px(camera: Camera) -> tuple[float, float]:
    """The least and the largest diameter in the image, px, of a target that can be told from others."""
    side = min(camera.width, camera.height)
    return SEEN_SIZE_SHARES[0] * side, SEEN_SIZE_SHARES[1] * side


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """One pose that explains the segments.

    Attributes
    ----------
    pose : camera_T_target.
    score : higher is better; comparable between hypotheses of the same matcher and image set only.
    supported : fraction of the visible image length of the model's lines that has an image edge near it.
    """

    pose: Pose
    score: float
    supported: float


def at_scale(segments: Floats, camera: Camera, factor: float) -> tuple[Floats, Camera]:
    """Segments (N, 4) px and camera of the image that is so many times as wide and high."""
    if factor == 1.0:
        return segments, camera
    return np.ascontiguousarray((segments + 0.5) * factor - 0.5), camera.scaled(factor)


def checked_segments(segments: Floats) -> Floats:
    """Segments (N, 4) [x1, y1, x2, y2] px as float64.

    Raises
    ------
    GeometryError : a wrong shape, NaN or infinity.
    """
    segments = np.ascontiguousarray(segments, dtype=np.float64)
    if segments.size == 0:
        segments = segments.reshape(0, 4)
    if segments.ndim != 2 or segments.shape[1] != 4:
        raise GeometryError(f"segments must have shape (N, 4), got {segments.shape}")
    if not np.isfinite(segments).all():
        raise GeometryError("segments must be finite")
    return segments


def ideal_segments(segments: Floats, camera: Camera) -> Floats:
    """Segments (N, 4), px, as a camera without distortion sees them."""
    if camera.distorted and len(segments):
        return np.ascontiguousarray(camera.undistort_points(segments.reshape(-1, 2)).reshape(-1, 4))
    return segments


def must_be_in_front(seed_pose: Pose) -> None:
    """Raise GeometryError when a search around a seed pose makes no sense."""
    if not seed_pose.translation[2] > 0:
        raise GeometryError(
            f"the seed pose puts the target behind the camera (z = {seed_pose.translation[2]:g} m); "
            "give a seed pose with positive z"
        )


@dataclass(frozen=True, eq=False)
class Problem:
    """What a matcher works on: the segments worth matching, and the model as seen from around the seed.

    Attributes
    ----------
    segments : (N, 4) float64, [x1, y1, x2, y2] in ideal px; may be empty.
    views : visible samples by direction.
    camera : without distortion.
    """

    segments: Floats
    views: Views
    camera: Camera


def matching_problem(
    segments: Floats, model: Model, camera: Camera, seed_pose: Pose, reach_m: float, spacing_px: float
) -> Problem:
    """Check what a matcher was given, and choose the segments.

    Parameters
    ----------
    segments : (N, 4) float64, [x1, y1, x2, y2] in ideal px.
    reach_m : how much nearer than the seed pose the target may be, see `draws.reach_m`.
    spacing_px : between the samples of the model's lines.

    Raises
    ------
    GeometryError : malformed segments, a seed pose behind the camera.
    """
    segments = checked_segments(segments)
    must_be_in_front(seed_pose)
    views = Views(model, camera.ideal, seed_pose, spacing_px)
    chosen = long_enough(segments, views.typical_line_px(seed_pose))
    chosen &= short_enough(segments, model, camera, seed_pose, reach_m)
    return Problem(segments[chosen], views, camera.ideal)


def long_enough(segments: Floats, typical_line_px: float, least_px: float = LEAST_SEGMENT_PX) -> Flags:
    """Which segments (N, 4) are worth matching with a model whose typical line is that long in the image.

    Neither all segments nor only the long ones do best: short ones are clutter, but a small target has only
    short ones. None is shorter than ``least_px``.
    """
    length = np.hypot(segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1])
    shortest = min(max(SEGMENT_SHARE * typical_line_px, least_px), MOST_SEGMENT_PX)
    if len(length) > MOST_SEGMENTS:
        shortest = max(shortest, float(np.partition(length, -MOST_SEGMENTS)[-MOST_SEGMENTS]))
    out: Flags = length >= shortest
    return out


def short_enough(segments: Floats, model: Model, camera: Camera, seed_pose: Pose, reach_m: float) -> Flags:
    """Which segments (N, 4) are no longer than any line of the model can look, up to so much nearer.

    What is longer, as the lines of a wall behind the target, is clutter, and pulls poses to it.
    """
    nearest = seed_pose.apply(model.middle[None])[0, 2] - reach_m - 0.5 * model.diameter
    if nearest <= 0.0:
        return np.ones(len(segments), dtype=bool)
    longest_px = longest_straight_m(model) * max(camera.fx, camera.fy) / nearest
    length = np.hypot(segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1])
    out: Flags = length <= longest_px
    return out


def distinct(
    rotations: Floats,
    translations: Floats,
    scores: Floats,
    count: int,
    limits: tuple[float, float] = ONE_HYPOTHESIS,
) -> list[int]:
    """Indices of the `count` best of poses (N, 3, 3), (N, 3) by scores (N,), none as a better one is.

    ``limits`` in degrees and as a share of the range.
    """
    kept: list[int] = []
    least_trace = 1.0 + 2.0 * np.cos(np.radians(limits[0]))  # of the turn from one to the other
    flat, near = rotations.reshape(-1, 9), limits[1] * np.linalg.norm(translations, axis=1)
    for i in np.argsort(-scores, kind="stable").tolist():
        if len(kept) == count or scores[i] == -np.inf:
            break
        apart = np.linalg.norm(translations[kept] - translations[i], axis=1)
        if not ((flat[kept] @ flat[i] >= least_trace) & (apart <= near[kept])).any():
            kept.append(i)
    return kept


def worth_refining(found: list[Hypothesis]) -> list[Pose]:
    """Those that come near the best one's score; costs (negative scores) are not comparable so far."""
    best = max((one.score for one in found), default=0.0)
    return [one.pose for one in found if best <= 0.0 or one.score >= WORTH_REFINING_SHARE * best]
