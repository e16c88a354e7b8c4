"""Pixels whose gradient stands out in sharp and clean images, which most are, and whose kernels are narrow.

The gradient is found row by row, and kept of the three rows that tell the pixels of the middle one: that of
a whole image would go through memory, which takes as long as to find it.
"""

from __future__ import annotations

import numpy as np

from numerics.arrays import Field, Grey, Ints
from numerics.kernels import kernel
from numerics.marks import no_marks
from vision_server.channels.gaussian import Kernels
from vision_server.channels.gradient_pixels import (
    Gradient,
    GradientPixels,
    PixelList,
    empty_list,
    list_row,
    with_room,
)

RADIUS = 2  # of the kernels of most images
NEGLIGIBLE = 0.015  # of a kernel's largest tap: less at both ends of both kernels is left out; chosen by hand
TAPS = 2 * RADIUS + 1
ROWS = 3  # of the gradient, that tell the pixels of the middle one


def narrowed(kernels: Kernels) -> Kernels | None:
    """The same kernels of radius 2 without ends that are negligible; None if there are none."""
    cut = len(kernels[0]) // 2 - RADIUS
    if cut > 0 and all(_are_negligible(taps.tolist(), cut) for taps in kernels):
        return kernels[0][cut:-cut].copy(), kernels[1][cut:-cut].copy()
    return kernels if cut == 0 else None


def _are_negligible(taps: list[float], cut: int) -> bool:
    """Whether so many taps at either end of a kernel are."""
    return max(abs(tap) for tap in taps[:cut]) <= NEGLIGIBLE * max(taps)


def narrow_pixels_of_rows(
    linear: Grey | Field, kernels: Kernels, level: Grey, floor_of: Field, first: int, end: int
) -> GradientPixels:
    """`pixels_of_rows` of the gradient of an image, uint8 or float32 (H, W), by kernels of radius 2."""
    listed, found = _list_rows(linear, *kernels, level, floor_of, first, end)
    return listed.first(found)


@kernel(inline="always")
def _load(image: Grey | Field, y: int, ring: Field) -> None:
    """Take a row of the image, which goes on as at its border, into a ring of five."""
    source, target = image[min(max(y, 0), len(image) - 1)], ring[y % TAPS]
    for x in range(len(target)):
        target[x] = np.float32(source[x])


@kernel(inline="always")
def _gradient_of_row(ring: Field, y: int, kernels: Kernels, room: Field, gradient: Gradient) -> None:
    """Gradient (W,) of a row, an output, from the five rows around it; ``room`` (2, W + 4) is to work in."""
    smooth, derivative = kernels
    c, p, q, u, v = smooth[2], smooth[3], smooth[4], derivative[3], derivative[4]
    smoothed, derived = room[0], room[1]
    columns = ring.shape[1]
    a, b, d, e = ring[(y + 1) % TAPS], ring[(y + 2) % TAPS], ring[(y - 1) % TAPS], ring[(y - 2) % TAPS]
    here, inner, inner_derived = ring[y % TAPS], smoothed[2 : columns + 2], derived[2 : columns + 2]
    for x in range(columns):
        inner[x] = c * here[x] + p * (a[x] + d[x]) + q * (b[x] + e[x])
        inner_derived[x] = u * (a[x] - d[x]) + v * (b[x] - e[x])
    for row in (smoothed, derived):
        row[0] = row[1] = row[2]
        row[columns + 2] = row[columns + 3] = row[columns + 1]
    along_x, along_y, length = gradient
    for x in range(columns):
        dx = u * (smoothed[x + 3] - smoothed[x + 1]) + v * (smoothed[x + 4] - smoothed[x])
        beside, further = derived[x + 3] + derived[x + 1], derived[x + 4] + derived[x]
        dy = c * derived[x + 2] + p * beside + q * further
        along_x[x], along_y[x] = dx, dy
        length[x] = np.sqrt(dx * dx + dy * dy)


@kernel(fastmath={"reassoc", "contract", "nsz"})
def _list_rows(
    image: Grey | Field, smooth: Field, derivative: Field, level: Grey, floor_of: Field, first: int, end: int
) -> tuple[PixelList, int]:
    rows, columns = image.shape
    first, end = max(first, 1), min(end, rows - 1)
    ring, room = np.empty((TAPS, columns), np.float32), np.empty((2, columns + 4), np.float32)
    three = np.empty((3, ROWS * columns), np.float32)
    flat = Gradient(three[0], three[1], three[2])
    lowest = floor_of.min()
    listed, marks, found = empty_list(max(end - first, 0) * columns), no_marks(columns), 0
    for row in range(first - 1 - 2 * RADIUS, end + 1):
        _load(image, row + RADIUS, ring)
        if row < first - 1:
            continue
        at, middle = row % ROWS * columns, row - 1
        here = slice(at, at + columns)
        gradient = Gradient(flat.x[here], flat.y[here], flat.magnitude[here])
        _gradient_of_row(ring, row, (smooth, derivative), room, gradient)
        if middle >= first:
            begin = (middle - 1) % ROWS * columns, middle % ROWS * columns, at
            floor = floor_of, lowest, level[min(middle >> 1, len(level) - 1)]
            listed = with_room(listed, found, columns)
            found = list_row(flat, begin, columns, middle * columns, floor, marks, listed, found)
    return listed, found


@kernel(fastmath={"reassoc", "contract", "nsz"})
def narrow_magnitudes(image: Grey | Field, smooth: Field, derivative: Field, rows: Ints) -> Field:
    """Lengths of the gradient of some rows (R,) of an image, by kernels of radius 2, float32 (R, W)."""
    columns = image.shape[1]
    ring, room = np.empty((TAPS, columns), np.float32), np.empty((2, columns + 4), np.float32)
    along_x, along_y = np.empty(columns, np.float32), np.empty(columns, np.float32)
    magnitude = np.empty((len(rows), columns), np.float32)
    for number in range(len(rows)):
        for beside in range(-RADIUS, RADIUS + 1):
            _load(image, rows[number] + beside, ring)
        gradient = Gradient(along_x, along_y, magnitude[number])
        _gradient_of_row(ring, rows[number], (smooth, derivative), room, gradient)
    return magnitude
