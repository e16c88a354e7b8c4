"""A model's triangles in a tree of boxes: what lies between a line and the camera is found quickly."""

from typing import NamedTuple

import numpy as np

from numerics.arrays import Floats, Ints
from numerics.kernels import kernel

MOST_IN_LEAF = 4  # triangles; chosen by hand
BOX_SLACK_SHARE = 1e-9  # of the model's diameter, by which boxes are larger than what they hold: for rounding


class TriangleTree(NamedTuple):
    """Boxes in boxes, N of them, each before those in it, and the triangles (T) in the order of the leaves.

    Attributes
    ----------
    boxes : (N, 6), middle and half the size of each, metres.
    after : (N,), the next box that is not in this one.
    first, last : (N,), the triangles of a leaf, from and to before; none of any other box.
    triangle : (T,), index of each.
    corners : (T, 3, 3), of each, metres.
    plane : (T, 4), unit normal by the order of the corners, and the plane's distance from the origin.
    """

    boxes: Floats
    after: Ints
    first: Ints
    last: Ints
    triangle: Ints
    corners: Floats
    plane: Floats


@kernel()
def tree_of(vertices: Floats, triangles: Ints, diameter: float) -> TriangleTree:
    """The tree of triangles (T, 3) of vertices (V, 3), split at the mean along the longest side."""
    count = len(triangles)
    lows, highs = np.empty((count, 3)), np.empty((count, 3))
    for i in range(count):
        p, q, r = triangles[i]
        for k in range(3):
            a, b, c = vertices[p, k], vertices[q, k], vertices[r, k]
            lows[i, k], highs[i, k] = min(a, b, c), max(a, b, c)
    order, most = np.arange(count), max(1, 2 * count)
    boxes = np.empty((most, 6))
    after, first, last = np.empty(most, np.int64), np.zeros(most, np.int64), np.zeros(most, np.int64)
    waiting, waits, box = np.empty((most, 2), np.int64), 1, 0
    waiting[0] = 0, count
    while waits > 0:
        waits -= 1
        start, end = waiting[waits]
        _bound(lows, highs, order[start:end], BOX_SLACK_SHARE * diameter, boxes[box])
        cut = _split(lows, highs, order[start:end]) if end - start > MOST_IN_LEAF else 0
        if cut == 0:
            first[box], last[box] = start, end
        else:
            waiting[waits] = start + cut, end
            waiting[waits + 1] = start, start + cut
            waits += 2
        after[box] = cut
        box += 1
    for i in range(box - 1, -1, -1):
        after[i] = i + 1 if after[i] == 0 else after[after[i + 1]]
    corners, plane = _of_triangles(vertices, triangles, order)
    return TriangleTree(boxes[:box], after[:box], first[:box], last[:box], order, corners, plane)


@kernel()
def _bound(lows: Floats, highs: Floats, some: Ints, slack: float, out: Floats) -> None:
    """Middle and half the size (6,) of the box around some of the boxes (T, 3)."""
    for k in range(3):
        low, high = np.inf, -np.inf
        for i in some:
            low, high = min(low, lows[i, k]), max(high, highs[i, k])
        out[k], out[3 + k] = 0.5 * (low + high), 0.5 * (high - low) + slack


@kernel()
def _split(lows: Floats, highs: Floats, some: Ints) -> int:
    """Sort some of the boxes (T, 3) into two parts, in place; how many are in the first."""
    axis, widest, mean = 0, -1.0, 0.0
    for k in range(3):
        low, high, total = np.inf, -np.inf, 0.0
        for i in some:
            place = lows[i, k] + highs[i, k]
            low, high, total = min(low, place), max(high, place), total + place
        if high - low > widest:
            axis, widest, mean = k, high - low, total / len(some)
    cut = 0
    for n in range(len(some)):
        i = some[n]
        if lows[i, axis] + highs[i, axis] < mean:
            some[n], some[cut] = some[cut], i
            cut += 1
    return cut if 0 < cut < len(some) else len(some) // 2


@kernel()
def _of_triangles(vertices: Floats, triangles: Ints, order: Ints) -> tuple[Floats, Floats]:
    """Corners (T, 3, 3) and planes (T, 4) of triangles in some order, see `TriangleTree`."""
    corners, plane = np.empty((len(order), 3, 3)), np.empty((len(order), 4))
    for n in range(len(order)):
        p, q, r = triangles[order[n]]
        a, b, c = vertices[p], vertices[q], vertices[r]
        square = 0.0
        for k in range(3):
            corners[n, 0, k], corners[n, 1, k], corners[n, 2, k] = a[k], b[k], c[k]
            i, j = (k + 1) % 3, (k + 2) % 3
            plane[n, k] = (b[i] - a[i]) * (c[j] - a[j]) - (b[j] - a[j]) * (c[i] - a[i])
            square += plane[n, k] ** 2
        for k in range(3):
            plane[n, k] /= np.sqrt(square) if square > 0.0 else 1.0
        plane[n, 3] = plane[n, 0] * a[0] + plane[n, 1] * a[1] + plane[n, 2] * a[2]
    return corners, plane
