"""Pixels of one image, as a list, whose Gaussian derivative stands out of the noise, as in Canny (1986)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from numerics.arrays import Field, Grey
from numerics.axis import axis_of
from numerics.kernels import kernel
from vision_server.channels.gaussian import Kernels, gaussian_gradient

Places = NDArray[np.int32]

# Chosen by hand where nothing else is said.
FLANK_RATIO = np.float32(0.65)  # under this share of what is a step along its gradient it is an edge's foot
NARROW_RADIUS = 2  # of the kernels of sharp and clean images, which are most
NEGLIGIBLE = 0.015  # of a kernel's largest tap: less at both ends of both kernels is left out


class Gradient(NamedTuple):
    """Gradient of an image: components along x and y, and length; float32 (H, W) each."""

    x: Field
    y: Field
    magnitude: Field


class GradientPixels(NamedTuple):
    """Pixels above the noise floor, in raster order; all arrays (N,).

    Attributes
    ----------
    places
        int32, flat index into the image.
    magnitude
        float32, length of the gradient.
    axis
        float32, direction of the gradient taken as an axis, rad in [0, pi), 0 along x, pi/2 along y (down).
    flank_sum
        float32, sum of the magnitudes one step ahead and behind, interpolated on the ring of the eight
        neighbours where the gradient's line meets it.
    flank_x, flank_y
        float32, magnitude ahead less that behind, times the unit vector of the gradient: a vector that does
        not depend on which way the axis is read.
    """

    places: Places
    magnitude: Field
    axis: Field
    flank_sum: Field
    flank_x: Field
    flank_y: Field


def gradient(linear: Grey | Field, kernels: Kernels) -> Gradient:
    """Gradient of an image's linear intensity.

    Parameters
    ----------
    linear
        Linear intensity, uint8 or float32 (H, W).
    kernels
        Across and along the derivative, see `contrast_kernels`.
    """
    smooth, derivative = kernels
    cut = len(smooth) // 2 - NARROW_RADIUS
    if cut > 0 and all(np.abs(taps[:cut]).max() <= NEGLIGIBLE * taps.max() for taps in (smooth, derivative)):
        smooth, derivative = smooth[cut:-cut].copy(), derivative[cut:-cut].copy()
    if len(smooth) == 2 * NARROW_RADIUS + 1:
        return Gradient(*_narrow_gradient(linear, smooth, derivative))
    along_x, along_y = gaussian_gradient(linear, (smooth, derivative))
    return Gradient(along_x, along_y, _length(along_x, along_y))


@kernel(nogil=True)
def _length(along_x: Field, along_y: Field) -> Field:
    """Length of each vector; `cv2.magnitude` rounds by where its arrays lie in memory, run by run."""
    length = np.empty_like(along_x)
    for y in range(len(length)):
        for x in range(length.shape[1]):
            length[y, x] = np.sqrt(along_x[y, x] * along_x[y, x] + along_y[y, x] * along_y[y, x])
    return length


@kernel(nogil=True, fastmath={"reassoc", "contract", "nsz"})
def _narrow_gradient(image: Grey | Field, smooth: Field, derivative: Field) -> tuple[Field, Field, Field]:
    """`gaussian_gradient` and `_length` with kernels of radius 2, row by row; tested against the two."""
    rows, columns = image.shape
    gradient = np.empty((3, rows, columns), np.float32)
    ring = np.empty((5, columns), np.float32)
    smoothed, derived = np.empty(columns + 4, np.float32), np.empty(columns + 4, np.float32)
    c, p, q, u, v = smooth[2], smooth[3], smooth[4], derivative[3], derivative[4]
    for y in range(-4, rows):
        source, target = image[min(max(y + 2, 0), rows - 1)], ring[(y + 2) % 5]
        for x in range(columns):
            target[x] = np.float32(source[x])
        if y < 0:
            continue
        a, b, d, e = ring[(y + 1) % 5], ring[(y + 2) % 5], ring[(y - 1) % 5], ring[(y - 2) % 5]
        here, inner, inner_derived = ring[y % 5], smoothed[2 : columns + 2], derived[2 : columns + 2]
        for x in range(columns):
            inner[x] = c * here[x] + p * (a[x] + d[x]) + q * (b[x] + e[x])
            inner_derived[x] = u * (a[x] - d[x]) + v * (b[x] - e[x])
        for row in (smoothed, derived):
            row[0] = row[1] = row[2]
            row[columns + 2] = row[columns + 3] = row[columns + 1]
        along_x, along_y, length = gradient[0, y], gradient[1, y], gradient[2, y]
        for x in range(columns):
            dx = u * (smoothed[x + 3] - smoothed[x + 1]) + v * (smoothed[x + 4] - smoothed[x])
            beside, further = derived[x + 3] + derived[x + 1], derived[x + 4] + derived[x]
            dy = c * derived[x + 2] + p * beside + q * further
            along_x[x], along_y[x] = dx, dy
            length[x] = np.sqrt(dx * dx + dy * dy)
    return gradient[0], gradient[1], gradient[2]


# Over 60 lines: with its first loops in a function of their own it takes a tenth longer.
@kernel(nogil=True, fastmath={"reassoc", "contract", "nsz"})
def pixels_of_rows(gradient: Gradient, level: Grey, floor_of: Field, first: int, end: int) -> GradientPixels:
    """The pixels whose gradient is above the floor, and that are not on the foot of a stronger one.

    The outermost row or column of the image is not among them.

    Parameters
    ----------
    gradient
        Of the image.
    level
        uint8 (H // 2, W // 2), grey by which the floor is looked up.
    floor_of
        float32 (256,), the floor for each grey.
    first, end
        The rows that are looked at.
    """
    rows, columns = gradient.magnitude.shape
    magnitude, along_x, along_y = gradient.magnitude.ravel(), gradient.x.ravel(), gradient.y.ravel()
    last_row, last_column = level.shape[0] - 1, level.shape[1] - 1
    first, end = max(first, 1), min(end, rows - 1)
    room = max(end - first, 0) * columns
    places, values = np.empty(room, np.int32), np.empty((5, room), np.float32)
    lowest, zero = floor_of.min(), np.float32(0.0)
    strong = np.empty(columns + 8, np.int32)
    above = np.zeros((columns + 7) // 8 * 8, np.bool_)
    eights = above.view(np.uint64)
    found = 0
    for y in range(first, end):
        count = 0
        of_row = magnitude[y * columns : (y + 1) * columns]
        for x in range(1, columns - 1):  # fills vector registers
            above[x] = of_row[x] > lowest
        for k in range(len(eights)):
            if eights[k] != 0:
                for x in range(8 * k, 8 * k + 8):  # no branches: they would be guesses
                    strong[count] = x
                    count += above[x]
        greys, candidates, count = level[min(y >> 1, last_row)], strong[:count], 0
        for x in candidates:
            at = y * columns + x
            straight = 1 if abs(along_x[at]) > abs(along_y[at]) else columns
            m, nearest = magnitude[at], max(magnitude[at + straight], magnitude[at - straight])
            strong[count] = x
            count += (m > floor_of[greys[min(x >> 1, last_column)]]) & (m >= FLANK_RATIO * nearest)
        for x in strong[:count]:
            at = y * columns + x
            m, dx, dy = magnitude[at], along_x[at], along_y[at]
            a, b = abs(dx), abs(dy)
            # one step to either side: straight on, and on the diagonal that the gradient leans to
            right, down = 1 if dx > zero else -1, columns if dy > zero else -columns
            straight, diagonal = right if a > b else down, right + down
            ahead, behind = magnitude[at + straight], magnitude[at - straight]
            t = min(a, b) / max(a, b)
            ahead += t * (magnitude[at + diagonal] - ahead)
            behind += t * (magnitude[at - diagonal] - behind)
            difference = (ahead - behind) / m
            places[found] = at
            values[0, found] = m
            values[1, found] = axis_of(dx, dy)
            values[2, found] = ahead + behind
            values[3, found] = difference * dx
            values[4, found] = difference * dy
            found += m >= FLANK_RATIO * max(ahead, behind)
    return GradientPixels(
        places[:found], values[0, :found], values[1, :found], values[2, :found], values[3, :found],
        values[4, :found],
    )  # fmt: skip


def joined(*parts: GradientPixels) -> GradientPixels:
    """The pixels of rows that follow each other."""
    return GradientPixels(*(np.concatenate(values) for values in zip(*parts, strict=True)))
