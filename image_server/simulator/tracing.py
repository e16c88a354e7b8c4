"""One geometry, traced once: the linear radiance image of each light alone and of the sun.

Every pixel is sampled at its centre first. Where face or shadow differs from a neighbour's, the pixel is
traced again at 16 places that no row or column of a 16×16 grid shares, so the coverage along an edge is true
to 1/32 px whatever its direction; elsewhere only the texture is averaged over the pixel.
"""

from concurrent.futures import Executor
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera
from image_server.simulator.light import Illumination
from image_server.simulator.rays import (
    NOTHING,
    Caster,
    Rays,
    pixel_rays,
    rays_through,
    rays_to,
    starts_of,
)
from image_server.simulator.sampling import DISC_STEP, RIM_VIEWS, SAMPLES, disc_directions, pixel_places
from image_server.simulator.scene import Scene
from image_server.simulator.shading import SurfaceSamples, shade
from image_server.simulator.sky import irradiance
from numerics.arrays import Field, Flags, Floats, Ints
from numerics.two_cores import beside

LIFT_M = 2e-5  # shadow rays start this far above the surface
NEAR_M = 1e-3  # nothing nearer is projected
BAND_PIXELS = 1 << 17  # traced at a time
BORDER_PX = 2  # around the things in view


@dataclass(frozen=True, eq=False)
class Traced:
    """What a geometry looks like, linear.

    Attributes
    ----------
    images : L + 1 images (H, W) float32: each light alone at full power, then sun and sky on the scene.
    coverage : (H, W) float32, share of each pixel in which there is something.
    inverse_depth : (H, W) float32, 1/m at the pixel's centre, 0 where there is nothing.
    part : (H, W) int16, the part of the scene there, -1 where there is nothing.
    """

    images: list[Field]
    coverage: Field
    inverse_depth: Field
    part: NDArray[np.int16]


