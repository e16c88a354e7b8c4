"""Score poses against the nearest image edges, and pull them onto these (iterated closest points)."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from geometry.rotation import matrix_of
from vision_server.matching.nearest_edges import NO_SEGMENT, NearestEdges, nearest, offset
from vision_server.matching.views import ViewTable

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

CLUTTER = 0.4  # support of a pixel of model line that chance gives; less than this counts against a pose
DAMPING = 1e-3  # of the normal equations' diagonal
MAX_TURN_RAD = 0.2  # largest rotation of one step


@njit(cache=True)
def score_poses(
    edges: NearestEdges,
    views: ViewTable,
    view: Ints,
    rotations: Floats,
    translations: Floats,
    intrinsics: Floats,
    reach_px: float,
) -> Floats:
    """Score of each pose: sum over visible samples of px · (max(0, 1 − d/reach) − CLUTTER), (N,).

    d is the distance to the nearest image segment of like direction; samples outside the image are skipped.
    """
    out = np.zeros(len(view))
    fx, fy, cx, cy = intrinsics[0], intrinsics[1], intrinsics[2], intrinsics[3]
    for i in range(len(view)):
        r, t = rotations[i], translations[i]
        total = 0.0
        for s in range(views.first[view[i]], views.first[view[i] + 1]):
            p, e = views.points[s], views.ends[s]
            z = r[2, 0] * p[0] + r[2, 1] * p[1] + r[2, 2] * p[2] + t[2]
            z_end = r[2, 0] * e[0] + r[2, 1] * e[1] + r[2, 2] * e[2] + t[2]
            if z <= 1e-6 or z_end <= 1e-6:
                continue
            x = fx * (r[0, 0] * p[0] + r[0, 1] * p[1] + r[0, 2] * p[2] + t[0]) / z + cx
            y = fy * (r[1, 0] * p[0] + r[1, 1] * p[1] + r[1, 2] * p[2] + t[1]) / z + cy
            if not (-0.5 <= x < edges.size[0] - 0.5 and -0.5 <= y < edges.size[1] - 0.5):
                continue
            dx = fx * (r[0, 0] * e[0] + r[0, 1] * e[1] + r[0, 2] * e[2] + t[0]) / z_end + cx - x
            dy = fy * (r[1, 0] * e[0] + r[1, 1] * e[1] + r[1, 2] * e[2] + t[1]) / z_end + cy - y
            segment = nearest(edges, x, y, dx, dy)
            gain = -CLUTTER
            if segment != NO_SEGMENT:
                _, distance = offset(edges, segment, x, y)
                gain += max(0.0, 1.0 - distance / reach_px)
            total += views.px[s] * gain
        out[i] = total
    return out


@njit(cache=True)
def solve_step(normal: Floats, gradient: Floats) -> Floats:
    """Solution (6,) of the damped normal equations (6, 6), (6,), by Cholesky; 0 when they have no rank."""
    lower = np.zeros((6, 6))
    out = np.zeros(6)
    for i in range(6):
        for j in range(i + 1):
            value = normal[i, j]
            if i == j:
                value += DAMPING * normal[i, i] + 1e-12
            for k in range(j):
                value -= lower[i, k] * lower[j, k]
            if i == j:
                if not value > 0.0:
                    return out
                lower[i, i] = math.sqrt(value)
            else:
                lower[i, j] = value / lower[j, j]
    for i in range(6):
        value = gradient[i]
        for k in range(i):
            value -= lower[i, k] * out[k]
        out[i] = value / lower[i, i]
    for i in range(5, -1, -1):
        value = out[i]
        for k in range(i + 1, 6):
            value -= lower[k, i] * out[k]
        out[i] = value / lower[i, i]
    return out


@njit(cache=True)
def pull(
    edges: NearestEdges,
    points: Floats,
    ends: Floats,
    px: Floats,
    rotation: Floats,
    translation: Floats,
    intrinsics: Floats,
    reach_px: float,
    iterations: int,
) -> None:
    """Move one pose (3, 3), (3,), in place, so that the samples come to lie on their nearest segments.

    Residual: distance to the segment's line; weight: px · (1 − (d/reach)²)², d the distance to the
    segment itself. The step turns about the target's origin by at most MAX_TURN_RAD.
    """
    fx, fy, cx, cy = intrinsics[0], intrinsics[1], intrinsics[2], intrinsics[3]
    normal = np.empty((6, 6))
    gradient = np.empty(6)
    row = np.empty(6)
    r, t = rotation, translation
    for _ in range(iterations):
        normal[:] = 0.0
        gradient[:] = 0.0
        for s in range(len(px)):
            p, e = points[s], ends[s]
            a = r[0, 0] * p[0] + r[0, 1] * p[1] + r[0, 2] * p[2]
            b = r[1, 0] * p[0] + r[1, 1] * p[1] + r[1, 2] * p[2]
            c = r[2, 0] * p[0] + r[2, 1] * p[1] + r[2, 2] * p[2]
            z = c + t[2]
            z_end = r[2, 0] * e[0] + r[2, 1] * e[1] + r[2, 2] * e[2] + t[2]
            if z <= 1e-6 or z_end <= 1e-6:
                continue
            nx, ny = (a + t[0]) / z, (b + t[1]) / z
            x, y = fx * nx + cx, fy * ny + cy
            if not (-0.5 <= x < edges.size[0] - 0.5 and -0.5 <= y < edges.size[1] - 0.5):
                continue
            dx = fx * (r[0, 0] * e[0] + r[0, 1] * e[1] + r[0, 2] * e[2] + t[0]) / z_end + cx - x
            dy = fy * (r[1, 0] * e[0] + r[1, 1] * e[1] + r[1, 2] * e[2] + t[1]) / z_end + cy - y
            segment = nearest(edges, x, y, dx, dy)
            if segment == NO_SEGMENT:
                continue
            across, distance = offset(edges, segment, x, y)
            if distance >= reach_px:
                continue
            share = 1.0 - (distance / reach_px) ** 2
            weight = px[s] * share * share * edges.segments[segment, 5]
            gx = -edges.segments[segment, 3] * fx / z
            gy = edges.segments[segment, 2] * fy / z
            gz = -(gx * nx + gy * ny)
            row[0], row[1], row[2] = b * gz - c * gy, c * gx - a * gz, a * gy - b * gx
            row[3], row[4], row[5] = gx, gy, gz
            for i in range(6):
                gradient[i] -= weight * row[i] * across
                for j in range(i + 1):
                    normal[i, j] += weight * row[i] * row[j]
        step = solve_step(normal, gradient)
        turn = math.sqrt(step[0] * step[0] + step[1] * step[1] + step[2] * step[2])
        if turn > MAX_TURN_RAD:
            step *= MAX_TURN_RAD / turn
        r[:] = matrix_of(step[:3]) @ r
        for k in range(3):
            t[k] += step[3 + k]


@njit(cache=True)
def pull_poses(
    edges: NearestEdges,
    views: ViewTable,
    view: Ints,
    rotations: Floats,
    translations: Floats,
    intrinsics: Floats,
    reach_px: float,
    iterations: int,
) -> None:
    """`pull` for many poses (N, 3, 3), (N, 3), in place, each with the samples of its view."""
    for i in range(len(view)):
        first, last = views.first[view[i]], views.first[view[i] + 1]
        pull(
            edges,
            views.points[first:last],
            views.ends[first:last],
            views.px[first:last],
            rotations[i],
            translations[i],
            intrinsics,
            reach_px,
            iterations,
        )
