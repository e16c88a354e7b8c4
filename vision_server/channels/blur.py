"""How blurred one image is, by defocus or motion, measured on its own strongest edges.

Of all of them for what looks at edges as they are (`blur_sigma`), and of those that stand alone for what lens
and motion do (`lone_edge_blur`): before a wall of lines edges are as narrow as neighbours let them be.

The heights that a step has at two scales tell its blur, as in Zhuo and Sim (2011). Smoothing and Sobel run
row by row in kernels: with OpenCV's, the whole measure takes twice as long.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from numerics.arrays import Field, Flags, Grey, Ints
from numerics.kernels import kernel
from numerics.marks import list_marks, no_marks
from vision_server.channels.depth import Pixels, deepened
from vision_server.channels.gaussian import contrast_kernels

Slopes = NDArray[np.int16]

# Chosen by hand where nothing else is said.
FINE_PX, COARSE_PX = 1.0, 2.0  # scales compared, in pixels of the halved image
SMOOTHING = (22, 62, 88)  # of 256: half a Gaussian of 1.2 px, before ridges of the gradient are looked for
STRONGEST_SHARE = 0.03  # of the pixels: what counts as a strong edge; chosen by hand
SAMPLE_STEP = 4  # rows between those whose gradients are ranked
NEARLY_CLIPPED_GREY = 245  # edges of clipped areas look sharper than they are
FIRST_ROOM = 1024  # ridges for which there is room at first
MIN_EDGELS = 20  # fewer say nothing
MOST_EDGELS = 150  # more say nothing new
# An edge stands alone where so many pixels of the halved image to either side no slope is against its own by
# more than that share of it (by hand).
ALONE_PX, MOST_AGAINST = 4, 0.3
MOST_BLUR_PX = 8.0  # more cannot be told: the coarse scale sees the edge's neighbours
LARGEST_SLOPE = 2 * 4 * 255  # of Sobel's |gx| + |gy|


def halved(image: Pixels) -> Pixels:
    """Means of 2 x 2 px, (H // 2, W // 2), uint8 or uint16; an odd last row or column is left out."""
    rows, columns = image.shape
    even = image[: rows & ~1, : columns & ~1]
    half = cv2.resize(even, (columns // 2, rows // 2), interpolation=cv2.INTER_AREA)
    return deepened(half) if half.dtype == np.float32 else np.asarray(half, image.dtype)


@kernel()
def _soften(half: Grey, y: int, column: Field, soft: Slopes) -> None:
    """Row ``y`` smoothed both ways, rounded once, as the inner part of ``soft``; a border mirrors it.

    The sums are whole numbers that float32 holds.
    """
    rows, columns = half.shape
    a, b, c = half[max(y - 2, 0)], half[max(y - 1, 0)], half[y]
    d, e = half[min(y + 1, rows - 1)], half[min(y + 2, rows - 1)]
    outer, beside, middle = np.float32(SMOOTHING[0]), np.float32(SMOOTHING[1]), np.float32(SMOOTHING[2])
    inner, target = column[2 : columns + 2], soft[1 : columns + 1]
    for x in range(columns):
        inner[x] = (
            outer * (np.float32(a[x]) + np.float32(e[x]))
            + beside * (np.float32(b[x]) + np.float32(d[x]))
            + middle * np.float32(c[x])
        )
    column[0] = column[1] = column[2]
    column[columns + 3] = column[columns + 2] = column[columns + 1]
    left, near, far, right = column, column[1:], column[3:], column[4:]
    scale, half_step = np.float32(1.0 / 65536.0), np.float32(32768.0)
    for x in range(columns):
        total = outer * (left[x] + right[x]) + beside * (near[x] + far[x]) + middle * inner[x]
        target[x] = np.int16((total + half_step) * scale)
    soft[0], soft[columns + 1] = soft[2], soft[columns - 1]


@kernel()
def _slopes(half: Grey, gx: Slopes, gy: Slopes, slope: Slopes) -> None:
    """Sobel's slopes of the softened image along x and y, and the sum of their lengths; borders mirror."""
    rows, columns = half.shape
    column, soft = np.empty(columns + 4, np.float32), np.empty((3, columns + 2), np.int16)
    for y in range(2):
        _soften(half, y, column, soft[y])
    for y in range(rows):
        if y + 1 < rows and y > 0:
            _soften(half, y + 1, column, soft[(y + 1) % 3])
        above = soft[(y - 1 if y > 0 else 1) % 3]
        below = soft[(y + 1 if y + 1 < rows else y - 1) % 3]
        here = soft[y % 3]
        along, across, both = gx[y], gy[y], slope[y]
        for x in range(columns):
            along[x] = (above[x + 2] - above[x]) + 2 * (here[x + 2] - here[x]) + (below[x + 2] - below[x])
        for x in range(columns):
            across[x] = (
                (below[x] - above[x]) + 2 * (below[x + 1] - above[x + 1]) + (below[x + 2] - above[x + 2])
            )
        for x in range(columns):
            both[x] = abs(along[x]) + abs(across[x])


@kernel()
def least_strong(slope: Slopes) -> int:
    """The least slope of the strongest ones: one that the sampled rows' STRONGEST_SHARE reach, 1 at least."""
    rows, columns = slope[::SAMPLE_STEP].shape
    counts = np.zeros((2, LARGEST_SLOPE + 1), np.int32)
    for y in range(0, len(slope), SAMPLE_STEP):
        for x in range(0, columns - 1, 2):  # in turn: to count the same twice running is slow
            counts[0, slope[y, x]] += 1
            counts[1, slope[y, x + 1]] += 1
        if columns & 1:
            counts[0, slope[y, columns - 1]] += 1
    wanted, least = max(int(STRONGEST_SHARE * (rows * columns)), 1), LARGEST_SLOPE
    reached = counts[0, least] + counts[1, least]
    while reached < wanted:
        least -= 1
        reached += counts[0, least] + counts[1, least]
    return max(least, 1)


@kernel()
def _ridges(half: Grey, gx: Slopes, gy: Slopes, slope: Slopes, margin: int) -> Ints:
    """Rows (y, x) of strong slopes, maxima along the nearest of four directions, beside nothing clipped."""
    rows, columns = slope.shape
    least = np.int16(least_strong(slope))
    marks = no_marks(columns)
    ridges, found = np.empty((FIRST_ROOM, 2), np.int64), 0
    for y in range(margin, rows - margin):
        of_row = slope[y]
        for x in range(columns):
            marks.marked[x] = of_row[x] >= least
        for x in marks.numbers[: list_marks(marks)]:
            if x < margin or x >= columns - margin:
                continue
            a, b = abs(gx[y, x]), abs(gy[y, x])
            v = 0 if a > 2 * b else 1
            u = 0 if b > 2 * a else 1 if (gx[y, x] > 0) == (gy[y, x] > 0) else -1
            if slope[y, x] < slope[y + v, x + u] or slope[y, x] <= slope[y - v, x - u]:
                continue
            brightest = 0
            for near_y in range(y - 2, y + 3):
                for near_x in range(x - 2, x + 3):
                    brightest = max(brightest, half[near_y, near_x])
            if brightest >= NEARLY_CLIPPED_GREY:
                continue
            if found == len(ridges):
                ridges = np.concatenate((ridges, ridges))
            ridges[found, 0], ridges[found, 1] = y, x
            found += 1
    return ridges[:found]


class _Edgels(NamedTuple):
    """Rows (y, x) on the ridges of the strongest gradients; Sobel's slopes, see `_slopes`."""

    places: Ints
    gx: Slopes
    gy: Slopes


def _strongest_edgels(half: Grey) -> _Edgels:
    """Those of an image (H, W), as far from its border as they are measured by; none of one no wider."""
    margin = int(np.ceil(3.0 * COARSE_PX))
    gx, gy, slope = np.empty((3, *half.shape), np.int16)
    if min(half.shape) <= 2 * margin:
        return _Edgels(np.empty((0, 2), np.int64), gx, gy)
    _slopes(half, gx, gy, slope)
    return _Edgels(np.asarray(_ridges(half, gx, gy, slope, margin)), gx, gy)


@kernel()
def _alone(edgels: _Edgels) -> Flags:
    """Which edgels stand alone: no slope beside them, along their normal, is against their own."""
    out = np.ones(len(edgels.places), dtype=np.bool_)
    for i in range(len(out)):
        y, x = edgels.places[i]
        along_x, along_y = float(edgels.gx[y, x]), float(edgels.gy[y, x])
        square = along_x**2 + along_y**2
        step = 1.0 / math.sqrt(square)
        for k in range(-ALONE_PX, ALONE_PX + 1):
            v, u = y + round(k * step * along_y), x + round(k * step * along_x)
            slope = edgels.gx[v, u] * along_x + edgels.gy[v, u] * along_y
            if slope < -MOST_AGAINST * square:
                out[i] = False
                break
    return out


@kernel(fastmath={"reassoc", "contract", "nsz"})
def _step_heights(half: Grey, edgels: Ints, smooth: Field, derivative: Field) -> Field:
    """Length of the gradient at some pixels, as the height of the ideal step that would give it."""
    heights = np.empty(len(edgels), np.float32)
    radius = len(smooth) // 2
    side = len(smooth)
    for i in range(len(edgels)):
        y, x = edgels[i]
        gx, gy = np.float32(0.0), np.float32(0.0)
        for v in range(side):
            across, along = np.float32(0.0), np.float32(0.0)
            for u in range(side):
                grey = np.float32(half[y + v - radius, x + u - radius])
                across += smooth[u] * grey
                along += derivative[u] * grey
            gx += smooth[v] * along
            gy += derivative[v] * across
        heights[i] = np.sqrt(gx * gx + gy * gy)
    return heights


def blur_sigma(half: Grey) -> float:
    """Standard deviation of the blur of the strong edges, px of the full image.

    A step blurred by b has, at scale s, the height s / sqrt(s^2 + b^2) of itself; the ratio of the heights at
    two scales gives b. The half-size image is enough: only blur of more than about a pixel matters.

    Parameters
    ----------
    half
        uint8 grey, (H // 2, W // 2), the image halved, see `halved`.

    Returns
    -------
    px, 0 (sharp, or nothing to measure on) to 8.
    """
    return _blur_of(half, _strongest_edgels(half).places) or 0.0


def lone_edge_blur(half: Grey) -> float | None:
    """The same by edges that stand alone; None where they are too few to tell."""
    edgels = _strongest_edgels(half)
    return _blur_of(half, edgels.places[_alone(edgels)])


def _blur_of(half: Grey, edgels: Ints) -> float | None:
    """Blur of some edgels (N, 2), px of the full image; None where they are too few, or too weak."""
    if len(edgels) < MIN_EDGELS:
        return None
    edgels = edgels[:: -(-len(edgels) // MOST_EDGELS)]
    fine, coarse = (_step_heights(half, edgels, *contrast_kernels(scale)) for scale in (FINE_PX, COARSE_PX))
    strong = coarse >= 1.0
    if np.count_nonzero(strong) < MIN_EDGELS:
        return None
    ratios = fine[strong] / coarse[strong]
    ratio = float(np.partition(ratios, len(ratios) // 2)[len(ratios) // 2])
    ratio = min(max(ratio, FINE_PX / COARSE_PX + 1e-3), 1.0 - 1e-6)
    squared = (ratio * COARSE_PX / FINE_PX) ** 2
    variance = (COARSE_PX**2 - squared * FINE_PX**2) / (squared - 1.0)
    return float(min(2.0 * np.sqrt(max(variance, 0.0)), MOST_BLUR_PX))
