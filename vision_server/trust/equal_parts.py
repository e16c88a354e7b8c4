"""Several equal parts in one image: poses that have the target at places apart may all be right."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from numerics.arrays import Field, Flags

FAR_OUT_WIDTHS = 5.0  # of the frame, beyond which it does not matter where a point is
# Chosen by hand, for parts that lie beside each other: poses whose outlines share less of the smaller one's
# area are apart, and with so much evidence one is believed a part of its own.
APART_OVERLAP, A_PART_NATS = 0.25, 25.0


def apart(model: Model, camera: Camera, poses: Sequence[Pose]) -> Flags:
    """Which of N poses have the target at different places in the image, (N, N), by its convex outlines."""
    outlines = [_outline(model, camera, pose) for pose in poses]
    areas = [cv2.contourArea(one) for one in outlines]
    out = np.zeros((len(poses), len(poses)), dtype=bool)
    for i, one in enumerate(outlines):
        for j, other in enumerate(outlines[:i]):
            least = min(areas[i], areas[j])
            if least > 0.0:
                out[i, j] = out[j, i] = cv2.intersectConvexConvex(one, other)[0] < APART_OVERLAP * least
    return out


def as_rival(nats: float, elsewhere: bool) -> float:
    """What evidence counts against another pose: with more, one elsewhere is believed a part of its own."""
    return min(nats, A_PART_NATS) if elsewhere else nats


def _outline(model: Model, camera: Camera, pose: Pose) -> Field:
    """Convex outline (P, 1, 2), px; one of no area where the target is not all in front of the camera."""
    pixels = camera.project(pose.apply(model.vertices))
    if not np.isfinite(pixels).all():
        pixels = np.zeros((1, 2))
    near = np.clip(pixels, -FAR_OUT_WIDTHS * camera.width, FAR_OUT_WIDTHS * camera.width)
    return np.asarray(cv2.convexHull(near.astype(np.float32)), dtype=np.float32)
