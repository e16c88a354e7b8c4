"""Samples along the visible parts of a model's lines, by exact hidden-line removal.

A triangle hides the part of a line that lies behind its plane and in the cone that it spans with the camera.
Cone and half-space are convex, so that part is one interval of the line, found in closed form from the
signed distances of the two ends of the line: no ray is cast per sample.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geometry.occluders import Solid, hidden_parts, hiders_of
from geometry.outlines import line_direction, linked, outline_direction, outline_tangent
from numerics.kernels import kernel

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]

TOUCH = 1e-4  # a point this fraction of the model's diameter behind a face lies on it: a block on a plate
FEWEST_SAMPLES = 5.0  # of a line, for what is said of its straightness
NEAR = 1e-3  # nearest depth that is drawn, as a fraction of the model's diameter


@kernel()
def _faces_towards(solid: Solid, centre: Floats) -> Flags:
    """Whether each face's outer side looks at the camera centre (target frame)."""
    count = len(solid.face_normal)
    out = np.empty(count, dtype=np.bool_)
    for f in range(count):
        towards = 0.0
        for k in range(3):
            towards += solid.face_normal[f, k] * (centre[k] - solid.face_point[f, k])
        out[f] = towards > 0.0
    return out


@kernel()
def _line_turned(solid: Solid, towards: Flags, line: int) -> bool:
    """Whether the faces beside a line let it be seen, other parts of the model apart."""
    f, g = solid.line_faces[line, 0], solid.line_faces[line, 1]
    if solid.smooth[line] and f >= 0 and g >= 0:
        return bool(towards[f] != towards[g])
    if f < 0 and g < 0:
        return True
    if f >= 0 and (towards[f] or solid.two_sided[f]):
        return True
    return bool(g >= 0 and (towards[g] or solid.two_sided[g]))


@kernel()
def _clipped(ends: Floats, bounds: Floats) -> tuple[float, float]:
    """Part (from, to) of a segment [x1, y1, x2, y2] inside bounds [x0, y0, x1, y1]; from > to: none."""
    low, high = 0.0, 1.0
    for k in range(2):
        start, step = ends[k], ends[k + 2] - ends[k]
        if step == 0.0:
            if start < bounds[k] or start > bounds[k + 2]:
                return 1.0, 0.0
            continue
        first, second = (bounds[k] - start) / step, (bounds[k + 2] - start) / step
        low, high = max(low, min(first, second)), min(high, max(first, second))
    return low, high


@kernel()
def _extent(ends: Floats) -> tuple[Floats, Floats]:
    """Least and greatest x, y (2,) of segments (N, 4); 0 without any."""
    low, high = np.zeros(2), np.zeros(2)
    for k in range(2):
        for i in range(len(ends)):
            least, most = min(ends[i, k], ends[i, k + 2]), max(ends[i, k], ends[i, k + 2])
            low[k] = least if i == 0 else min(low[k], least)
            high[k] = most if i == 0 else max(high[k], most)
    return low, high


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


class _Seen(NamedTuple):
    """Lines that look at the camera, K of them, cut to what lies in front and in the image.

    Attributes
    ----------
    line : (K,), ascending.
    image : (K, 4), ends, px.
    ends : (K, 2, 3), the same in the camera frame.
    length : (K,), px.
    """

    line: Ints
    image: Floats
    ends: Floats
    length: Floats


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
    near = NEAR * solid.diameter
    points = np.empty_like(solid.vertices)
    for i in range(len(points)):
        for k in range(3):
            points[i, k] = (
                rotation[k, 0] * solid.vertices[i, 0]
                + rotation[k, 1] * solid.vertices[i, 1]
                + rotation[k, 2] * solid.vertices[i, 2]
                + translation[k]
            )
    centre = np.empty(3)
    for k in range(3):
        centre[k] = -(
            rotation[0, k] * translation[0]
            + rotation[1, k] * translation[1]
            + rotation[2, k] * translation[2]
        )
    towards = _faces_towards(solid, centre)
    seen = _long_enough(solid, _turned_lines(solid, towards, points, intrinsics, bounds, near), min_line_px)
    course, outline = _courses(solid, seen, rotation, intrinsics, min_line_px)
    leader, place, backwards = linked(solid, seen.line, course)
    in_order = np.argsort(leader * (len(solid.lines) + 1) + place)
    numbers, px = _spread(solid, seen, leader, in_order, spacing_px, densest_px, min_line_px)
    hiders = hiders_of(solid, towards, points, near, intrinsics, *_extent(seen.image))
    total, written = numbers.sum(), 0
    line, own, of_outline = np.empty(total, np.int64), np.empty(total, np.int64), np.empty(total, np.bool_)
    out, along3 = np.empty((total, 3)), np.empty((total, 3))
    image, direction, stands = np.empty((total, 2)), np.empty((total, 2)), np.empty(total)
    for j in in_order:
        number = numbers[j]
        if number == 0:
            continue
        i, ends, ends3 = seen.line[j], seen.image[j], seen.ends[j]
        count = hidden_parts(hiders, ends, ends3, TOUCH * solid.diameter, j)
        sign = -1.0 if backwards[j] else 1.0
        inverse_a, inverse_b = 1.0 / ends3[0, 2], 1.0 / ends3[1, 2]
        for k in range(number):
            along = (k + 0.5) / number if sign > 0.0 else 1.0 - (k + 0.5) / number
            at = along * inverse_b / (inverse_a + along * (inverse_b - inverse_a))
            covered = False
            for m in range(count):
                if hiders.hidden[m, 0] <= at <= hiders.hidden[m, 1]:
                    covered = True
                    break
            if covered:
                continue
            line[written], own[written], of_outline[written] = leader[j], i, outline[j]
            stands[written] = px[j]
            image[written, 0] = ends[0] + along * (ends[2] - ends[0])
            image[written, 1] = ends[1] + along * (ends[3] - ends[1])
            direction[written, 0], direction[written, 1] = sign * course[j, 0], sign * course[j, 1]
            x = ends3[0, 0] + at * (ends3[1, 0] - ends3[0, 0]) - translation[0]
            y = ends3[0, 1] + at * (ends3[1, 1] - ends3[0, 1]) - translation[1]
            z = ends3[0, 2] + at * (ends3[1, 2] - ends3[0, 2]) - translation[2]
            for c in range(3):
                out[written, c] = rotation[0, c] * x + rotation[1, c] * y + rotation[2, c] * z
            if outline[j]:
                outline_tangent(solid, i, out[written], centre, along3[written])
            else:
                line_direction(solid, i, sign, along3[written])
            written += 1
    return Trace(
        line[:written],
        out[:written],
        along3[:written],
        image[:written],
        direction[:written],
        stands[:written],
        own[:written],
        of_outline[:written],
    )


