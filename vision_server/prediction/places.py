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
from geometry.faces_in_front import faces_in_front
from geometry.model import Model
from geometry.pose import Pose
from numerics.arrays import Field, Flags, Floats, Ints
from vision_server.prediction.response import LitImage, lambert, towards_camera

# Chosen by hand.
SMALLER = 4  # images are looked at in a fourth of their size,
LEAST_BLUR_PX = 2.0  # blurred by so much more than the least sharp one
MOST_PLACES = 16  # a question takes half as long again with 20
READING_SHARE, READING_FLOOR = 0.004, 0.001  # standard deviation of a reading: of it, of full scale
EXPOSED_SHARE = 0.015  # of it, alike in images of one shutter and aperture,
UNEVEN_SHARE = 0.1  # and of how brightness varies around: images are not blurred as measured
SAME_BLUR_PX = 0.5  # images of one exposure whose blur differs by less are of one aperture and shutter
OTHER_LIGHTS = 0.8  # correlation of that, where their lights differ
CLIPPED = 0.93  # brighter pixels say "at least";
MOST_CLIPPED = 0.005  # a place with this share of them is not read
OFF_SURFACE = 0.01  # of the way to a light: nearer faces are the place's own
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

    at: Ints
    normal: Floats
    shape: Floats
    located: Flags


class Readings(NamedTuple):
    """What K images show at P places.

    Attributes
    ----------
    value, sd, known
        (K, P): brightness at exposure 1, its standard deviation, whether it is known.
    least
        (K, P): of what is clipped, the brightness that it has at least; 0 of all else.
    shared, alike
        Share (K, P) of the variance that is the image's exposure's or blur's, and how far (K, K) that goes
        together in two images: light adds up between images of one shutter and aperture whatever their blur.
    most
        (K,): brightness from which on an image is clipped.
    """

    value: Floats
    sd: Floats
    known: Flags
    least: Floats
    shared: Floats
    alike: Floats
    most: Floats

    def last(self, images: int) -> Readings:
        """Of so many of the last images."""
        of = slice(-images, None)
        return Readings(
            self.value[of],
            self.sd[of],
            self.known[of],
            self.least[of],
            self.shared[of],
            self.alike[of, of],
            self.most[of],
        )

    def correlation(self, use: Ints) -> Floats:
        """How errors of the readings with these numbers (n,) in a flat list go together, (n, n)."""
        image, place = np.unravel_index(use, self.value.shape)
        root = np.sqrt(self.shared.ravel()[use])
        both = self.alike[np.ix_(image, image)] * (place[:, None] == place[None]) * np.outer(root, root)
        return np.asarray(both + np.diag(1.0 - root**2))


def read(
    model: Model, camera: Camera, pose: Pose, positions: Sequence[Floats | None], images: Sequence[LitImage]
) -> tuple[Places, Readings]:
    """Places, perhaps none, that images show well, and what the images, not none, show there.

    ``positions`` are (3,) m in the camera's frame, or None where one is not known.
    """
    blur = np.array([image.blur_px for image in images])
    common = float(blur.max()) + LEAST_BLUR_PX
    face = faces_seen(model, camera, pose)
    inside = cv2.GaussianBlur((face >= 0).astype(np.float32), (0, 0), common / SMALLER)
    rows, columns = np.nonzero((face >= 0) & (inside > ON_TARGET))
    looks = [
        _look(image, math.sqrt(common**2 - own**2)) for image, own in zip(images, blur.tolist(), strict=True)
    ]
    value, uneven, clipped = (np.array([look[part][rows, columns] for look in looks]) for part in range(3))
    own = (READING_SHARE * value) ** 2 + READING_FLOOR**2
    sd = np.sqrt(own + (EXPOSED_SHARE * value) ** 2 + (UNEVEN_SHARE * uneven) ** 2)
    known = clipped <= MOST_CLIPPED
    chosen = _spread(known.sum(axis=0), (known * (value / sd) ** 2).sum(axis=0), face[rows, columns])
    exposure = np.array([image.exposure for image in images])[:, None]
    places = _described(model, camera, pose, positions, face, (rows[chosen], columns[chosen]), common)
    value, sd, own, known = value[:, chosen], sd[:, chosen], own[:, chosen], known[:, chosen]
    value, sd, shared = value / exposure, sd / exposure, 1.0 - own / sd**2
    least = np.where(known, 0.0, value)
    return places, Readings(value, sd, known, least, shared, _alike(images), CLIPPED / exposure[:, 0])


def _alike(images: Sequence[LitImage]) -> Floats:
    """How far errors of exposure and blur go together in two images, (K, K)."""
    first = list[int]()  # of each image, the first one of its shutter and aperture
    for image in images:
        of_one = (
            k
            for k in first
            if math.isclose(images[k].exposure, image.exposure, rel_tol=1e-5)
            and abs(images[k].blur_px - image.blur_px) < SAME_BLUR_PX
        )
        first.append(next(of_one, len(first)))
    lights = np.array([image.lights for image in images])
    same = np.isclose(lights[:, None], lights[None]).all(axis=2)
    return np.equal.outer(first, first) * np.where(same, 1.0, OTHER_LIGHTS)


def _look(image: LitImage, sigma_px: float) -> tuple[Floats, Floats, Floats]:
    """A smaller image, blurred; how uneven it is there; the share of it that is clipped."""
    over = (image.linear > CLIPPED).astype(np.float32)
    seen, over = (smaller(part, sigma_px) for part in (image.linear, over))
    around = cv2.blur(seen, (3, 3))
    uneven = np.sqrt(np.maximum(cv2.blur(seen * seen, (3, 3)) - around * around, 0.0))
    return seen.astype(np.float64), uneven.astype(np.float64), over.astype(np.float64)


