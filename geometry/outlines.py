"""The outline of a curved surface at one pose: facets' lines that follow each other in the image."""

from __future__ import annotations

import math

import numpy as np

from geometry.chains import CURVE_DEG
from geometry.occluders import Solid
from numerics.arrays import Flags, Floats, Ints
from numerics.kernels import kernel

STRAIGHT_COSINE = math.cos(math.radians(CURVE_DEG))


@kernel()
def outline_direction(
    solid: Solid, line: int, rotation: Floats, intrinsics: Floats, dx: float, dy: float
) -> tuple[float, float]:
    """Direction of a curved surface's outline at one of its facets' lines, which itself runs in zigzag.

    The outline's image is that of the surface's tangent plane, which there holds the line of sight.

    Parameters
    ----------
    dx, dy : direction of the line in the image, whose sense is kept.
    """
    f, g = solid.line_faces[line, 0], solid.line_faces[line, 1]
    x, y = 0.0, 0.0
    for k in range(3):
        normal = solid.face_normal[f, k] + solid.face_normal[g, k]
        x += rotation[0, k] * normal
        y += rotation[1, k] * normal
    ux, uy = -y / intrinsics[1], x / intrinsics[0]
    length = math.hypot(ux, uy)
    if length == 0.0:
        return dx, dy
    sign = 1.0 if ux * dx + uy * dy >= 0.0 else -1.0
    return sign * ux / length, sign * uy / length


@kernel()
def outline_tangent(solid: Solid, line: int, point: Floats, centre: Floats, out: Floats) -> None:
    """Unit vector (3,) in the tangent plane at a point (3,) of an outline, across the line of sight."""
    f, g = solid.line_faces[line, 0], solid.line_faces[line, 1]
    normal, square = solid.face_normal, 0.0
    for k in range(3):
        a, b = (k + 1) % 3, (k + 2) % 3
        n_a, n_b = normal[f, a] + normal[g, a], normal[f, b] + normal[g, b]
        out[k] = n_a * (point[b] - centre[b]) - n_b * (point[a] - centre[a])
        square += out[k] * out[k]
    for k in range(3):
        out[k] /= math.sqrt(max(square, 1e-300))


@kernel()
def line_direction(solid: Solid, line: int, sign: float, out: Floats) -> None:
    """Unit vector (3,) of a line, in its own sense or against it."""
    a, b = solid.lines[line, 0], solid.lines[line, 1]
    square = 0.0
    for k in range(3):
        out[k] = solid.vertices[b, k] - solid.vertices[a, k]
        square += out[k] * out[k]
    for k in range(3):
        out[k] *= sign / math.sqrt(square)


@kernel()
def linked(solid: Solid, lines: Ints, course: Floats) -> tuple[Ints, Ints, Flags]:
    """Which of the lines that are seen follow each other; those of sharp arcs do at any pose.

    Parameters
    ----------
    lines : (K,), ascending.
    course : (K, 2), their unit directions in the image.

    Returns
    -------
    leader (K,), the first line of each one's arc; place (K,) along that; backwards (K,), against its sense.
    """
    count = len(lines)
    leader, place, backwards = solid.leader[lines], solid.place[lines], solid.backwards[lines]
    at = np.full((len(solid.vertices), 2), -1, dtype=np.int64)
    meeting = np.zeros(len(solid.vertices), dtype=np.int64)
    for j in range(count):
        if not solid.smooth[lines[j]]:
            continue
        for end in range(2):
            vertex = solid.lines[lines[j], end]
            if meeting[vertex] < 2:
                at[vertex, meeting[vertex]] = j
            meeting[vertex] += 1
    done = np.zeros(count, dtype=np.bool_)
    walk = np.empty(count, dtype=np.int64)
    for closed in range(2):  # open ones from their ends, then those that close
        for start in range(count):
            if done[start] or not solid.smooth[lines[start]]:
                continue
            a, b = solid.lines[lines[start], 0], solid.lines[lines[start], 1]
            if closed == 0 and meeting[a] == 2 and meeting[b] == 2:
                continue
            last = b if meeting[a] == 2 and closed == 0 else a
            j, size = start, 0
            fx, fy = 0.0, 0.0
            while j >= 0 and not done[j]:
                done[j] = True
                against = solid.lines[lines[j], 1] == last
                sign = -1.0 if against else 1.0
                ux, uy = sign * course[j, 0], sign * course[j, 1]
                if size > 0 and ux * fx + uy * fy < STRAIGHT_COSINE:
                    _number(lines, walk[:size], leader, place)
                    size = 0
                if size == 0:
                    fx, fy = ux, uy
                walk[size], backwards[j] = j, against
                size += 1
                last = solid.lines[lines[j], 0] if against else solid.lines[lines[j], 1]
                j = at[last, 0] + at[last, 1] - j if meeting[last] == 2 else -1  # the other of the two
            _number(lines, walk[:size], leader, place)
    return leader, place, backwards


@kernel()
def _number(lines: Ints, walk: Ints, leader: Ints, place: Ints) -> None:
    """Let the lines of one walk be led by the first of them."""
    first = lines[walk[0]]
    for j in walk:
        first = min(first, lines[j])
    for rank in range(len(walk)):
        leader[walk[rank]], place[walk[rank]] = first, rank
