"""The pose that pairs of points tell: perspective-n-point, refined through the lens.

Where several poses fit, the image says which.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from bridge.errors import BadInput
from geometry.camera import Camera
from geometry.errors import GeometryError
from geometry.model import Model
from geometry.pose import Pose
from geometry.visibility import visible_samples
from numerics.arrays import Floats
from vision_server.seeding.pairs import Pairs, must_tell_a_pose, wide_triple

# Chosen by hand where nothing else is said.
CLICK_PX = 2.0  # what a click is off by: poses that fit the points within it of the best fit as well
SAME = (1.0, 0.01)  # degrees, share of the range: poses nearer to each other are one
ON_LINE_PX = 3.0  # a point that is so near to a visible line is seen; chosen by hand
BLUR_PX = 1.5  # of the image whose edges are compared with the lines
BEHIND_PX = 1e4  # error of a point behind the camera: no step goes there
POOR_FIT = 0.01  # of the image's diagonal: RMS errors beyond are those of a wrong pair
MOST_DOUBTED = 20  # pairs, those farthest off, each of which is left out in turn


@dataclass(frozen=True, eq=False)
class PointsPose:
    """What pairs of points tell.

    Attributes
    ----------
    pose : camera_T_target.
    errors_px : (N,) float64, how far each point is from where the pose puts it.
    others : poses that fit the points as well.
    """

    pose: Pose
    errors_px: Floats
    others: tuple[Pose, ...]

    @property
    def rms_px(self) -> float:
        """RMS of the errors, px."""
        return float(np.sqrt(np.mean(self.errors_px**2)))


def pose_of_points(pairs: Pairs, model: Model, camera: Camera, grey: NDArray[Any]) -> PointsPose:
    """Pose of the least RMS error; of several that fit within a click, the one whose lines the image shows.

    Starts are P3P of three points far apart (Gao et al. 2003, as OpenCV has it) and, from four on, SQPnP
    (Terzakis and Lourakis 2020); each is refined by Levenberg and Marquardt.

    Parameters
    ----------
    grey : (H, W), the image, 0 to 255.

    Raises
    ------
    BadInput
        Pairs that tell no pose, see `must_tell_a_pose`, or that no pose puts in front of the camera.
    """
    must_tell_a_pose(pairs, model, camera)
    fits = _fits(pairs, camera)
    if not fits:
        raise BadInput("No pose puts these points in front of the camera.", "Is a pair wrong?")
    as_good: list[PointsPose] = []
    for one in fits:
        near = any(one.pose.error_to(other.pose).within(*SAME) for other in as_good)
        if one.rms_px <= fits[0].rms_px + CLICK_PX and not near:
            as_good.append(one)
    if len(as_good) > 1:
        slopes = _slopes(grey)
        as_good.sort(key=lambda one: _shown(one.pose, pairs, model, camera, slopes), reverse=True)
    first, *others = as_good
    return PointsPose(first.pose, first.errors_px, tuple(one.pose for one in others))


def is_poor(found: PointsPose, camera: Camera) -> bool:
    """Whether the errors are more than those of clicks."""
    return found.rms_px > POOR_FIT * math.hypot(camera.width, camera.height)


def wrong_pair(found: PointsPose, pairs: Pairs, model: Model, camera: Camera) -> str | None:
    """Which pair is wrong, in words, where the errors are more than those of clicks; else None.

    It is the pair without which the others fit: a wrong one draws the pose towards itself, so that right ones
    may be farther off. Of four, any three fit at some pose: then the one that is farthest off is asked about.
    """
    if not is_poor(found, camera):
        return None
    worst = np.argsort(-found.errors_px)[:MOST_DOUBTED].tolist()
    without: list[tuple[float, int]] = []
    for number in worst if len(pairs.points) > 4 else []:
        others = np.arange(len(pairs.points)) != number
        rest = Pairs(pairs.pixels[others], pairs.points[others])
        with suppress(BadInput):
            must_tell_a_pose(rest, model, camera)
            without += [(one.rms_px, number) for one in _fits(rest, camera)[:1] if not is_poor(one, camera)]
    much = f"{found.rms_px:.1f} px RMS is much: "
    if not without:
        return f"{much}is pair {worst[0] + 1} wrong, which is {found.errors_px[worst[0]]:.1f} px off?"
    rms_px, number = min(without)
    return f"{much}without pair {number + 1} the others fit to {rms_px:.1f} px. Correct it, or leave it out."


def _fits(pairs: Pairs, camera: Camera) -> list[PointsPose]:
    """Poses that refinement ends at, those of the least RMS error first."""
    refined = [_refined(start, pairs, camera) for start in _starts(pairs, camera)]
    found = [PointsPose(pose, _errors_px(pose, pairs, camera), ()) for pose in refined]
    return sorted((one for one in found if np.isfinite(one.errors_px).all()), key=lambda one: one.rms_px)


def _starts(pairs: Pairs, camera: Camera) -> Iterator[Pose]:
    """Poses, some of them perhaps with points behind the camera."""
    rays = (camera.undistort_points(pairs.pixels) - [camera.cx, camera.cy]) / [camera.fx, camera.fy]
    three = list(wide_triple(pairs.points))
    found: list[Any] = [cv2.solveP3P(pairs.points[three], rays[three], np.eye(3), None, cv2.SOLVEPNP_P3P)]
    if len(rays) > 3:
        found.append(cv2.solvePnPGeneric(pairs.points, rays, np.eye(3), None, flags=cv2.SOLVEPNP_SQPNP))
    for _, rotations, translations, *_ in found:
        for rotation, translation in zip(rotations, translations, strict=True):
            with suppress(GeometryError):  # not finite
                yield Pose(rotation.ravel(), translation.ravel())


def _errors_px(pose: Pose, pairs: Pairs, camera: Camera) -> Floats:
    """Distances (N,) of the points from where a pose puts them, px; NaN for a point behind the camera."""
    return np.asarray(np.linalg.norm(camera.project(pose.apply(pairs.points)) - pairs.pixels, axis=1))


def _refined(start: Pose, pairs: Pairs, camera: Camera) -> Pose:
    """The pose of the least square error near a start, through the lens."""
    reach = max(float(np.linalg.norm(start.translation)), np.finfo(float).tiny)
    scale = np.array([1.0, 1.0, 1.0, reach, reach, reach])

    def errors(step: Floats) -> Floats:
        seen = camera.project(start.stepped(scale * step).apply(pairs.points))
        return np.nan_to_num(seen - pairs.pixels, nan=BEHIND_PX, posinf=BEHIND_PX, neginf=-BEHIND_PX).ravel()

    return start.stepped(scale * least_squares(errors, np.zeros(6), method="lm").x)


def _slopes(grey: NDArray[Any]) -> tuple[Any, Any]:
    """The image's gradient along x and y, each (H, W)."""
    smooth = cv2.GaussianBlur(np.asarray(grey, dtype=np.float32), (0, 0), BLUR_PX)
    return cv2.Sobel(smooth, cv2.CV_32F, 1, 0), cv2.Sobel(smooth, cv2.CV_32F, 0, 1)


def _shown(
    pose: Pose, pairs: Pairs, model: Model, camera: Camera, slopes: tuple[Any, Any]
) -> tuple[int, float]:
    """How many of the points a pose leaves visible, then the mean slope of the image across its lines."""
    try:
        lines = visible_samples(model, camera, pose)
    except GeometryError:
        return 0, 0.0
    if len(lines.image) == 0:
        return 0, 0.0
    apart = np.linalg.norm(pairs.pixels[:, None] - lines.image[None], axis=2).min(axis=1)
    x, y = lines.image.T.astype(np.float32).reshape(2, 1, -1)
    across = [cv2.remap(slope, x, y, cv2.INTER_LINEAR)[0] for slope in slopes]
    slope = np.abs(across[0] * lines.normal[:, 0] + across[1] * lines.normal[:, 1])
    return int((apart < ON_LINE_PX).sum()), float(slope.mean())
