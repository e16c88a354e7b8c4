"""Lines of a model that face the camera, cut to what of them lies in front of it and in the image."""

import math
from typing import NamedTuple

import numpy as np

from geometry.occluders import Solid
from numerics.arrays import Flags, Floats, Ints
from numerics.kernels import kernel


class LinesInView(NamedTuple):
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
def lines_in_view(
    solid: Solid, towards: Flags, points: Floats, intrinsics: Floats, bounds: Floats, near: float
) -> LinesInView:
    """Lines that face the camera, cut to what lies in front and in the image; ``points`` in its frame."""
    count = len(solid.lines)
    kept, lengths = np.empty(count, dtype=np.int64), np.empty(count)
    seen, cut = np.empty((count, 4)), np.empty((count, 2, 3))
    lines, line_faces, smooth, two_sided = solid.lines, solid.line_faces, solid.smooth, solid.two_sided
    n = 0  # of the next line that is kept
    for i in range(count):
        if not _line_turned(line_faces, smooth, two_sided, towards, i):
            continue
        a, b = lines[i, 0], lines[i, 1]
        depth_a, depth_b = points[a, 2], points[b, 2]
        if depth_a <= near and depth_b <= near:
            continue
        low = max(0.0, (near - depth_a) / (depth_b - depth_a)) if depth_a < near else 0.0
        high = min(1.0, (near - depth_a) / (depth_b - depth_a)) if depth_b < near else 1.0
        for k in range(3):
            step = points[b, k] - points[a, k]
            cut[n, 0, k] = points[a, k] + low * step
            cut[n, 1, k] = points[a, k] + high * step
        for side in range(2):
            seen[n, 2 * side] = intrinsics[0] * cut[n, side, 0] / cut[n, side, 2] + intrinsics[2]
            seen[n, 2 * side + 1] = intrinsics[1] * cut[n, side, 1] / cut[n, side, 2] + intrinsics[3]
        low, high = _clipped(seen, n, bounds)
        if low > 0.0 or high < 1.0:
            if low >= high:
                continue
            x, y, dx, dy = seen[n, 0], seen[n, 1], seen[n, 2] - seen[n, 0], seen[n, 3] - seen[n, 1]
            seen[n, 0], seen[n, 1] = x + low * dx, y + low * dy
            seen[n, 2], seen[n, 3] = x + high * dx, y + high * dy
            inverse_a, inverse_b = 1.0 / cut[n, 0, 2], 1.0 / cut[n, 1, 2]
            at_low = low * inverse_b / (inverse_a + low * (inverse_b - inverse_a))
            at_high = high * inverse_b / (inverse_a + high * (inverse_b - inverse_a))
            for k in range(3):
                first, step = cut[n, 0, k], cut[n, 1, k] - cut[n, 0, k]
                cut[n, 0, k] = first + at_low * step
                cut[n, 1, k] = first + at_high * step
        length = math.hypot(seen[n, 2] - seen[n, 0], seen[n, 3] - seen[n, 1])
        if length <= 0.0:
            continue
        kept[n], lengths[n] = i, length
        n += 1
    return LinesInView(kept[:n], seen[:n], cut[:n], lengths[:n])


@kernel()
def long_enough(solid: Solid, seen: LinesInView, min_line_px: float) -> LinesInView:
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
    return LinesInView(seen.line[keep], seen.image[keep], seen.ends[keep], seen.length[keep])


@kernel()
def faces_towards(solid: Solid, centre: Floats) -> Flags:
    """Whether each face's outer side looks at the camera centre (target frame)."""
    count = len(solid.face_normal)
    out = np.empty(count, dtype=np.bool_)
    for f in range(count):
        towards = 0.0
        for k in range(3):
            towards += solid.face_normal[f, k] * (centre[k] - solid.face_point[f, k])
        out[f] = towards > 0.0
    return out


@kernel(inline="always")
def _line_turned(line_faces: Ints, smooth: Flags, two_sided: Flags, towards: Flags, line: int) -> bool:
    """Whether the faces beside a line let it be seen, other parts of the model apart."""
    f, g = line_faces[line, 0], line_faces[line, 1]
    if smooth[line] and f >= 0 and g >= 0:
        return bool(towards[f] != towards[g])
    if f < 0 and g < 0:
        return True
    if f >= 0 and (towards[f] or two_sided[f]):
        return True
    return bool(g >= 0 and (towards[g] or two_sided[g]))


@kernel()
def _clipped(ends: Floats, row: int, bounds: Floats) -> tuple[float, float]:
    """Part (from, to) of one segment of (N, 4) [x1, y1, x2, y2] inside bounds [x0, y0, x1, y1].

    From > to: none.
    """
    low, high = 0.0, 1.0
    for k in range(2):
        start, step = ends[row, k], ends[row, k + 2] - ends[row, k]
        if step == 0.0:
            if start < bounds[k] or start > bounds[k + 2]:
                return 1.0, 0.0
            continue
        first, second = (bounds[k] - start) / step, (bounds[k + 2] - start) / step
        low, high = max(low, min(first, second)), min(high, max(first, second))
    return low, high
