"""The triangles of a model that can hide something: what each hides of a line, and where they are."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from numerics.kernels import kernel

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]

# Chosen by hand where nothing else is said.
FEW = 64  # triangles that are looked through one by one; more are sorted into ...
TILES_PER_SIDE = 32  # ... so many tiles across the lines' part of the image and down


class Solid(NamedTuple):
    """A model as the kernels take it; see Model for the meanings, `chains` for the lines' chains and arcs."""

    vertices: Floats
    lines: Ints
    line_faces: Ints
    smooth: Flags
    chain: Ints
    leader: Ints
    place: Ints
    backwards: Flags
    triangles: Ints
    triangle_face: Ints
    face_point: Floats
    face_normal: Floats
    two_sided: Flags
    diameter: float


@kernel()
def occluders(
    solid: Solid, towards: Flags, points: Floats, near: float, intrinsics: Floats
) -> tuple[Floats, Floats]:
    """Triangles that can hide something.

    Returns
    -------
    planes : (K, 14), the inner normals of the cone's three sides, then unit normal and offset of the
        triangle's plane, positive behind it, and the least depth.
    boxes : (K, 4), bounds in the image; everything when a corner is not in front.
    """
    planes = np.empty((len(solid.triangles), 14))
    boxes = np.empty((len(solid.triangles), 4))
    count = 0
    for i in range(len(solid.triangles)):
        face = solid.triangle_face[i]
        if not (towards[face] or solid.two_sided[face]):
            continue
        corners = solid.triangles[i]
        if points[corners[0], 2] < near and points[corners[1], 2] < near and points[corners[2], 2] < near:
            continue
        row, box = planes[count], boxes[count]
        for k in range(3):
            a, b = corners[k], corners[(k + 1) % 3]
            row[3 * k] = points[a, 1] * points[b, 2] - points[a, 2] * points[b, 1]
            row[3 * k + 1] = points[a, 2] * points[b, 0] - points[a, 0] * points[b, 2]
            row[3 * k + 2] = points[a, 0] * points[b, 1] - points[a, 1] * points[b, 0]
        c = corners[2]
        volume = row[0] * points[c, 0] + row[1] * points[c, 1] + row[2] * points[c, 2]
        for k in range(3):
            row[9 + k] = row[k] + row[3 + k] + row[6 + k]  # (b − a) × (c − a)
        length = math.sqrt(row[9] * row[9] + row[10] * row[10] + row[11] * row[11])
        if abs(volume) <= 1e-12 * length * solid.diameter:
            continue  # seen edge-on
        sign = 1.0 if volume > 0.0 else -1.0
        for k in range(9):
            row[k] *= sign
        for k in range(9, 12):
            row[k] *= sign / length
        row[12] = abs(volume) / length
        row[13] = min(points[corners[0], 2], points[corners[1], 2], points[c, 2])
        box[0] = box[1] = np.inf
        box[2] = box[3] = -np.inf
        for k in range(3):
            depth = points[corners[k], 2]
            if depth < near:
                box[0] = box[1] = -np.inf
                box[2] = box[3] = np.inf
                break
            x = intrinsics[0] * points[corners[k], 0] / depth + intrinsics[2]
            y = intrinsics[1] * points[corners[k], 1] / depth + intrinsics[3]
            box[0], box[1] = min(box[0], x), min(box[1], y)
            box[2], box[3] = max(box[2], x), max(box[3], y)
        count += 1
    return planes[:count], boxes[:count]


@kernel()
def hidden_part(plane: Floats, start: Floats, end: Floats, touch: float) -> tuple[float, float]:
    """Interval (from, to) of the segment start–end that a triangle hides; from > to: nothing."""
    low, high = 0.0, 1.0
    for k in range(4):
        at_start = plane[3 * k] * start[0] + plane[3 * k + 1] * start[1] + plane[3 * k + 2] * start[2]
        at_end = plane[3 * k] * end[0] + plane[3 * k + 1] * end[1] + plane[3 * k + 2] * end[2]
        if k == 3:
            at_start -= plane[12] + touch
            at_end -= plane[12] + touch
        if at_start < 0.0:
            if at_end < 0.0:
                return 1.0, 0.0
            low = max(low, at_start / (at_start - at_end))
        elif at_end < 0.0:
            high = min(high, at_start / (at_start - at_end))
    return low, high


class Tiles(NamedTuple):
    """Which triangles lie over each tile of the image; see `tiled`.

    Attributes
    ----------
    origin, size : (2,), where the first tile starts, and how large each is, px.
    side : number of tiles across and down.
    first : (side * side + 1,), where the triangles of each tile start in ``triangle``.
    triangle : (K,), indices.
    """

    origin: Floats
    size: Floats
    side: int
    first: Ints
    triangle: Ints


