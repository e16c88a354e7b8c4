"""Blur of a target that moves and turns while the shutter is open.

A point P of a target that moves with velocity v and turns with ω about its origin T has the velocity
V = v + ω × (P - T). Seen along the ray r = P / z, with w = 1/z, its image moves by

    fx (a_x - a_z r_x), fy (a_y - a_z r_y)    where a = V / z = w (v - ω × T) + ω × r

(Longuet-Higgins and Prazdny, 1980), which is all that is needed of the point but its depth.
"""

import math

import cv2
import numpy as np

from geometry.camera import Camera
from image_server.simulator.lens import nearest_around
from image_server.simulator.rays import pixel_rays
from numerics.arrays import Field, Floats

LEAST_MOTION_PX = 0.05  # during the exposure; less changes no grey value by more than rounding
STEPS_PER_PX = 2  # chosen by hand; compared with exact motion in docs/validation.md
MOST_STEPS = 64  # chosen by hand; bounds the time of a frame


def image_velocity(
    camera: Camera, origin: Floats, velocity: Floats, spin: Floats, inverse_depth: Field
) -> Field:
    """Velocity (H, W, 2) px/s of the image of a moving target.

    Parameters
    ----------
    camera : its lens is taken to have no distortion here.
    origin, velocity, spin : (3,) of the target: where it is (m), m/s, and rad/s; camera axes.
    inverse_depth : (H, W) 1/m where the target is seen, 0 elsewhere, where nothing moves.
    """
    rays = pixel_rays(camera, np.arange(camera.height), np.arange(camera.width)).astype(np.float64)
    w = inverse_depth.ravel()[:, None]
    a = w * (velocity - np.cross(spin, origin)) + np.cross(spin, rays)
    moved = (a[:, :2] - a[:, 2:] * rays[:, :2]) * [camera.fx, camera.fy] * (w > 0)
    out: Field = moved.reshape(*inverse_depth.shape, 2).astype(np.float32)
    return out


def smeared(
    radiance: Field,
    camera: Camera,
    origin: Floats,
    velocity: Floats,
    spin: Floats,
    inverse_depth: Field,
    shutter_s: float,
) -> Field:
    """Radiance (H, W) gathered over an exposure centred on now; parameters as of `image_velocity`.

    Each pixel sees what passes over it with the motion of its own point, or of the nearest one whose path
    crosses its outline; a path that is longer than the frame reaches half of the frame to each side.
    """
    path = shutter_s * image_velocity(camera, origin, velocity, spin, inverse_depth)
    longest = min(float(np.hypot(path[..., 0], path[..., 1]).max()), max(radiance.shape))
    if longest < LEAST_MOTION_PX:
        return radiance
    around = nearest_around(inverse_depth, math.ceil(longest / 2) + 1)
    path = shutter_s * image_velocity(camera, origin, velocity, spin, around)
    steps = min(MOST_STEPS, 2 + math.ceil(STEPS_PER_PX * longest))
    x, y = np.meshgrid(np.arange(camera.width, dtype=np.float32), np.arange(camera.height, dtype=np.float32))
    out = np.zeros_like(radiance)
    for time in (np.arange(steps) + 0.5) / steps - 0.5:
        back = np.float32(time)
        out += cv2.remap(
            radiance, x - back * path[..., 0], y - back * path[..., 1], cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REPLICATE,
        )  # fmt: skip
    out /= np.float32(steps)
    return out
