"""How blurred one image is, by defocus or motion, measured on its own strongest edges."""

from __future__ import annotations

from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry.kernels import kernel
from vision_server.flags import set_places
from vision_server.gaussian import gaussian_kernels

Grey = NDArray[np.uint8]
Field = NDArray[np.float32]

FINE_PX, COARSE_PX = 1.0, 2.0  # scales compared, in pixels of the halved image
CREST_PX = 1.2  # smoothing before the crests of edges are looked for
STRONGEST_SHARE = 0.03  # of the pixels: what counts as a strong edge
CLIPPED_GREY = 245  # edges of clipped areas look sharper than they are
MIN_EDGELS = 20  # fewer say nothing
MOST_EDGELS = 150  # more say nothing new
MOST_BLUR_PX = 8.0
STRONGEST_SLOPE = 2048  # of `cv2.spatialGradient` along both axes together, and one


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
def _crests(
    gx: NDArray[np.int16], gy: NDArray[np.int16], around: Grey, margin: int
) -> tuple[NDArray[np.int64], int]:
    """Rows (y, x) of the crests of the strongest edges that no clipped pixel is near to."""
    rows, columns = gx.shape
    histogram = np.zeros(STRONGEST_SLOPE, np.int32)
    slope = np.empty((rows, columns), np.int16)
    for y in range(rows):
        of, a, b = slope[y], gx[y], gy[y]
        for x in range(columns):
            of[x] = abs(a[x]) + abs(b[x])
    for y in range(0, rows, 4):
        of = slope[y]
        for x in range(columns):
            histogram[min(of[x], STRONGEST_SLOPE - 1)] += 1
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
            if x < margin or x >= columns - margin or around[y, x] >= CLIPPED_GREY:
                continue
            s = of[x]
            a, b = abs(gx[y, x]), abs(gy[y, x])
            v = 0 if a > 2 * b else 1
            u = 0 if b > 2 * a else 1 if (gx[y, x] > 0) == (gy[y, x] > 0) else -1
            if u == 0:
                v = 1
            if s >= slope[y + v, x + u] and s > slope[y - v, x - u] and found < len(crests):
                crests[found, 0], crests[found, 1] = y, x
                found += 1
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
    soft = cv2.GaussianBlur(half, (5, 5), CREST_PX, borderType=cv2.BORDER_REPLICATE)
    gx, gy = (np.asarray(slope, np.int16) for slope in cv2.spatialGradient(soft))
    around = cv2.dilate(half, np.ones((5, 5), np.uint8))
    crests, found = _crests(gx, gy, np.asarray(around, np.uint8), margin)
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