def traced(scene: Scene, camera: Camera, light: Illumination) -> Traced:
    """Trace one geometry, some rows at a time, so that the memory needed is that of the images."""
    shape = (camera.height, camera.width)
    images = [np.zeros(shape, np.float32) for _ in range(len(light.lights) + 1)]
    coverage, inverse_depth = np.zeros(shape, np.float32), np.zeros(shape, np.float32)
    part = np.full(shape, -1, np.int16)
    left, top, right, bottom = _region(scene, camera)
    if left >= right or top >= bottom:
        return Traced(images, coverage, inverse_depth, part)
    step = max(1, BAND_PIXELS // (right - left))
    columns = np.arange(left, right)
    with beside() as shading:  # shades one lot of samples while the next is cast
        tracer = _Tracer(scene, camera, light, shading)
        for first in range(top, bottom, step):
            rows = np.arange(first, min(first + step, bottom))
            values, covered, near, parts = tracer.band(rows, columns)
            there = np.s_[rows[0] : rows[-1] + 1, left:right]
            for channel, image in enumerate(images):
                image[there] = values[..., channel]
            coverage[there], inverse_depth[there], part[there] = covered, near, parts
    return Traced(images, coverage, inverse_depth, part)


class _Tracer:
    """Casts and shades samples of one scene."""

    def __init__(self, scene: Scene, camera: Camera, light: Illumination, shading: Executor) -> None:
        self._scene = scene
        self._camera = camera
        self._light = light
        self._shading = shading
        self._caster = Caster(scene.triangles)
        self._disc = disc_directions(light.sky.sun, light.sky.sun_radius_rad)
        self._sky = irradiance(light.sky)

    def band(self, rows: Ints, columns: Ints) -> tuple[Field, Field, Field, NDArray[np.int16]]:
        """Radiance (R, C, L + 1), coverage, 1/depth and part (R, C) of some rows and columns of pixels.

        A row above and one below are cast, too: what differs from them is an edge.
        """
        camera = self._camera
        around = np.arange(rows[0] - 1, rows[-1] + 2)
        inner = np.s_[len(columns) : -len(columns)]
        directions = pixel_rays(camera, around, columns)
        grid = (len(around), len(columns))
        triangle, distance, seen, reach, rim = self.looked(directions, _every_other(grid))
        face = np.where(triangle == NOTHING, -1, self._scene.face[triangle])
        mixed = _mixed(seen.reshape(*grid, -1), (triangle != NOTHING).reshape(grid)).reshape(seen.shape)
        mixed[:, -1] |= _near(rim.reshape(grid), 2).ravel()
        edge = (_differs(face.reshape(grid)).ravel() | mixed.any(axis=1))[inner]
        directions, triangle, mixed = directions[inner], triangle[inner], mixed[inner]
        distance, reach = distance[inner], reach[inner]
        values = np.zeros((len(directions), reach.shape[1]), np.float32)
        covered = (triangle != NOTHING).astype(np.float32)
        near = covered / np.where(covered > 0, distance, 1.0)
        plain = np.flatnonzero(~edge & (covered > 0))
        pixel = np.array([1 / camera.fx, 1 / camera.fy])
        inside = self._shading.submit(
            self.shaded, triangle[plain], directions[plain], distance[plain], reach[plain], pixel
        )
        chosen = np.flatnonzero(edge)
        penumbra = mixed[chosen, -1]
        total = np.zeros((len(chosen), reach.shape[1]), np.float32)
        samples = []
        hits = np.zeros(len(chosen), np.float32)
        centres = np.stack([columns[chosen % len(columns)], rows[chosen // len(columns)]], axis=1)
        for place, offset in enumerate(pixel_places()):
            rays = rays_through(camera, centres + offset)
            t, d, share = self.sampled(rays, place, penumbra)
            hit = np.flatnonzero(t != NOTHING)
            shading = self._shading.submit(self.shaded, t[hit], rays[hit], d[hit], share[hit], np.zeros(2))
            samples.append((hit, shading))
            hits[hit] += 1.0
        for hit, shading in samples:
            total[hit] += shading.result()
        values[plain] = inside.result()
        values[chosen] = total / SAMPLES
        covered[chosen] = hits / SAMPLES
        shape = (len(rows), len(columns))
        part = np.where(face < 0, -1, self._scene.part[face])[inner].astype(np.int16)
        return (
            values.reshape(*shape, -1),
            covered.reshape(shape),
            near.reshape(shape).astype(np.float32),
            part.reshape(shape),
        )

    def looked(self, directions: Rays, rim: Flags) -> tuple[NDArray[np.int32], Rays, Flags, Rays, Flags]:
        """A first look along rays from the camera (N, 3), and from what they hit to each light.

        Where `rim` (N,) asks for it, it also looks at the rim of the sun's disc.

        Returns
        -------
        triangle (N,), distance (N,); whether each light and then the sun's middle is seen from there
        (N, L + 1); what `shade` wants of it; and where the sun's rim is not as its middle (N,).
        """
        triangle, distance, hit, starts, normals = self._hit(directions)
        light = self._light
        seen = np.zeros((len(directions), len(light.lights) + 1), bool)
        for c, position in enumerate(light.lights):
            seen[hit, c] = self._reached(starts, normals, position, True)
        seen[hit, -1] = self._reached(starts, normals, self._disc[0], False)
        partly = np.zeros(len(directions), bool)
        asked = np.flatnonzero(rim[hit])
        for view in self._disc[1 : 1 + RIM_VIEWS]:
            there = self._reached(starts[asked], normals[asked], view, False)
            partly[hit[asked]] |= there != seen[hit[asked], -1]
        reach = seen.astype(np.float32)
        reach[hit, -1] *= normals @ self._disc[0].astype(np.float32)
        return triangle, distance, seen, reach, partly

    def sampled(self, directions: Rays, place: int, penumbra: Flags) -> tuple[NDArray[np.int32], Rays, Rays]:
        """Triangle (N,), distance (N,), reach (N, L + 1) along rays (N, 3) through a place of their pixels.

        `penumbra` (N,) tells around which pixels the sun's disc is partly hidden; elsewhere its middle stands
        for it. The last of reach is the light of the disc on the face: the mean cosine of what is seen of it.
        """
        triangle, distance, hit, starts, normals = self._hit(directions)
        light = self._light
        reach = np.zeros((len(directions), len(light.lights) + 1), np.float32)
        for c, position in enumerate(light.lights):
            reach[hit, c] = self._reached(starts, normals, position, True)
        own = self._disc[1 + (place * DISC_STEP) % SAMPLES :: SAMPLES] if len(self._disc) > 1 else self._disc
        for flags, views in ((~penumbra[hit], self._disc[:1]), (penumbra[hit], own)):
            there = np.flatnonzero(flags)
            for view in views:
                cosine = normals[there] @ view.astype(np.float32) / np.float32(len(views))
                reach[hit[there], -1] += cosine * self._reached(starts[there], normals[there], view, False)
        return triangle, distance, reach

    def _hit(self, directions: Rays) -> tuple[NDArray[np.int32], Rays, Ints, Rays, Rays]:
        """Triangle and distance (N,); numbers (M,) of the rays that hit; starts and normals (M, 3) there."""
        triangle, distance = self._caster.first_hits(directions)
        hit = np.flatnonzero(triangle != NOTHING)
        starts, normals = starts_of(
            directions[hit], distance[hit], triangle[hit], self._scene.normals, LIFT_M
        )
        return triangle, distance, hit, starts, normals

    def _reached(self, starts: Rays, normals: Rays, source: Floats, near: bool) -> Flags:
        """Which starts see a point, or (not `near`) the sky in a direction; those turned away do not."""
        out = np.zeros(len(starts), bool)
        index, origins, directions = rays_to(starts, normals, source, near)
        out[index] = self._caster.reached(origins, directions, 1.0 if near else np.inf)
        return out

    def shaded(
        self, triangle: NDArray[np.int32], directions: Rays, distance: Rays, reach: Rays, pixel: Floats
    ) -> Field:
        """Radiance (N, L + 1) of samples."""
        samples = SurfaceSamples(triangle, directions, distance, reach)
        return shade(samples, pixel, self._scene, self._light, self._sky)


def _region(scene: Scene, camera: Camera) -> tuple[int, int, int, int]:
    """Left, top, right, bottom (exclusive) of the pixels that can see something."""
    corners = scene.triangles.reshape(-1, 3)
    if camera.distorted or (corners[:, 2] < NEAR_M).any():
        return 0, 0, camera.width, camera.height
    pixels = camera.project(corners)
    low = np.floor(pixels.min(axis=0)).astype(int) - BORDER_PX
    high = np.ceil(pixels.max(axis=0)).astype(int) + BORDER_PX + 1
    return max(low[0], 0), max(low[1], 0), min(high[0], camera.width), min(high[1], camera.height)


def _mixed(seen: Flags, hit: Flags) -> Flags:
    """Where a pixel and its neighbours do not all see each light, or all not (H, W, C).

    Only pixels that hit something have a say.
    """
    there = hit[..., None]
    return _near(there & seen, 1) & _near(there & ~seen, 1)


def _near(flags: Flags, reach: int) -> Flags:
    """Pixels (H, W) or (H, W, C) that have one of the flags within reach."""
    window = np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)
    return np.asarray(cv2.dilate(flags.astype(np.uint8), window).reshape(flags.shape) > 0)


def _every_other(grid: tuple[int, int]) -> Flags:
    """One pixel in four (H·W,), spread evenly."""
    out = np.zeros(grid, bool)
    out[::2, ::2] = True
    return out.ravel()


def _differs(label: Ints) -> Flags:
    """Pixels (H, W) with another label among their eight neighbours."""
    window, exact = np.ones((3, 3), np.uint8), label.astype(np.float64)
    return np.asarray(cv2.dilate(exact, window) != cv2.erode(exact, window))
