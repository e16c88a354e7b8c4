"""Sensor noise of one image, as a function of grey, measured on the image itself."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

QUANTISATION_SD_GREY = 0.3  # an 8-bit step of 1 grey, uniform: 1/sqrt(12)
MAD_TO_SD = 1.4826  # of a Gaussian
MASK_NORM = 6.0  # Euclidean norm of the mask [1 -2 1; -2 4 -2; 1 -2 1]
MIN_SAMPLES = 200  # in a grey band before its spread is believed
BANDS = 16


def grey_noise(image: NDArray[np.uint8]) -> NDArray[np.float64]:
    """Standard deviation of the noise at each of the 256 grey levels.

    The second-difference mask of Immerkaer (1996) removes planes and straight axis-parallel edges; the median
    of its absolute value in bands of equal grey gives points of variance = a + b grey (read and shot noise),
    fitted with a, b >= 0.

    Parameters
    ----------
    image
        uint8 grey, (H, W), encoded as it came (before any tone curve is undone).

    Returns
    -------
    float64 (256,), grey; never under the quantisation noise.
    """
    levels = np.arange(256, dtype=np.float64)
    floor = np.full(256, QUANTISATION_SD_GREY**2)
    if min(image.shape) < 5:
        return np.sqrt(floor)
    rows = image[: (image.shape[0] - 2) // 4 * 4 + 3].astype(np.int32)
    top, middle, bottom = rows[0:-2:4], rows[1:-1:4], rows[2::4]
    column = top - 2 * middle + bottom
    response = np.abs(column[:, :-2] - 2 * column[:, 1:-1] + column[:, 2:])
    centre = middle[:, 1:-1]
    usable = (centre > 1) & (centre < 250)
    band = centre[usable] * BANDS // 256
    value = response[usable]
    greys, variances, counts = [], [], []
    for index in range(BANDS):
        chosen = value[band == index]
        if len(chosen) >= MIN_SAMPLES:
            greys.append((index + 0.5) * 256.0 / BANDS)
            variances.append((MAD_TO_SD * float(np.median(chosen)) / MASK_NORM) ** 2)
            counts.append(len(chosen))
    if not greys:
        return np.sqrt(floor)
    return np.sqrt(
        np.maximum(_variance_line(np.array(greys), np.array(variances), np.array(counts), levels), floor)
    )


def _variance_line(
    grey: NDArray[np.float64],
    variance: NDArray[np.float64],
    count: NDArray[np.int64],
    levels: NDArray[np.float64],
) -> NDArray[np.float64]:
    """The weighted fit variance = a + b grey with a, b >= 0, at ``levels``."""
    weight = np.sqrt(count)
    if len(grey) > 1:
        mean_grey, mean_variance = np.average(grey, weights=weight), np.average(variance, weights=weight)
        spread = np.sum(weight * (grey - mean_grey) ** 2)
        b = max(0.0, float(np.sum(weight * (grey - mean_grey) * (variance - mean_variance)) / spread))
        a = float(mean_variance - b * mean_grey)
        if a < 0.0:
            a, b = 0.0, float(np.sum(weight * grey * variance) / np.sum(weight * grey * grey))
    else:
        a, b = float(variance[0]), 0.0
    return np.asarray(a + b * levels, dtype=np.float64)
