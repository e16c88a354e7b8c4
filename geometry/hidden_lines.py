"""Samples along the visible parts of a model's lines, by exact hidden-line removal.

A triangle hides the part of a line that lies behind its plane and in the cone that it spans with the camera.
Cone and half-space are convex, so that part is one interval of the line, found in closed form from the
signed distances of the two ends of the line: no ray is cast per sample.
"""

from typing import NamedTuple

import numpy as np

from geometry.lines_in_view import LinesInView, faces_towards, lines_in_view, long_enough
from geometry.occluders import Hiders, Solid, hidden_parts, hidden_point, hiders_of
from geometry.outlines import line_direction, linked, outline_direction, outline_tangent
from numerics.arrays import Flags, Floats, Ints
from numerics.kernels import kernel

ON_FACE_SHARE = 1e-4  # of the diameter behind a face, a point lies on it: a block on a plate (by hand)
SAMPLES_A_LINE = 5.0  # at least, down to the densest spacing, for what is said of a line's straightness
MOST_SINGLE_SAMPLES = 4  # of a line: no more are looked at one by one, which is quicker
NEAR_PLANE_SHARE = 1e-3  # of the model's diameter: what is nearer to the camera's plane may be anywhere


class Trace(NamedTuple):
    """Samples of visible lines; N of them.

    Attributes
    ----------
    line : (N,), whose they are; of arcs and outlines of many facets the first one's: see `Samples`.
    points, along : (N, 3), place and unit direction, target frame; of an outline in its tangent plane.
    image, direction : (N, 2), px, and unit.
    px : (N,), what each stands for.
    own : (N,), the facet's line.
    outline : (N,), of facets of a curved surface that runs otherwise than the facet's line.
    """

    line: Ints
    points: Floats
    along: Floats
    image: Floats
    direction: Floats
    px: Floats
    own: Ints
    outline: Flags


@kernel()
def trace(
    solid: Solid,
    rotation: Floats,
    translation: Floats,
    intrinsics: Floats,
    bounds: Floats,
    spacing_px: float,
    densest_px: float,
    min_line_px: float,
) -> Trace:
    """Samples of the visible lines for a camera without distortion.

    Parameters
    ----------
    rotation, translation : (3, 3), (3,), camera_T_target.
    intrinsics : (4,), fx, fy, cx, cy in px.
    spacing_px, densest_px : between the samples; of lines that have few of them they are that dense.
    bounds : (4,), the part of the image plane to fill: least x, least y, greatest x, greatest y, px.
    """
    near = NEAR_PLANE_SHARE * solid.diameter
    points, centre = _in_camera_frame(solid, rotation, translation)
    towards = faces_towards(solid, centre)
    seen = long_enough(solid, lines_in_view(solid, towards, points, intrinsics, bounds, near), min_line_px)
    course, outline = _courses(solid, seen, rotation, intrinsics, min_line_px)
    leader, place, backwards = linked(solid, seen.line, course)
    in_order = np.argsort(leader * (len(solid.lines) + 1) + place)
    numbers, px = _spread(solid, seen, leader, in_order, spacing_px, densest_px, min_line_px)
    hiders = hiders_of(solid, towards, centre, ON_FACE_SHARE * solid.diameter)
    hidden, written = np.empty((len(solid.triangle_face), 2)), 0
    line, out, along3, image, direction, stands, own, of_outline = _room_for(numbers.sum())
    for j in in_order[numbers[in_order] > 0]:
        number, i, ends, ends3 = numbers[j], seen.line[j], seen.image[j], seen.ends[j]
        count = _hidden(hiders, rotation, translation, ends3, hidden) if number > MOST_SINGLE_SAMPLES else 0
        sign = -1.0 if backwards[j] else 1.0
        inverse_a, inverse_b = 1.0 / ends3[0, 2], 1.0 / ends3[1, 2]
        for k in range(number):
            along = (k + 0.5) / number if sign > 0.0 else 1.0 - (k + 0.5) / number
            at = along * inverse_b / (inverse_a + along * (inverse_b - inverse_a))
            if _within_any(hidden, count, at):
                continue
            _on_target(rotation, translation, ends3, at, out[written])
            if number <= MOST_SINGLE_SAMPLES and hidden_point(hiders, out[written]):
                continue
            line[written], own[written], of_outline[written] = leader[j], i, outline[j]
            stands[written] = px[j]
            image[written, 0] = ends[0] + along * (ends[2] - ends[0])
            image[written, 1] = ends[1] + along * (ends[3] - ends[1])
            direction[written, 0], direction[written, 1] = sign * course[j, 0], sign * course[j, 1]
            if outline[j]:
                outline_tangent(solid, i, out[written], centre, along3[written])
            else:
                line_direction(solid, i, sign, along3[written])
            written += 1
    return Trace(
        line[:written], out[:written], along3[:written], image[:written], direction[:written],
        stands[:written], own[:written], of_outline[:written],
    )  # fmt: skip