@kernel()
def _courses(
    solid: Solid, seen: _Seen, rotation: Floats, intrinsics: Floats, min_line_px: float
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
def _turned_lines(
    solid: Solid, towards: Flags, points: Floats, intrinsics: Floats, bounds: Floats, near: float
) -> _Seen:
    """Lines that face the camera, cut to what lies in front and in the image; ``points`` in its frame."""
    count = len(solid.lines)
    kept, lengths = np.empty(count, dtype=np.int64), np.empty(count)
    seen, cut = np.empty((count, 4)), np.empty((count, 2, 3))
    kept_count = 0
    for i in range(count):
        if not _line_turned(solid, towards, i):
            continue
        a, b = solid.lines[i, 0], solid.lines[i, 1]
        depth_a, depth_b = points[a, 2], points[b, 2]
        if depth_a <= near and depth_b <= near:
            continue
        ends, ends3 = seen[kept_count], cut[kept_count]
        low = max(0.0, (near - depth_a) / (depth_b - depth_a)) if depth_a < near else 0.0
        high = min(1.0, (near - depth_a) / (depth_b - depth_a)) if depth_b < near else 1.0
        for k in range(3):
            step = points[b, k] - points[a, k]
            ends3[0, k] = points[a, k] + low * step
            ends3[1, k] = points[a, k] + high * step
        for side in range(2):
            ends[2 * side] = intrinsics[0] * ends3[side, 0] / ends3[side, 2] + intrinsics[2]
            ends[2 * side + 1] = intrinsics[1] * ends3[side, 1] / ends3[side, 2] + intrinsics[3]
        low, high = _clipped(ends, bounds)
        if low > 0.0 or high < 1.0:
            if low >= high:
                continue
            x, y, dx, dy = ends[0], ends[1], ends[2] - ends[0], ends[3] - ends[1]
            ends[0], ends[1], ends[2], ends[3] = x + low * dx, y + low * dy, x + high * dx, y + high * dy
            inverse_a, inverse_b = 1.0 / ends3[0, 2], 1.0 / ends3[1, 2]
            at_low = low * inverse_b / (inverse_a + low * (inverse_b - inverse_a))
            at_high = high * inverse_b / (inverse_a + high * (inverse_b - inverse_a))
            for k in range(3):
                first, step = ends3[0, k], ends3[1, k] - ends3[0, k]
                ends3[0, k] = first + at_low * step
                ends3[1, k] = first + at_high * step
        length = math.hypot(ends[2] - ends[0], ends[3] - ends[1])
        if length <= 0.0:
            continue
        kept[kept_count], lengths[kept_count] = i, length
        kept_count += 1
    return _Seen(kept[:kept_count], seen[:kept_count], cut[:kept_count], lengths[:kept_count])


@kernel()
def _long_enough(solid: Solid, seen: _Seen, min_line_px: float) -> _Seen:
    """Without lines that are too short, and whose whole chain is."""
    of_chain = np.zeros(solid.chain.max() + 1 if len(solid.chain) else 0)
    for j in range(len(seen.line)):
        of_chain[solid.chain[seen.line[j]]] += seen.length[j]
    keep = np.empty(len(seen.line), dtype=np.int64)
    count = 0
    for j in range(len(seen.line)):
        if seen.length[j] >= min_line_px or of_chain[solid.chain[seen.line[j]]] >= min_line_px:
            keep[count] = j
            count += 1
    if count == len(seen.line):
        return seen
    keep = keep[:count]
    return _Seen(seen.line[keep], seen.image[keep], seen.ends[keep], seen.length[keep])


@kernel()
def _spread(
    solid: Solid,
    seen: _Seen,
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
        spacing = min(spacing_px, max(densest_px, whole / FEWEST_SAMPLES))
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
