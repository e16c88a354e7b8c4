"""Planar polygons in space: area vectors and triangulation of concave outlines."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from geometry.errors import GeometryError

Array = NDArray[np.float64]

FLAT_EAR = -1e-12  # an ear may be flat: what is a little less is rounding


def area_vector(corners: Array) -> Array:
    """Newell's area vector (3,) of a polygon (N, 3): its normal, as long as its area, right-handed."""
    out: Array = area_vectors(corners, [np.arange(len(corners))])[0]
    return out


def area_vectors(vertices: Array, faces: Sequence[NDArray[np.int64]]) -> Array:
    """`area_vector` of each of many polygons, faces of vertex indices: (F, 3)."""
    if not len(faces):
        return np.empty((0, 3))
    counts = np.array([len(face) for face in faces])
    last = np.cumsum(counts) - 1
    first = last - counts + 1
    corner = np.concatenate(faces)
    x, y, z = (vertices[corner] - np.repeat(vertices[corner[first]], counts, axis=0)).T
    following = np.arange(1, len(corner) + 1)
    following[last] = first
    crossed = np.stack(
        [
            y * z[following] - z * y[following],
            z * x[following] - x * z[following],
            x * y[following] - y * x[following],
        ],
        axis=1,
    )
    out: Array = 0.5 * np.add.reduceat(crossed, first, axis=0)
    return out


def triangulate(corners: Array) -> NDArray[np.int64]:
    """Triangles (N - 2, 3), as indices into the corners, that tile a simple polygon by ear clipping.

    Parameters
    ----------
    corners : (N, 3) float64, a planar simple polygon, convex or not; corners on a straight side are allowed.

    Returns
    -------
    The triangles wind as the polygon does.

    Raises
    ------
    GeometryError : fewer than three corners, no area, or sides that cross.
    """
    count = len(corners)
    if count < 3:
        raise GeometryError(f"a face needs at least 3 points, got {count}")
    normal = area_vector(corners)
    area = float(np.linalg.norm(normal))
    size = float(np.ptp(corners, axis=0).max())
    if not area > 1e-9 * size * size:
        raise GeometryError("a face has no area")
    if count == 3:
        return np.array([[0, 1, 2]])
    flat = _in_plane(corners, normal / area)
    if _sides_cross(flat):
        raise GeometryError("the sides of a face cross each other")
    left = list(range(count))
    triangles: list[list[int]] = []
    while len(left) > 3:
        ear = _best_ear(flat, left)
        if ear is None:
            raise GeometryError("the sides of a face cross each other")
        triangles.append([left[ear - 1], left[ear], left[(ear + 1) % len(left)]])
        del left[ear]
    triangles.append(left)
    return np.array(triangles)


def _in_plane(corners: Array, normal: Array) -> Array:
    """Corners in a right-handed frame of their plane, (N, 2)."""
    axis = np.eye(3)[int(np.argmin(np.abs(normal)))]
    first = np.cross(axis, normal)
    first /= np.linalg.norm(first)
    second = np.cross(normal, first)
    return np.stack([corners @ first, corners @ second], axis=1)


def _sides_cross(flat: Array) -> bool:
    """Whether two sides of a polygon (N, 2) cross inside each other."""
    starts, steps = flat, np.roll(flat, -1, axis=0) - flat
    gaps = starts[None, :] - starts[:, None]
    turned = steps[:, None, 0] * steps[None, :, 1] - steps[:, None, 1] * steps[None, :, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        along = (gaps[..., 0] * steps[None, :, 1] - gaps[..., 1] * steps[None, :, 0]) / turned
        other = (gaps[..., 0] * steps[:, None, 1] - gaps[..., 1] * steps[:, None, 0]) / turned
    inside = (along > 1e-9) & (along < 1 - 1e-9) & (other > 1e-9) & (other < 1 - 1e-9)
    return bool((inside & (turned != 0)).any())


def _best_ear(flat: Array, left: list[int]) -> int | None:
    """Position in `left` of the ear whose triangle is the fattest, None when there is no ear."""
    points = flat[left]
    before, after = np.roll(points, 1, axis=0), np.roll(points, -1, axis=0)
    sides = np.stack([points - before, after - points, before - after])
    longest = (sides**2).sum(axis=2).max(axis=0)
    doubled = _cross(points - before, after - before)
    quality = np.divide(doubled, longest, out=np.zeros(len(left)), where=longest > 0)
    for position in np.argsort(-quality, kind="stable"):
        if quality[position] < FLAT_EAR:
            break
        a, b, c = before[position], points[position], after[position]
        corner = (points[:, None] == np.stack([a, b, c])).all(axis=2).any(axis=1)
        if not (_inside(points, a, b, c) & ~corner).any():
            return int(position)
    return None


def _cross(u: Array, v: Array) -> Array:
    """Cross products of vectors (..., 2) in a plane."""
    product: Array = u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]
    return product


def _inside(p: Array, a: Array, b: Array, c: Array) -> NDArray[np.bool_]:
    """Which of the points p (N, 2) lie in a triangle or on its border."""
    return (_cross(b - a, p - a) >= 0) & (_cross(c - b, p - b) >= 0) & (_cross(a - c, p - c) >= 0)
