"""One geometry, traced once: the linear radiance image of each light alone and of the sun.

Every pixel is sampled at its centre first. Where face or shadow differs from a neighbour's, the pixel is
traced again at 16 places that no row or column of a 16×16 grid shares, so the coverage along an edge is true
to 1/32 px whatever its direction; elsewhere only the texture is averaged over the pixel.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera
from image_server.simulator.rays import NOTHING, Caster, Rays
from image_server.simulator.scene import Scene
from image_server.simulator.shading import shade

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

REFERENCE_DISTANCE_M = 0.6
LIGHT_AT_REFERENCE = 0.5
"""Radiance of a white surface turned to one full light at 0.6 m; 1 clips at 1/60 s, f/4 and gain 1."""
SUN_STRENGTH = 0.5
"""Radiance of a white surface turned to the sun at `ambient_scale` 1."""
LIFT_M = 2e-5  # shadow rays start this far above the surface
NEAR_M = 1e-3  # nothing nearer is projected
BORDER_PX = 2  # around the things in view
SAMPLES = 16  # per pixel at edges
DISC_STEP = 5  # order in which the places of a pixel look at the sun's disc


@dataclass(frozen=True, eq=False)
class Illumination:
    """Where light comes from, camera frame.

    Attributes
    ----------
    lights : (L, 3) float64 positions, metres.
    sun : (3,) unit vector towards the sun.
    sun_radius_rad : half its angular diameter.
    earthshine : fraction of the sun's strength that comes from all sides.
    """

    lights: Floats
    sun: Floats
    sun_radius_rad: float
    earthshine: float


def traced(scene: Scene, camera: Camera, light: Illumination) -> list[NDArray[np.float32]]:
    """Radiance images (H, W) float32: each light alone at full power, then the sun with earth-shine."""
    channels = len(light.lights) + 1
    images = np.zeros((camera.height, camera.width, channels), np.float32)
    left, top, right, bottom = _region(scene, camera)
    if left >= right or top >= bottom:
        return [np.ascontiguousarray(images[..., c]) for c in range(channels)]
    tracer = _Tracer(scene, light)
    rows, columns = np.mgrid[top:bottom, left:right]
    centres = np.stack([columns.ravel(), rows.ravel()], axis=1).astype(np.float64)
    directions = _directions(camera, centres)
    triangle, distance, reach, label = tracer.sampled(directions, None)
    shape = rows.shape
    edge = _differs(label.reshape(shape)).ravel()
    values = np.zeros((len(centres), channels), np.float32)
    plain = np.flatnonzero(~edge & (triangle != NOTHING))
    pixel = np.array([1 / camera.fx, 1 / camera.fy])
    values[plain] = tracer.shaded(triangle[plain], directions[plain], distance[plain], reach[plain], pixel)
    chosen = np.flatnonzero(edge)
    total = np.zeros((len(chosen), channels), np.float32)
    for place, offset in enumerate(_places()):
        rays = _directions(camera, centres[chosen] + offset)
        t, d, share, _ = tracer.sampled(rays, place)
        hit = np.flatnonzero(t != NOTHING)
        total[hit] += tracer.shaded(t[hit], rays[hit], d[hit], share[hit], np.zeros(2))
    values[chosen] = total / SAMPLES
    images[top:bottom, left:right] = values.reshape(*shape, channels)
    return [np.ascontiguousarray(images[..., c]) for c in range(channels)]


class _Tracer:
    """Casts and shades samples of one scene."""

    def __init__(self, scene: Scene, light: Illumination) -> None:
        self._scene = scene
        self._light = light
        self._caster = Caster(scene.triangles)
        self._disc = _disc(light.sun, light.sun_radius_rad)

    def sampled(
        self, directions: Rays, place: int | None
    ) -> tuple[NDArray[np.int32], Rays, Rays, NDArray[np.int64]]:
        """Cast rays from the camera, and from what they hit to each light.

        `place` names one direction into the sun's disc; None looks at its middle and its rim.

        Returns
        -------
        triangle (N,), distance (N,), reach (N, L + 1), and a label (N,), equal where face and shadows are.
        """
        triangle, distance = self._caster.first_hits(directions)
        hit = np.flatnonzero(triangle != NOTHING)
        scene, light = self._scene, self._light
        rays = directions[hit].astype(np.float64)
        points = rays * distance[hit, None]
        normals = scene.normals[triangle[hit]]
        normals = normals * -np.sign(np.einsum("ij,ij->i", normals, rays))[:, None]
        starts = (points + LIFT_M * normals).astype(np.float32)
        channels = len(light.lights) + 1
        reach = np.zeros((len(directions), channels), np.float32)
        label = np.zeros(len(directions), np.int64)
        label[hit] = scene.face[triangle[hit]] + 1
        for c, position in enumerate(light.lights):
            there = (position - starts).astype(np.float32)
            reach[hit, c] = self._reached(normals, starts, there, 1.0)
            label = 2 * label + (reach[:, c] > 0)
        if place is None:
            views = [0, *range(1, SAMPLES, 4)] if light.sun_radius_rad > 0 else [0]
        else:
            views = [1 + (place * DISC_STEP) % SAMPLES]
        seen = np.zeros(len(hit), np.int64)
        for view in views:
            there = np.broadcast_to(self._disc[view].astype(np.float32), starts.shape)
            seen += self._reached(normals, starts, there, np.inf)
        reach[hit, -1] = seen / len(views)
        label = (SAMPLES + 1) * label
        label[hit] += seen
        return triangle, distance, reach, label

    def _reached(self, normals: Floats, starts: Rays, there: Rays, far: float) -> Flags:
        """Which starts see along `there`; those turned away do not."""
        out = np.einsum("ij,ij->i", normals, there) > 0
        facing = np.flatnonzero(out)
        out[facing] = self._caster.reached(starts[facing], np.ascontiguousarray(there[facing]), far)
        return np.asarray(out)

    def shaded(
        self, triangle: NDArray[np.int32], directions: Rays, distance: Rays, reach: Rays, pixel: Floats
    ) -> NDArray[np.float32]:
        """Radiance (N, L + 1) of samples."""
        scene, light = self._scene, self._light
        out: NDArray[np.float32] = shade(
            triangle,
            directions,
            distance,
            reach,
            pixel,
            scene.normals,
            scene.face,
            scene.surfaces,
            scene.axes,
            scene.part,
            scene.rotations,
            scene.translations,
            light.lights,
            LIGHT_AT_REFERENCE * REFERENCE_DISTANCE_M**2,
            light.sun,
            SUN_STRENGTH,
            SUN_STRENGTH * light.earthshine,
        )
        return out


def _region(scene: Scene, camera: Camera) -> tuple[int, int, int, int]:
    """Left, top, right, bottom (exclusive) of the pixels that can see something."""
    corners = scene.triangles.reshape(-1, 3)
    if camera.distorted or (corners[:, 2] < NEAR_M).any():
        return 0, 0, camera.width, camera.height
    pixels = camera.project(corners)
    low = np.floor(pixels.min(axis=0)).astype(int) - BORDER_PX
    high = np.ceil(pixels.max(axis=0)).astype(int) + BORDER_PX + 1
    return max(low[0], 0), max(low[1], 0), min(high[0], camera.width), min(high[1], camera.height)


def _directions(camera: Camera, pixels: Floats) -> Rays:
    """Rays (N, 3) of pixels (N, 2), with z = 1, so that distances are depths."""
    ideal = camera.undistort_points(pixels)
    rays = np.ones((len(pixels), 3), np.float32)
    rays[:, :2] = (ideal - [camera.cx, camera.cy]) / [camera.fx, camera.fy]
    return rays


def _differs(label: NDArray[np.int64]) -> Flags:
    """Pixels (H, W) with another label among their eight neighbours."""
    out = np.zeros(label.shape, bool)
    for here, there in (
        (np.s_[:-1], np.s_[1:]),
        (np.s_[:, :-1], np.s_[:, 1:]),
        (np.s_[:-1, :-1], np.s_[1:, 1:]),
        (np.s_[:-1, 1:], np.s_[1:, :-1]),
    ):
        unequal = label[here] != label[there]
        out[here] |= unequal
        out[there] |= unequal
    return out


def _places() -> Floats:
    """(SAMPLES, 2) offsets in px within a pixel: Hammersley's points, centred."""
    bits = int(math.log2(SAMPLES))
    reverse = [int(f"{index:0{bits}b}"[::-1], 2) for index in range(SAMPLES)]
    return (np.stack([np.arange(SAMPLES), reverse], axis=1) + 0.5) / SAMPLES - 0.5


def _disc(sun: Floats, radius_rad: float) -> Floats:
    """Directions (1 + SAMPLES, 3): the sun's middle, then places on its disc (golden spiral, rim first)."""
    helper = np.eye(3)[np.argmin(np.abs(sun))]
    u = np.cross(sun, helper)
    u /= np.linalg.norm(u)
    v = np.cross(sun, u)
    index = np.arange(SAMPLES)
    radius = radius_rad * np.sqrt(1 - (index + 0.5) / SAMPLES)
    angle = index * math.pi * (3 - math.sqrt(5))
    spread = np.outer(radius * np.cos(angle), u) + np.outer(radius * np.sin(angle), v)
    return np.concatenate([sun[None], sun + spread])
