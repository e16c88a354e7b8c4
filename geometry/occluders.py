"""What of a model's lines its triangles hide from a camera."""

import math
from typing import NamedTuple

import numpy as np

from geometry.triangle_tree import TriangleTree
from numerics.arrays import Flags, Floats, Ints
from numerics.kernels import kernel

Place = tuple[float, float, float]

EDGE_ON_SHARE = 1e-12  # of the model's diameter: a camera this near a triangle's plane sees nothing of it


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
    tree: TriangleTree
    triangle_face: Ints
    face_point: Floats
    face_normal: Floats
    two_sided: Flags
    diameter: float


class Hiders(NamedTuple):
    """What may hide lines from one place.

    Attributes
    ----------
    tree : of the model's triangles.
    before : (T,), how far the place is before each one's plane, negative on its other side, metres, in the
        tree's order; 0 for those that are not seen from there.
    centre : (3,), the place, target frame.
    touch : how far behind a triangle a point is hidden, metres.
    """

    tree: TriangleTree
    before: Floats
    centre: Floats
    touch: float


@kernel()
def hiders_of(solid: Solid, towards: Flags, centre: Floats, touch: float) -> Hiders:
    """What may hide lines from a camera's centre (3,), target frame; ``towards`` (F,) of the faces."""
    tree, faces, two_sided = solid.tree, solid.triangle_face, solid.two_sided
    triangle, plane, edge_on = tree.triangle, tree.plane, EDGE_ON_SHARE * solid.diameter
    before, x, y, z = np.zeros(len(triangle)), centre[0], centre[1], centre[2]
    for n in range(len(triangle)):
        face = faces[triangle[n]]
        if towards[face] or two_sided[face]:
            away = plane[n, 0] * x + plane[n, 1] * y + plane[n, 2] * z - plane[n, 3]
            before[n] = away if abs(away) > edge_on else 0.0
    return Hiders(tree, before, centre, touch)


@kernel()
def hidden_parts(hiders: Hiders, start: Floats, end: Floats, hidden: Floats) -> int:
    """How many intervals of a line, from 0 at its start to 1, are hidden: the first of ``hidden`` (T, 2).

    Triangles are looked for in the triangle that the camera spans with the line's ends (3,), target frame:
    boxes that lie on one side of its plane, or beside it in that plane, hold none that hides. It ends just
    before the line: what touches that does not hide it.
    """
    tree, centre, before, touch, count = hiders.tree, hiders.centre, hiders.before, hiders.touch, 0
    boxes, after, first, last, plane = tree.boxes, tree.after, tree.first, tree.last, tree.plane
    cx, cy, cz = centre[0], centre[1], centre[2]
    ax, ay, az = start[0] - cx, start[1] - cy, start[2] - cz
    bx, by, bz = end[0] - cx, end[1] - cy, end[2] - cz
    nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    lx, ly, lz = ny * az - nz * ay, nz * ax - nx * az, nx * ay - ny * ax  # inwards from the side of the start
    rx, ry, rz = by * nz - bz * ny, bz * nx - bx * nz, bx * ny - by * nx  # and of the end
    farthest = math.sqrt(max(ax * ax + ay * ay + az * az, bx * bx + by * by + bz * bz))
    near = max(0.0, 1.0 - touch / farthest)
    low_x, high_x = near * min(ax, bx, 0.0), near * max(ax, bx, 0.0)
    low_y, high_y = near * min(ay, by, 0.0), near * max(ay, by, 0.0)
    low_z, high_z = near * min(az, bz, 0.0), near * max(az, bz, 0.0)
    box = 0
    while box < len(after):
        x, y, z = boxes[box, 0] - cx, boxes[box, 1] - cy, boxes[box, 2] - cz
        hx, hy, hz = boxes[box, 3], boxes[box, 4], boxes[box, 5]
        if (
            abs(nx * x + ny * y + nz * z) > abs(nx) * hx + abs(ny) * hy + abs(nz) * hz
            or x + hx < low_x or x - hx > high_x or y + hy < low_y or y - hy > high_y
            or z + hz < low_z or z - hz > high_z
            or lx * x + ly * y + lz * z < -(abs(lx) * hx + abs(ly) * hy + abs(lz) * hz)
            or rx * x + ry * y + rz * z < -(abs(rx) * hx + abs(ry) * hy + abs(rz) * hz)
        ):  # fmt: skip
            box = after[box]
            continue
        for n in range(first[box], last[box]):
            away = before[n]
            if away == 0.0:
                continue
            sign = -1.0 if away > 0.0 else 1.0
            x, y, z = sign * plane[n, 0], sign * plane[n, 1], sign * plane[n, 2]
            behind_a = x * ax + y * ay + z * az - abs(away) - touch
            behind_b = x * bx + y * by + z * bz - abs(away) - touch
            if behind_a < 0.0 and behind_b < 0.0:
                continue
            low, high = 0.0, 1.0
            if behind_a < 0.0:
                low = behind_a / (behind_a - behind_b)
            elif behind_b < 0.0:
                high = behind_a / (behind_a - behind_b)
            low, high = _in_cone(tree.corners[n], (cx, cy, cz), (ax, ay, az), (bx, by, bz), sign, low, high)
            if low <= high:
                hidden[count, 0], hidden[count, 1] = low, high
                count += 1
        box += 1
    return count


