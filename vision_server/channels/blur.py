"""How blurred one image is, by defocus or motion, measured on its own strongest edges."""

from __future__ import annotations

from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from numerics.flags import set_places
from numerics.kernels import kernel
from vision_server.channels.gaussian import gaussian_kernels

Grey = NDArray[np.uint8]
Field = NDArray[np.float32]
Slopes = NDArray[np.int16]

FINE_PX, COARSE_PX = 1.0, 2.0  # scales compared, in pixels of the halved image
CREST = (22, 62, 88)  # of 256: half a Gaussian of 1.2 px, before the crests of edges are looked for
STRONGEST_SHARE = 0.03  # of the pixels: what counts as a strong edge
CLIPPED_GREY = 245  # edges of clipped areas look sharper than they are
MIN_EDGELS = 20  # fewer say nothing
MOST_EDGELS = 150  # more say nothing new
MOST_BLUR_PX = 8.0
STRONGEST_SLOPE = 2048  # of Sobel's along both axes together, and one


def halved(image: Grey) -> Grey:
    """Means of 2 x 2 px, uint8 (H // 2, W // 2); an odd last row or column is left out."""
    rows, columns = image.shape
    even = image[: rows & ~1, : columns & ~1]
    return np.asarray(cv2.resize(even, (columns // 2, rows // 2), interpolation=cv2.INTER_AREA), np.uint8)


@cache
def _kernels(sigma_px: float) -> tuple[Field, Field]:
    """Gaussian and its derivative, scaled so that an ideal step answers with its height."""
    smooth, derivative = gaussian_kernels(sigma_px)
    return smooth, derivative * np.float32(np.sqrt(2.0 * np.pi) * sigma_px)


@kernel(nogil=True)
def _soften(half: Grey, y: int, column: Field, soft: Slopes) -> None:
    """Row ``y`` smoothed both ways, rounded once, as the inner part of ``soft``; a border mirrors it.

    The sums are whole numbers that float32 holds.
    """
    rows, columns = half.shape
    a, b, c = half[max(y - 2, 0)], half[max(y - 1, 0)], half[y]
    d, e = half[min(y + 1, rows - 1)], half[min(y + 2, rows - 1)]
    outer, beside, middle = np.float32(CREST[0]), np.float32(CREST[1]), np.float32(CREST[2])
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


@kernel(nogil=True)
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


@kernel(nogil=True)
def _crests(half: Grey, margin: int) -> tuple[NDArray[np.int64], int]:
    """Rows (y, x) of the crests of the strongest edges that no clipped pixel is near to."""
    rows, columns = half.shape
    slopes = np.empty((3, rows, columns), np.int16)
    gx, gy, slope = slopes[0], slopes[1], slopes[2]
    _slopes(half, gx, gy, slope)
    histogram, other = np.zeros(STRONGEST_SLOPE, np.int32), np.zeros(STRONGEST_SLOPE, np.int32)
    for y in range(0, rows, 4):
        of = slope[y]
        for x in range(1, columns, 2):  # in turns, for equal slopes in a row would wait for each other
            histogram[min(of[x - 1], STRONGEST_SLOPE - 1)] += 1
            other[min(of[x], STRONGEST_SLOPE - 1)] += 1
        if columns & 1:
            histogram[min(of[columns - 1], STRONGEST_SLOPE - 1)] += 1
    histogram += other
    wanted = max(int(STRONGEST_SHARE * ((rows + 3) // 4) * columns), 1)
    threshold, above = np.int16(STRONGEST_SLOPE - 1), histogram[STRONGEST_SLOPE - 1]
    while threshold > 1 and above < wanted:
        threshold = np.int16(threshold - 1)
        above += histogram[threshold]
    found = 0
    crests = np.empty((rows * columns // 2 + 1, 2), np.int64)
    steep = np.zeros(-(-columns // 8) * 8, np.bool_)
    chosen = np.empty(len(steep), np.int64)
    for y in range(margin, rows - margin):
        of = slope[y]
        for x in range(columns):  # fills vector registers
            steep[x] = of[x] >= threshold
        for i in range(set_places(steep, chosen)):
            x = chosen[i]
            if x < margin or x >= columns - margin:
                continue
            s = of[x]
            a, b = abs(gx[y, x]), abs(gy[y, x])
            v = 0 if a > 2 * b else 1
            u = 0 if b > 2 * a else 1 if (gx[y, x] > 0) == (gy[y, x] > 0) else -1
            if u == 0:
                v = 1
            if s >= slope[y + v, x + u] and s > slope[y - v, x - u] and found < len(crests):
                brightest = np.uint8(0)
                for row in range(y - 2, y + 3):
                    for at in range(x - 2, x + 3):
                        brightest = max(brightest, half[row, at])
                crests[found, 0], crests[found, 1] = y, x
                found += int(brightest < CLIPPED_GREY)
    return crests, found


@kernel(nogil=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz"})
def _heights(
    image: Grey, crests: NDArray[np.int64], smooth: Field, derivative: Field, heights: Field
) -> None:
    """Length of the gradient at each crest."""
    radius = len(smooth) // 2
    side = len(smooth)
    for i in range(len(crests)):
        y, x = crests[i]
        gx, gy = np.float32(0.0), np.float32(0.0)
        for v in range(side):
            across, along = np.float32(0.0), np.float32(0.0)
            for u in range(side):
                grey = np.float32(image[y + v - radius, x + u - radius])
                across += smooth[u] * grey
                along += derivative[u] * grey
            gx += smooth[v] * along
            gy += derivative[v] * across
        heights[i] = np.sqrt(gx * gx + gy * gy)


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
    fine, coarse = _kernels(FINE_PX), _kernels(COARSE_PX)
    margin = len(coarse[0]) // 2
    if min(half.shape) <= 2 * margin:
        return 0.0
    crests, found = _crests(half, margin)
    if found < MIN_EDGELS:
        return 0.0
    crests = np.ascontiguousarray(crests[:found][:: -(-found // MOST_EDGELS)])
    heights = np.empty((2, len(crests)), np.float32)
    _heights(half, crests, *fine, heights[0])
    _heights(half, crests, *coarse, heights[1])
    strong = heights[1] >= 1.0
    if np.count_nonzero(strong) < MIN_EDGELS:
        return 0.0
    ratios = heights[0, strong] / heights[1, strong]
    ratio = float(np.partition(ratios, len(ratios) // 2)[len(ratios) // 2])
    ratio = min(max(ratio, FINE_PX / COARSE_PX + 1e-3), 1.0 - 1e-6)
    squared = (ratio * COARSE_PX / FINE_PX) ** 2
    variance = (COARSE_PX**2 - squared * FINE_PX**2) / (squared - 1.0)
    return float(min(2.0 * np.sqrt(max(variance, 0.0)), MOST_BLUR_PX))
