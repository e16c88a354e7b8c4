"""How blurred one image is, by defocus or motion, measured on its own strongest edges."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from numerics.kernels import kernel
from vision_server.channels.gaussian import contrast_kernels

Grey = NDArray[np.uint8]
Field = NDArray[np.float32]
Slopes = NDArray[np.int16]
Ints = NDArray[np.int64]

FINE_PX, COARSE_PX = 1.0, 2.0  # scales compared, in pixels of the halved image
SMOOTHING_PX = 1.2  # of the halved image, before the ridges of its gradient are looked for
STRONGEST_SHARE = 0.03  # of the pixels: what counts as a strong edge; chosen by hand
SAMPLE_STEP = 4  # rows between those whose gradients are ranked
NEARLY_CLIPPED_GREY = 245  # edges of clipped areas look sharper than they are
MIN_EDGELS = 20  # fewer say nothing
MOST_EDGELS = 150  # more say nothing new
MOST_BLUR_PX = 8.0  # more cannot be told: the coarse scale sees the edge's neighbours


def halved(image: Grey) -> Grey:
    """Means of 2 x 2 px, uint8 (H // 2, W // 2); an odd last row or column is left out."""
    rows, columns = image.shape
    even = image[: rows & ~1, : columns & ~1]
    return np.asarray(cv2.resize(even, (columns // 2, rows // 2), interpolation=cv2.INTER_AREA), np.uint8)


@kernel(nogil=True)
def _ridges(places: Ints, gx: Slopes, gy: Slopes, slope: Slopes, margin: int) -> Ints:
    """Rows (y, x) of the places where ``slope`` is a maximum along the nearest of four directions."""
    rows, columns = slope.shape
    ridges = np.empty((len(places) + 1, 2), np.int64)
    found = 0
    for place in places:
        y = place // columns
        x = place - y * columns
        if min(y, x, rows - 1 - y, columns - 1 - x) < margin:
            continue
        a, b = abs(gx[y, x]), abs(gy[y, x])
        v = 0 if a > 2 * b else 1
        u = 0 if b > 2 * a else 1 if (gx[y, x] > 0) == (gy[y, x] > 0) else -1
        if slope[y, x] >= slope[y + v, x + u] and slope[y, x] > slope[y - v, x - u]:
            ridges[found, 0], ridges[found, 1] = y, x
            found += 1
    return ridges[:found]


def _strongest_edgels(half: Grey, margin: int) -> Ints:
    """Rows (y, x) on the ridges of the strongest gradients; Sobel's, with the length |gx| + |gy|."""
    soft = cv2.GaussianBlur(half, (5, 5), SMOOTHING_PX, borderType=cv2.BORDER_REPLICATE)
    gx, gy = (np.asarray(cv2.Sobel(soft, cv2.CV_16S, *order), np.int16) for order in ((1, 0), (0, 1)))
    slope: Slopes = np.abs(gx) + np.abs(gy)
    ranked = np.sort(slope[::SAMPLE_STEP], axis=None)
    threshold = max(ranked[-max(int(STRONGEST_SHARE * len(ranked)), 1)], 1)
    brightest = np.asarray(cv2.dilate(half, np.ones((5, 5), np.uint8)))
    places = np.flatnonzero((slope >= threshold) & (brightest < NEARLY_CLIPPED_GREY))
    return np.asarray(_ridges(places, gx, gy, slope, margin))


def _step_heights(half: Grey, edgels: Ints, sigma_px: float) -> Field:
    """Length of the gradient at some pixels, as the height of the ideal step that would give it."""
    smooth, derivative = contrast_kernels(sigma_px)
    y, x = (edgels - len(smooth) // 2).T
    around = sliding_window_view(half, (len(smooth), len(smooth)))[y, x].astype(np.float32)
    return np.asarray(np.hypot(around @ derivative @ smooth, around @ smooth @ derivative), np.float32)


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
    margin = int(np.ceil(3.0 * COARSE_PX))
    if min(half.shape) <= 2 * margin:
        return 0.0
    edgels = _strongest_edgels(half, margin)
    if len(edgels) < MIN_EDGELS:
        return 0.0
    edgels = edgels[:: -(-len(edgels) // MOST_EDGELS)]
    fine, coarse = (_step_heights(half, edgels, scale) for scale in (FINE_PX, COARSE_PX))
    strong = coarse >= 1.0
    if np.count_nonzero(strong) < MIN_EDGELS:
        return 0.0
    ratios = fine[strong] / coarse[strong]
    ratio = float(np.partition(ratios, len(ratios) // 2)[len(ratios) // 2])
    ratio = min(max(ratio, FINE_PX / COARSE_PX + 1e-3), 1.0 - 1e-6)
    squared = (ratio * COARSE_PX / FINE_PX) ** 2
    variance = (COARSE_PX**2 - squared * FINE_PX**2) / (squared - 1.0)
    return float(min(2.0 * np.sqrt(max(variance, 0.0)), MOST_BLUR_PX))