@kernel()
def hidden_point(hiders: Hiders, point: Floats) -> bool:
    """Whether a point (3,) of a line, target frame, is hidden; the same as `hidden_parts` says of it."""
    tree, centre, before, touch = hiders.tree, hiders.centre, hiders.before, hiders.touch
    boxes, after, first, last, plane = tree.boxes, tree.after, tree.first, tree.last, tree.plane
    cx, cy, cz = centre[0], centre[1], centre[2]
    px, py, pz = point[0] - cx, point[1] - cy, point[2] - cz
    near = 1.0 - touch / math.sqrt(px * px + py * py + pz * pz)
    over_x, over_y, over_z = _over(px), _over(py), _over(pz)
    reach_x, reach_y, reach_z = abs(over_x), abs(over_y), abs(over_z)
    box = 0
    while box < len(after):
        x, y, z = (boxes[box, 0] - cx) * over_x, (boxes[box, 1] - cy) * over_y, (boxes[box, 2] - cz) * over_z
        hx, hy, hz = boxes[box, 3] * reach_x, boxes[box, 4] * reach_y, boxes[box, 5] * reach_z
        if max(x - hx, y - hy, z - hz, 0.0) > min(x + hx, y + hy, z + hz, near):
            box = after[box]
            continue
        for n in range(first[box], last[box]):
            away = before[n]
            if away == 0.0:
                continue
            sign = -1.0 if away > 0.0 else 1.0
            x, y, z = sign * plane[n, 0], sign * plane[n, 1], sign * plane[n, 2]
            if x * px + y * py + z * pz < abs(away) + touch:
                continue
            here = (px, py, pz)
            low, high = _in_cone(tree.corners[n], (cx, cy, cz), here, here, sign, 0.0, 1.0)
            if low <= high:
                return True
        box += 1
    return False


@kernel(inline="always")
def _over(number: float) -> float:
    """One over it; of nearly nothing, which is too little to tell a side, very much."""
    return 1.0 / number if abs(number) > 1e-300 else 1e300


@kernel(inline="always")
def _in_cone(
    corners: Floats, centre: Place, a: Place, b: Place, sign: float, low: float, high: float
) -> tuple[float, float]:
    """What of a part of a line lies in the cone of a triangle (3, 3); from > to: nothing.

    ``a``, ``b`` are the line's ends, seen from the camera's centre; ``sign`` is -1 where the corners go
    round the other way.
    """
    for i in range(3):
        j = (i + 1) % 3
        px, py, pz = corners[i, 0] - centre[0], corners[i, 1] - centre[1], corners[i, 2] - centre[2]
        qx, qy, qz = corners[j, 0] - centre[0], corners[j, 1] - centre[1], corners[j, 2] - centre[2]
        x, y, z = sign * (py * qz - pz * qy), sign * (pz * qx - px * qz), sign * (px * qy - py * qx)
        within_a, within_b = x * a[0] + y * a[1] + z * a[2], x * b[0] + y * b[1] + z * b[2]
        if within_a < 0.0:
            low = max(low, within_a / (within_a - within_b)) if within_b >= 0.0 else 2.0
        elif within_b < 0.0:
            high = min(high, within_a / (within_a - within_b))
    return low, high
