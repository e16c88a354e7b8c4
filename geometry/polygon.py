"""Planar polygons in space: area vectors and triangulation of concave outlines."""

import heapq
from collections.abc import Sequence
from contextlib import suppress

import numpy as np

from geometry.errors import GeometryError
from numerics.arrays import Flags, Floats, Ints

FLAT_EAR = -1e-12  # an ear may be flat: what is a little less is rounding
MANY_CORNERS = 32  # of what is a curve; chosen by hand
NO_EAR = np.inf
SOME_CORNERS = 8  # a fan of more has slivers, between which rays are slow to find
MOST_CORNERS = 10_000  # of one face: its triangles take seconds to find
MOST_PAIRS = 1_000_000  # of sides that are looked at together: 100 MB


def area_vector(corners: Floats) -> Floats:
    """Newell's area vector (3,) of a polygon (N, 3): its normal, as long as its area, right-handed."""
    out: Floats = area_vectors(corners, [np.arange(len(corners))])[0]
    return out


def area_vectors(vertices: Floats, faces: Sequence[Ints]) -> Floats:
    """`area_vector` of each of many polygons, faces of vertex indices: (F, 3)."""
    if not len(faces):
        return np.empty((0, 3))
    corner, following, counts = corners_of(faces)
    first = np.cumsum(counts) - counts
    x, y, z = (vertices[corner] - np.repeat(vertices[corner[first]], counts, axis=0)).T
    crossed = np.stack(
        [
            y * z[following] - z * y[following],
            z * x[following] - x * z[following],
            x * y[following] - y * x[following],
        ],
        axis=1,
    )
    out: Floats = 0.5 * np.add.reduceat(crossed, first, axis=0)
    return out


def face_areas(vertices: Floats, faces: Sequence[Ints]) -> Floats:
    """The area (F,) of each of many polygons; a triangle that has none by this has no normal either."""
    return np.asarray(np.linalg.norm(area_vectors(vertices, faces), axis=1))


def corners_of(faces: Sequence[Ints]) -> tuple[Ints, Ints, Ints]:
    """Vertex indices of the corners of many polygons in a row, and where the next corner of each one is.

    Both (C,); and how many corners each polygon has, (F,).
    """
    corner = np.concatenate([np.empty(0, np.int64), *faces])
    counts = np.array([len(face) for face in faces], dtype=np.int64)
    past = np.cumsum(counts)
    following = np.arange(1, len(corner) + 1)
    following[past - 1] = past - counts
    return corner, following, counts


def triangulate(corners: Floats) -> Ints:
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
    return np.array(_clipped(flat))


def to_cut(vertices: Floats, faces: Sequence[Ints]) -> Flags:
    """Which polygons (F,), faces of vertex indices, a fan does not tile well: concave, or of many corners."""
    if not len(faces):
        return np.empty(0, dtype=np.bool_)
    normals = area_vectors(vertices, faces)
    corner, following, counts = corners_of(faces)
    sides = vertices[corner[following]] - vertices[corner]
    bends = np.cross(sides, sides[following])
    turned = (bends * np.repeat(normals, counts, axis=0)).sum(axis=1)
    size = np.repeat((normals**2).sum(axis=1), counts)
    concave = np.logical_or.reduceat(turned < -1e-9 * size, np.cumsum(counts) - counts)
    return np.asarray(concave | (counts > SOME_CORNERS))


def as_triangles(vertices: Floats, faces: Sequence[Ints]) -> Ints:
    """Triangles (T, 3), vertex indices, of polygons; a fan of what cannot be cut, as where sides cross."""
    out = [np.empty((0, 3), dtype=np.int64)]
    for face, cut in zip(faces, to_cut(vertices, faces).tolist(), strict=True):
        fan = np.column_stack([np.zeros(len(face) - 2), np.arange(1, len(face) - 1), np.arange(2, len(face))])
        tiles = fan.astype(np.int64)
        if cut:
            with suppress(GeometryError):
                tiles = triangulate(vertices[face])
        out.append(face[tiles])
    return np.concatenate(out)