@kernel()
def _tile(value: float, origin: float, size: float, side: int) -> int:
    return int(min(max((value - origin) / size, 0.0), side - 1.0))


@kernel()
def tiled(boxes: Floats, low: Floats, high: Floats) -> Tiles:
    """Sort triangles with image bounds (K, 4) into the tiles of a rectangle, ``low`` to ``high`` (2,), px."""
    side = 1 if len(boxes) <= FEW else TILES_PER_SIDE
    size = np.maximum(high - low, 1e-9) / side
    first = np.zeros(side * side + 1, dtype=np.int64)
    triangle = np.empty(0, dtype=np.int64)
    for fill in range(2):
        for k in range(len(boxes)):
            box = boxes[k]
            if box[0] > high[0] or box[2] < low[0] or box[1] > high[1] or box[3] < low[1]:
                continue
            for row in range(_tile(box[1], low[1], size[1], side), _tile(box[3], low[1], size[1], side) + 1):
                left, right = _tile(box[0], low[0], size[0], side), _tile(box[2], low[0], size[0], side)
                for column in range(left, right + 1):
                    tile = row * side + column
                    if fill == 0:
                        first[tile + 1] += 1
                    else:
                        triangle[first[tile]] = k
                        first[tile] += 1
        if fill == 0:
            first = np.cumsum(first)
            triangle = np.empty(first[-1], dtype=np.int64)
    for tile in range(side * side, 0, -1):  # filling has moved each start to its end
        first[tile] = first[tile - 1]
    first[0] = 0
    return Tiles(low, size, side, first, triangle)


@kernel()
def near_line(tiles: Tiles, box: Floats, stamp: Ints, number: int, out: Ints) -> int:
    """Count of the triangles in the tiles that a line's image bounds (4,) touch; they in ``out``, each once.

    ``stamp`` (K,) remembers the ``number`` of the line a triangle was last listed for.
    """
    count = 0
    origin, size, side = tiles.origin, tiles.size, tiles.side
    left, right = _tile(box[0], origin[0], size[0], side), _tile(box[2], origin[0], size[0], side)
    top, bottom = _tile(box[1], origin[1], size[1], side), _tile(box[3], origin[1], size[1], side)
    for row in range(top, bottom + 1):
        for column in range(left, right + 1):
            tile = row * side + column
            for m in range(tiles.first[tile], tiles.first[tile + 1]):
                k = tiles.triangle[m]
                if stamp[k] != number:
                    stamp[k] = number
                    out[count] = k
                    count += 1
    return count


class Hiders(NamedTuple):
    """What may hide lines, and room to work in.

    Attributes
    ----------
    tiles, planes, boxes : see `tiled` and `occluders`.
    stamp, listed : (K,), for `near_line`.
    hidden : (K, 2), for the intervals of a line that are hidden.
    """

    tiles: Tiles
    planes: Floats
    boxes: Floats
    stamp: Ints
    listed: Ints
    hidden: Floats


@kernel()
def hiders_of(
    solid: Solid, towards: Flags, points: Floats, near: float, intrinsics: Floats, low: Floats, high: Floats
) -> Hiders:
    """What may hide lines that lie between ``low`` and ``high`` (2,) in the image; see `occluders`."""
    planes, boxes = occluders(solid, towards, points, near, intrinsics)
    count = len(planes)
    return Hiders(
        tiled(boxes, low, high),
        planes,
        boxes,
        np.full(count, -1, dtype=np.int64),
        np.empty(count, dtype=np.int64),
        np.empty((count, 2)),
    )


@kernel()
def hidden_parts(hiders: Hiders, ends: Floats, ends3: Floats, touch: float, number: int) -> int:
    """How many intervals of a line are hidden, which are then in ``hiders.hidden``.

    Parameters
    ----------
    ends, ends3 : (4,) px and (2, 3) metres, in the image and in the camera frame.
    number : of the line, another one for each.
    """
    span = np.array(
        [min(ends[0], ends[2]), min(ends[1], ends[3]), max(ends[0], ends[2]), max(ends[1], ends[3])]
    )
    farthest, count = max(ends3[0, 2], ends3[1, 2]), 0
    for m in range(near_line(hiders.tiles, span, hiders.stamp, number, hiders.listed)):
        k = hiders.listed[m]
        box = hiders.boxes[k]
        if hiders.planes[k, 13] > farthest or box[0] > span[2] or box[2] < span[0]:
            continue
        if box[1] > span[3] or box[3] < span[1]:
            continue
        low, high = hidden_part(hiders.planes[k], ends3[0], ends3[1], touch)
        if low <= high:
            hiders.hidden[count, 0], hiders.hidden[count, 1] = low, high
            count += 1
    return count