def shrunk(image: Field) -> Field:
    """An image (H, W) in a fourth of its size."""
    small = cv2.resize(image, None, fx=1 / SMALLER, fy=1 / SMALLER, interpolation=cv2.INTER_AREA)
    return np.asarray(small, dtype=np.float32)


def smaller(image: Field, sigma_px: float) -> Field:
    """An image (H, W) in a fourth of its size, blurred by so many of its own pixels."""
    return np.asarray(cv2.GaussianBlur(shrunk(image), (0, 0), sigma_px / SMALLER), dtype=np.float32)


def faces_seen(model: Model, camera: Camera, pose: Pose) -> NDArray[np.int32]:
    """The face in front at each place of a smaller image, -1 for none; 0 inside a target without faces."""
    size = (round(camera.height / SMALLER), round(camera.width / SMALLER))
    out = np.full(size, -1, dtype=np.int32)
    points = pose.apply(model.vertices)
    if (points[:, 2] <= 0.0).any():
        return out
    corners = (camera.project(points) + 0.5) / SMALLER - 0.5
    if not model.faces:
        cv2.fillConvexPoly(out, cv2.convexHull(np.rint(corners).astype(np.int32)), 0)
        return out
    first = points[[polygon[0] for polygon in model.faces]]
    shown = model.two_sided | (((model.face_normals @ pose.matrix.T) * first).sum(axis=1) < 0.0)
    front = faces_in_front(*size, corners, 1.0 / points[:, 2], model.triangles, model.triangle_face, shown)
    return np.asarray(front)


def _spread(seen: Floats, told: Floats, face: NDArray[np.int32]) -> Ints:
    """Which places to read, evenly over faces: half of those that most images show, half of the best shown.

    The first are rather dark, where lights show beside a sun; the others are in the sun.
    """
    chosen = np.zeros(0, dtype=np.int64)
    for worth in (seen, told):
        order = np.argsort(-worth, kind="stable")
        order = order[~np.isin(order, chosen)][: max(MOST_PLACES // 2, len(face) // 2)]
        order = order[np.argsort(face[order], kind="stable")]
        at = np.linspace(0, len(order) - 1, min(MOST_PLACES // 2, len(order))).astype(np.int64)
        chosen = np.concatenate([chosen, order[at]])
    return chosen


def _points(
    camera: Camera,
    at: tuple[Ints, Ints],
    middles: Floats,
    normal: Floats,
    blur_px: float,
) -> Floats:
    """Points of the target (5, P, 3) whose light a place shows: at it, and beside it by its blur."""
    aside = np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]])[:, None] * blur_px
    pixels = (np.stack(at[::-1], axis=1) + 0.5) * SMALLER - 0.5 + aside
    flat = pixels.reshape(-1, 2)
    straight = (camera.undistort_points(flat) - [camera.cx, camera.cy]) / [camera.fx, camera.fy]
    rays = np.column_stack([straight, np.ones(len(flat))]).reshape(*pixels.shape[:2], 3)
    depth = (normal * middles).sum(axis=1) / np.minimum((rays * normal).sum(axis=2), -1e-3)
    return np.asarray(rays * depth[..., None])


def _reached(points: Floats, light: Floats, corners: Floats) -> Floats:
    """Share (P,) of points (S, P, 3) that triangles (T, 3, 3) do not keep a light (3,) from.

    T. Moeller and B. Trumbore, Fast, minimum storage ray/triangle intersection, 1997.
    """
    origin = points.reshape(-1, 1, 3)
    towards = light - origin
    one, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    across = np.cross(towards, other)
    scale = (across * one).sum(axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        away = origin - corners[:, 0]
        u = (away * across).sum(axis=-1) / scale
        turned = np.cross(away, one)
        v = (towards * turned).sum(axis=-1) / scale
        t = (other * turned).sum(axis=-1) / scale
        hit = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (t > OFF_SURFACE) & (t < 1.0)
    return np.asarray(1.0 - hit.any(axis=1).reshape(points.shape[:2]).mean(axis=0))


def _described(
    model: Model,
    camera: Camera,
    pose: Pose,
    positions: Sequence[Floats | None],
    face: NDArray[np.int32],
    at: tuple[Ints, Ints],
    blur_px: float,
) -> Places:
    located = np.array([place is not None and bool(model.faces) for place in positions], dtype=np.bool_)
    shape = np.ones((len(at[0]), 1 + len(positions)))
    normal = np.zeros((len(at[0]), 3))
    if model.faces:
        middles = pose.apply(np.array([model.vertices[polygon].mean(axis=0) for polygon in model.faces]))
        normals = towards_camera(model.face_normals @ pose.matrix.T, middles)
        normal = normals[face[at]]
        points = _points(camera, at, middles[face[at]], normal, blur_px)
        lit = [lambert(middles, normals, place) for place in positions if place is not None]
        unit = float(np.mean([part[face[at]] for part in lit])) if lit and len(at[0]) else 0.0
        known = np.flatnonzero(located)
        corners = pose.apply(model.vertices)[model.triangles]
        for light, part in zip(known.tolist(), lit if unit > 0.0 else (), strict=unit > 0.0):
            picture = np.where(face >= 0, part[face] / unit, 0.0).astype(np.float32)
            shape[:, 1 + light] = cv2.GaussianBlur(picture, (0, 0), blur_px / SMALLER)[at]
            position = positions[light]
            assert position is not None
            shape[:, 1 + light] *= _reached(points, position, corners)
    return Places(np.stack(at, axis=1), normal, shape, located)
