"""Pictures in a fourth of their size: of images, and of which face of a target is seen where."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera
from geometry.faces_in_front import faces_in_front
from geometry.model import Model
from geometry.pose import Pose
from numerics.arrays import Field

SMALLER = 4  # chosen by hand: light is looked at in a fourth of the size


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