def _clipped(flat: Floats) -> list[list[int]]:
    """Triangles of a polygon (N, 2): always the ear that is best is cut off next.

    An ear that holds another corner waits until that corner is cut off.
    """
    count = len(flat)
    before, after = [count - 1, *range(count - 1)], [*range(1, count), 0]
    left = np.ones(count, dtype=np.bool_)
    latest = _badness(flat, before, list(range(count)), after).tolist()
    ears = [(badness, ear) for ear, badness in enumerate(latest) if badness < NO_EAR]
    heapq.heapify(ears)
    waiting: dict[int, list[int]] = {}
    triangles: list[list[int]] = []
    while len(triangles) < count - 3:
        if not ears:
            raise GeometryError("the sides of a face cross each other")
        badness, ear = heapq.heappop(ears)
        if not left[ear] or latest[ear] != badness:
            continue  # cut off, or of other neighbours by now
        triangle = [before[ear], ear, after[ear]]
        held = _corner_in(flat, left, triangle)
        if held is not None:
            waiting.setdefault(held, []).append(ear)
            continue
        triangles.append(triangle)
        left[ear] = False
        sides = [before[ear], after[ear]]
        after[sides[0]], before[sides[1]] = sides[1], sides[0]
        news = _badness(flat, [before[c] for c in sides], sides, [after[c] for c in sides])
        for corner, badness in zip(sides, news.tolist(), strict=True):
            latest[corner] = badness
        for corner in {*sides, *waiting.pop(ear, ())}:
            if latest[corner] < NO_EAR:
                heapq.heappush(ears, (latest[corner], corner))
    return [*triangles, np.flatnonzero(left).tolist()]


def _in_plane(corners: Floats, normal: Floats) -> Floats:
    """Corners in a right-handed frame of their plane, (N, 2)."""
    axis = np.eye(3)[int(np.argmin(np.abs(normal)))]
    first = np.cross(axis, normal)
    first /= np.linalg.norm(first)
    second = np.cross(normal, first)
    return np.stack([corners @ first, corners @ second], axis=1)


def _sides_cross(flat: Floats) -> bool:
    """Whether two sides of a polygon (N, 2) cross inside each other."""
    steps = np.roll(flat, -1, axis=0) - flat
    rows = max(1, MOST_PAIRS // len(flat))
    return any(
        _cross_any(flat[k : k + rows], steps[k : k + rows], flat, steps) for k in range(0, len(flat), rows)
    )


def _cross_any(starts: Floats, steps: Floats, others: Floats, other_steps: Floats) -> bool:
    """Whether one of some sides (M, 2) crosses one of others (N, 2) inside."""
    gaps = others[None, :] - starts[:, None]
    turned = steps[:, None, 0] * other_steps[None, :, 1] - steps[:, None, 1] * other_steps[None, :, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        along = (gaps[..., 0] * other_steps[None, :, 1] - gaps[..., 1] * other_steps[None, :, 0]) / turned
        other = (gaps[..., 0] * steps[:, None, 1] - gaps[..., 1] * steps[:, None, 0]) / turned
    inside = (along > 1e-9) & (along < 1 - 1e-9) & (other > 1e-9) & (other < 1 - 1e-9)
    return bool((inside & (turned != 0)).any())


def _badness(flat: Floats, before: list[int], at: list[int], after: list[int]) -> Floats:
    """How bad it is to cut off some corners, NO_EAR where that cannot be.

    Fat triangles are best (twice the area over the square of the longest side); along the curves of
    MANY_CORNERS that would make fans, and the shortest cut is best.
    """
    a, b, c = flat[before], flat[at], flat[after]
    squares = (np.stack([b - a, c - b, a - c]) ** 2).sum(axis=2)
    longest = squares.max(axis=0)
    fatness = np.divide(_cross(b - a, c - a), longest, out=np.zeros(len(at)), where=longest > 0)
    order = squares[2] if len(flat) > MANY_CORNERS else -fatness
    badness: Floats = np.where(fatness < FLAT_EAR, NO_EAR, order)
    return badness


def _corner_in(flat: Floats, left: Flags, triangle: list[int]) -> int | None:
    """One of the corners that are left, in a triangle or on its border; its own places do not count."""
    a, b, c = flat[triangle]
    for corner in np.flatnonzero(_inside(flat, a, b, c) & left):
        if not (flat[corner] == flat[triangle]).all(axis=1).any():
            return int(corner)
    return None


def _cross(u: Floats, v: Floats) -> Floats:
    """Cross products of vectors (..., 2) in a plane."""
    product: Floats = u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]
    return product


def _inside(p: Floats, a: Floats, b: Floats, c: Floats) -> Flags:
    """Which of the points p (N, 2) lie in a triangle or on its border."""
    return (_cross(b - a, p - a) >= 0) & (_cross(c - b, p - b) >= 0) & (_cross(a - c, p - c) >= 0)
