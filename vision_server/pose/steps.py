"""Small steps of a pose: what they turn about, and the Jacobian of points in the image along line normals."""

from __future__ import annotations

import numpy as np

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from geometry.rotation import matrix_of
from numerics.arrays import Floats
from numerics.kernels import kernel

SMALL_STEP_PX = 0.5  # for the derivative of the lens distortion


def turning_point(model: Model, pose: Pose) -> Floats:
    """The middle of the target, (3,), camera frame, metres: what steps turn about."""
    return np.asarray(pose.apply(model.middle[None])[0])


def moved(pose: Pose, step: Floats, centre: Floats) -> Pose:
    """The pose after a step that turns about ``centre`` (camera frame)."""
    turn = matrix_of(np.ascontiguousarray(step[:3]))
    return Pose.from_matrix(turn @ pose.matrix, centre + step[3:6] + turn @ (pose.translation - centre))


def step_jacobian(camera: Camera, points_camera: Floats, normal: Floats, centre: Floats) -> Floats:
    """Motion along the image normal, px, per step (rotation about ``centre`` rad, translation m), (N, 6)."""
    if camera.distorted:
        normal = _through_lens(camera, points_camera, normal)
    out: Floats = _pinhole_jacobian(camera.fx, camera.fy, points_camera, normal, centre)
    return out


@kernel()
def _pinhole_jacobian(fx: float, fy: float, points: Floats, normal: Floats, centre: Floats) -> Floats:
    out = np.empty((len(points), 6))
    for i in range(len(points)):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        gx, gy = normal[i, 0] * fx / z, normal[i, 1] * fy / z
        gz = -(gx * x + gy * y) / z
        x, y, z = x - centre[0], y - centre[1], z - centre[2]
        out[i, 0], out[i, 1], out[i, 2] = y * gz - z * gy, z * gx - x * gz, x * gy - y * gx
        out[i, 3], out[i, 4], out[i, 5] = gx, gy, gz
    return out


def _through_lens(camera: Camera, points: Floats, normal: Floats) -> Floats:
    """Normals times the derivative of distorted by ideal pixels, (N, 2)."""
    columns = []
    for axis, focal in ((0, camera.fx), (1, camera.fy)):
        step = np.zeros_like(points)
        step[:, axis] = SMALL_STEP_PX * points[:, 2] / focal
        moved_px = camera.project(points + step) - camera.project(points - step)
        columns.append(np.sum(normal * moved_px, axis=1) / (2.0 * SMALL_STEP_PX))
    return np.stack(columns, axis=1)
