"""How blurred one image is, by defocus or motion, measured on its own strongest edges."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from vision_server.gaussian import gaussian_kernels

FINE_PX, COARSE_PX = 1.0, 2.0  # scales compared, in pixels of the halved image
STRONGEST_SHARE = 0.03  # of the pixels: what counts as a strong edge
CLIPPED_GREY = 245  # edges of clipped areas look sharper than they are
MIN_EDGELS = 20  # fewer say nothing
MOST_BLUR_PX = 8.0


def edge_height(image: NDArray[np.float32], sigma_px: float) -> NDArray[np.float32]:
    """Gradient magnitude as the height of the ideal step that would give it, float32 (H, W)."""
    smooth, derivative = gaussian_kernels(sigma_px)
    derivative = derivative * np.float32(np.sqrt(2.0 * np.pi) * sigma_px)
    gx = cv2.sepFilter2D(image, cv2.CV_32F, derivative, smooth, borderType=cv2.BORDER_REPLICATE)
    gy = cv2.sepFilter2D(image, cv2.CV_32F, smooth, derivative, borderType=cv2.BORDER_REPLICATE)
    return np.asarray(cv2.magnitude(gx, gy), dtype=np.float32)


def blur_sigma(image: NDArray[np.uint8]) -> float:
    """Standard deviation of the blur of the sharper half of the strong edges, px.

    A step blurred by b has, at scale s, the height s / sqrt(s^2 + b^2) of itself; the ratio of the heights at
    two scales gives b. The half-size image is enough: only blur of more than about a pixel matters.

    Parameters
    ----------
    image
        uint8 grey, (H, W).

    Returns
    -------
    px, 0 (sharp, or nothing to measure on) to 8.
    """
    if min(image.shape) < 16:
        return 0.0
    half = cv2.resize(image, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    values = half.astype(np.float32)
    fine, coarse = edge_height(values, FINE_PX), edge_height(values, COARSE_PX)
    ring = np.ones((5, 5), np.uint8)
    sample = coarse[::2, ::2].ravel()
    rank = sample.size - max(int(STRONGEST_SHARE * sample.size), 1)
    threshold = max(float(np.partition(sample, rank)[rank]), 1.0)
    crest = coarse >= np.float32(0.98) * cv2.dilate(coarse, ring)
    ridge = (coarse >= threshold) & crest & (cv2.dilate(half, ring) < CLIPPED_GREY)
    if np.count_nonzero(ridge) < MIN_EDGELS:
        return 0.0
    ratio = float(np.median(fine[ridge] / coarse[ridge]))
    ratio = min(max(ratio, FINE_PX / COARSE_PX + 1e-3), 1.0 - 1e-6)
    squared = (ratio * COARSE_PX / FINE_PX) ** 2
    variance = (COARSE_PX**2 - squared * FINE_PX**2) / (squared - 1.0)
    return float(min(2.0 * np.sqrt(max(variance, 0.0)), MOST_BLUR_PX))
