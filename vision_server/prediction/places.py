"""Places of a target in its image, what Lambert's law says of light there, and what images show there.

All images are brought to the blur of the least sharp one: then light adds up beside edges, too.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from vision_server.prediction.response import LitImage, lambert, towards_camera

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Field = NDArray[np.float32]

# Chosen by hand.
SMALLER = 4  # images are looked at in a fourth of their size,
LEAST_BLUR_PX = 2.0  # blurred by so much more than the least sharp one
MOST_PLACES = 16  # a question takes half as long again with 20
READING_SHARE, READING_FLOOR = 0.015, 0.003  # standard deviation of a reading: of it, of full scale
UNEVEN_SHARE = 0.1  # and of how brightness varies around: images are not blurred as measured
CLIPPED = 0.93  # brighter pixels say "at least";
MOST_CLIPPED = 0.005  # a place with this share of them is not read
ON_TARGET = 0.5  # share of what is seen at a place that is of the target


class Places(NamedTuple):
    """P places on a target.

    Attributes
    ----------
    at
        (P, 2) px in images of a fourth of the size.
    normal
        (P, 3) of the surface there, towards the camera; (0, 0, 0) where that is not known.
    shape
        (P, 1 + L): what sun and lights are expected to give, as shares of a light's mean.
    located
        (L,): the lights of which the position is known.
    """

    at: NDArray[np.int64]
    normal: Floats
    shape: Floats
    located: Flags


class Readings(NamedTuple):
    """K images at P places, (K, P): brightness at exposure 1, its standard deviation, whether it is known."""

    value: Floats
    sd: Floats
    known: Flags


def read(
    model: Model, camera: Camera, pose: Pose, positions: Sequence[Floats | None], images: Sequence[LitImage]
) -> tuple[Places, Readings]:
    """Places, perhaps none, that few images show too bright, and what the images, not none, show there.

    ``positions`` are (3,) m in the camera's frame, or None where one is not known.
    """
    blur = np.array([image.blur_px for image in images])
    common = float(blur.max()) + LEAST_BLUR_PX
    face = _faces_seen(model, camera, pose)
    inside = cv2.GaussianBlur((face >= 0).astype(np.float32), (0, 0), common / SMALLER)
    rows, columns = np.nonzero((face >= 0) & (inside > ON_TARGET))
    looks = [
        _look(image, math.sqrt(common**2 - own**2)) for image, own in zip(images, blur.tolist(), strict=True)
    ]
    value, uneven, clipped = (np.array([look[part][rows, columns] for look in looks]) for part in range(3))
    chosen = _spread(clipped > MOST_CLIPPED, face[rows, columns])
    rows, columns = rows[chosen], columns[chosen]
    value, uneven, lost = value[:, chosen], uneven[:, chosen], clipped[:, chosen] > MOST_CLIPPED
    exposure = np.array([image.exposure for image in images])[:, None]
    sd = np.sqrt((READING_SHARE * value) ** 2 + READING_FLOOR**2 + (UNEVEN_SHARE * uneven) ** 2)
    places = _described(model, pose, positions, face, (rows, columns), common)
    return places, Readings(value / exposure, sd / exposure, ~lost)


def _look(image: LitImage, sigma_px: float) -> tuple[Floats, Floats, Floats]:
    """A smaller image, blurred; how uneven it is there; the share of it that is clipped."""
    over = (image.linear > CLIPPED).astype(np.float32)
    seen, over = (_smaller(part, sigma_px) for part in (image.linear, over))
    around = cv2.blur(seen, (3, 3))
    uneven = np.sqrt(np.maximum(cv2.blur(seen * seen, (3, 3)) - around * around, 0.0))
    return seen.astype(np.float64), uneven.astype(np.float64), over.astype(np.float64)


def _smaller(image: Field, sigma_px: float) -> Field:
    small = cv2.resize(image, None, fx=1 / SMALLER, fy=1 / SMALLER, interpolation=cv2.INTER_AREA)
    return np.asarray(cv2.GaussianBlur(small, (0, 0), sigma_px / SMALLER), dtype=np.float32)


def _faces_seen(model: Model, camera: Camera, pose: Pose) -> NDArray[np.int32]:
    """The face in front at each place of a smaller image, -1 for none; 0 inside a target without faces."""
    size = (round(camera.height / SMALLER), round(camera.width / SMALLER))
    out = np.full(size, -1, dtype=np.int32)
    points = pose.apply(model.vertices)
    if (points[:, 2] <= 0.0).any():
        return out
    corners = np.rint((camera.project(points) + 0.5) / SMALLER - 0.5).astype(np.int32)
    if not model.faces:
        cv2.fillConvexPoly(out, cv2.convexHull(corners), 0)
        return out
    depth = np.array([points[polygon].mean(axis=0) @ points[polygon].mean(axis=0) for polygon in model.faces])
    normals = model.face_normals @ pose.matrix.T
    for face in np.argsort(-depth).tolist():
        polygon = model.faces[face]
        if model.two_sided[face] or normals[face] @ points[polygon[0]] < 0.0:
            cv2.fillPoly(out, [corners[polygon]], face)
    return out


def _spread(lost: Flags, face: NDArray[np.int32]) -> NDArray[np.int64]:
    """Which places to read: of those that are lost in fewest images, evenly over faces."""
    order = np.argsort(lost.sum(axis=0), kind="stable")[: max(MOST_PLACES, len(face) // 2)]
    order = order[np.argsort(face[order], kind="stable")]
    return np.asarray(order[np.linspace(0, len(order) - 1, min(MOST_PLACES, len(order))).astype(np.int64)])


def _described(
    model: Model,
    pose: Pose,
    positions: Sequence[Floats | None],
    face: NDArray[np.int32],
    at: tuple[NDArray[np.int64], NDArray[np.int64]],
    blur_px: float,
) -> Places:
    located = np.array([place is not None and bool(model.faces) for place in positions], dtype=np.bool_)
    shape = np.ones((len(at[0]), 1 + len(positions)))
    normal = np.zeros((len(at[0]), 3))
    if model.faces:
        middles = pose.apply(np.array([model.vertices[polygon].mean(axis=0) for polygon in model.faces]))
        normals = towards_camera(model.face_normals @ pose.matrix.T, middles)
        normal = normals[face[at]]
        lit = [lambert(middles, normals, place) for place in positions if place is not None]
        unit = float(np.mean([part[face[at]] for part in lit])) if lit and len(at[0]) else 0.0
        known = np.flatnonzero(located)
        for light, part in zip(known.tolist(), lit if unit > 0.0 else (), strict=unit > 0.0):
            picture = np.where(face >= 0, part[face] / unit, 0.0).astype(np.float32)
            shape[:, 1 + light] = cv2.GaussianBlur(picture, (0, 0), blur_px / SMALLER)[at]
    return Places(np.stack(at, axis=1), normal, shape, located)