@kernel()
def _room_for(total: int) -> tuple[Ints, Floats, Floats, Floats, Floats, Floats, Ints, Flags]:
    """Arrays for the fields of a trace of so many samples, in their order."""
    numbers, places = (np.empty(total, np.int64), np.empty(total, np.int64)), np.empty((2, total, 3))
    pixels, px, outline = np.empty((2, total, 2)), np.empty(total), np.empty(total, np.bool_)
    return numbers[0], places[0], places[1], pixels[0], pixels[1], px, numbers[1], outline


@kernel()
def _hidden(hiders: Hiders, rotation: Floats, translation: Floats, ends: Floats, hidden: Floats) -> int:
    """How many parts of a line (2, 3) in the camera's frame are hidden; as shares of it, output."""
    start, end = np.empty(3), np.empty(3)
    _on_target(rotation, translation, ends, 0.0, start)
    _on_target(rotation, translation, ends, 1.0, end)
    return int(hidden_parts(hiders, start, end, hidden))


@kernel()
def _in_camera_frame(solid: Solid, rotation: Floats, translation: Floats) -> tuple[Floats, Floats]:
    """The vertices in the camera frame, (V, 3), and the camera's centre in the target's, (3,)."""
    points = np.empty_like(solid.vertices)
    for i in range(len(points)):
        x, y, z = solid.vertices[i]
        for k in range(3):
            points[i, k] = rotation[k, 0] * x + rotation[k, 1] * y + rotation[k, 2] * z + translation[k]
    x, y, z = translation
    centre = np.empty(3)
    for k in range(3):
        centre[k] = -(rotation[0, k] * x + rotation[1, k] * y + rotation[2, k] * z)
    return points, centre


@kernel()
def _on_target(rotation: Floats, translation: Floats, ends: Floats, at: float, out: Floats) -> None:
    """The point a share of the way between two ends (2, 3) in the camera's frame, in the target's."""
    x = ends[0, 0] + at * (ends[1, 0] - ends[0, 0]) - translation[0]
    y = ends[0, 1] + at * (ends[1, 1] - ends[0, 1]) - translation[1]
    z = ends[0, 2] + at * (ends[1, 2] - ends[0, 2]) - translation[2]
    for c in range(3):
        out[c] = rotation[0, c] * x + rotation[1, c] * y + rotation[2, c] * z


@kernel()
def _within_any(intervals: Floats, count: int, at: float) -> bool:
    """Whether one of the first intervals, (count, 2), holds a number."""
    for m in range(count):  # noqa: SIM110  # kernels have no generators
        if intervals[m, 0] <= at <= intervals[m, 1]:
            return True
    return False


@kernel()
def _courses(
    solid: Solid, seen: LinesInView, rotation: Floats, intrinsics: Floats, min_line_px: float
) -> tuple[Floats, Flags]:
    """Unit directions of the lines in the image, (K, 2), and which are those of an outline instead, (K,)."""
    course, outline = np.empty((len(seen.line), 2)), np.zeros(len(seen.line), dtype=np.bool_)
    for j in range(len(course)):
        i, ends = seen.line[j], seen.image[j]
        x, y = (ends[2] - ends[0]) / seen.length[j], (ends[3] - ends[1]) / seen.length[j]
        outline[j] = seen.length[j] < min_line_px and solid.smooth[i] and solid.line_faces[i, 1] >= 0
        if outline[j]:
            x, y = outline_direction(solid, i, rotation, intrinsics, x, y)
        course[j, 0], course[j, 1] = x, y
    return course, outline


@kernel()
def _spread(
    solid: Solid,
    seen: LinesInView,
    leader: Ints,
    in_order: Ints,
    spacing_px: float,
    densest_px: float,
    min_line_px: float,
) -> tuple[Ints, Floats]:
    """How many samples each line has, (K,), and the image length that each of them stands for, (K,).

    Those of facets are spread evenly along all of their chain, denser where a line would have only few.
    """
    numbers, px = np.zeros(len(leader), dtype=np.int64), np.empty(len(leader))
    carried = np.zeros(solid.chain.max() + 1 if len(solid.chain) else 0)
    start = 0
    while start < len(in_order):
        end, whole = start, 0.0
        while end < len(in_order) and leader[in_order[end]] == leader[in_order[start]]:
            whole += seen.length[in_order[end]]
            end += 1
        spacing = min(spacing_px, max(densest_px, whole / SAMPLES_A_LINE))
        for j in in_order[start:end]:
            length, chain = seen.length[j], solid.chain[seen.line[j]]
            if end == start + 1 and length >= min_line_px:
                numbers[j] = max(1, int(length / spacing + 0.5))
                px[j] = length / numbers[j]
            else:
                before = carried[chain]
                carried[chain] = before + length / spacing
                numbers[j] = int(carried[chain] + 0.5) - int(before + 0.5)
                px[j] = spacing
        start = end
    return numbers, px
