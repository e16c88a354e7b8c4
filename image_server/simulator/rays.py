"""Rays against triangles through Embree: what is seen first, and what stands between a point and a light."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera
from numerics.arrays import Field, Flags, Floats, Ints

Rays = Field


def pixel_rays(camera: Camera, rows: Ints, columns: Ints) -> Rays:
    """Rays (R·C, 3) float32 of the pixels of some rows and columns, with z = 1: distances are depths."""
    x, y = np.meshgrid(columns.astype(np.float64), rows.astype(np.float64))
    return rays_through(camera, np.stack([x.ravel(), y.ravel()], axis=1))


def rays_through(camera: Camera, pixels: Floats) -> Rays:
    """Rays (N, 3) float32 of places (N, 2) in the image, with z = 1."""
    ideal = camera.undistort_points(pixels)
    rays = np.ones((len(pixels), 3), np.float32)
    rays[:, :2] = (ideal - [camera.cx, camera.cy]) / [camera.fx, camera.fy]
    return rays


NOTHING = -1
"""Triangle number of a ray that hits nothing."""


class Caster:
    """Triangles (T, 3, 3) in metres, ready for rays; the camera is the origin."""

    def __init__(self, triangles: Floats) -> None:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        vertices = np.ascontiguousarray(triangles.reshape(-1, 3), dtype=np.float32)
        indices = np.arange(len(vertices), dtype=np.int32).reshape(-1, 3)
        self._scene = EmbreeScene()
        self._mesh = TriangleMesh(self._scene, vertices, indices)  # must live as long as the scene
        self._run: Callable[..., Any] = self._scene.run

    def first_hits(self, directions: Rays) -> tuple[NDArray[np.int32], Rays]:
        """Triangle number (N,) and distance in units of the direction (N,) of rays (N, 3) from the camera."""
        origins = np.zeros_like(directions)
        found = self._run(origins, directions, output=1)
        return found["primID"], found["tfar"]

    def reached(self, origins: Rays, directions: Rays, far: float) -> Flags:
        """Whether nothing stands between origins (N, 3) and `far` times directions (N, 3) from them."""
        limits = np.full(len(origins), far, np.float32)
        blocked = self._run(origins, directions, limits, query="OCCLUDED")
        return np.asarray(blocked == NOTHING)


def starts_of(
    directions: Rays, distance: Rays, triangle: NDArray[np.int32], normals: Floats, lift: float
) -> tuple[Rays, Rays]:
    """Where shadow rays start: points hit by rays from the camera, `lift` above the face; and its normals.

    Parameters
    ----------
    directions, distance, triangle : (N, 3), (N,), (N,) of rays that hit something.
    normals : (T, 3) unit normals of the triangles, to either side.

    Returns
    -------
    (N, 3) starts and (N, 3) unit normals on the camera's side, float32.
    """
    towards = normals.take(triangle, axis=0)
    towards[sum(towards[:, k] * directions[:, k] for k in range(3)) > 0] *= -1.0
    starts = directions * distance[:, None] + lift * towards
    return starts.astype(np.float32), towards.astype(np.float32)


def rays_to(starts: Rays, normals: Rays, source: Floats, near: bool) -> tuple[Ints, Rays, Rays]:
    """Rays to a light from the starts whose faces look at it.

    `source` is a point when `near`, else a direction. Returns the numbers (M,) of those starts, the starts
    (M, 3) and the directions (M, 3), as long as the way to the point.
    """
    ways = [source[k] - starts[:, k] if near else source[k] for k in range(3)]
    index = np.flatnonzero(sum(normals[:, k] * ways[k] for k in range(3)) > 0)
    directions = np.empty((len(index), 3), np.float32)
    for k in range(3):
        directions[:, k] = ways[k].take(index) if near else ways[k]
    return index, starts.take(index, axis=0), directions
