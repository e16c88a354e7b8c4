"""Sensor noise of one image as a function of grey, measured on the image itself; the scale that suits it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

QUANTISATION_SD_GREY = 0.3  # an 8-bit step of 1 grey, uniform: 1/sqrt(12)
MAD_TO_SD = 1.4826  # of a Gaussian
MASK_NORM = 6.0  # Euclidean norm of the mask [1 -2 1; -2 4 -2; 1 -2 1]
MIN_SAMPLES = 200  # in a grey band before its spread is believed
BANDS = 16
SAMPLED_ROWS = 80  # of second differences: tens of thousands of samples are plenty
FINEST_SCALE_PX = 0.7
COARSEST_SCALE_PX = 2.0
SCALE_PER_ROOT = (
    3.0  # scale = 3 (noise / range)^(1/3): found best on renders over noise 1..8, contrast .15..1
)

Floats = NDArray[np.float64]


def grey_noise(image: NDArray[np.uint8]) -> Floats:
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
    variance = np.full(256, QUANTISATION_SD_GREY**2)
    if min(image.shape) >= 5:
        greys, variances, counts = _banded_variances(image)
        if len(greys):
            variance = np.maximum(_variance_line(greys, variances, counts), variance)
    return np.asarray(np.sqrt(variance), dtype=np.float64)


def _banded_variances(image: NDArray[np.uint8]) -> tuple[Floats, Floats, Floats]:
    """Middle grey, robust noise variance and number of samples of the bands that have enough of them."""
    step = max(3, image.shape[0] // SAMPLED_ROWS)
    bottom = image[2::step].astype(np.int16)
    top, middle = (
        image[::step][: len(bottom)].astype(np.int16),
        image[1::step][: len(bottom)].astype(np.int16),
    )
    column = top - 2 * middle + bottom
    response = np.abs(column[:, 1:-3] - 2 * column[:, 2:-2] + column[:, 3:-1])
    # grey from pixels beside the mask: the mask's own noise must not choose its band
    centre = (middle[:, :-4] + middle[:, 4:]) // 2
    usable = (centre > 1) & (centre < 250)
    band = centre[usable] * BANDS // 256
    value = response[usable]
    found = []
    for index in range(BANDS):
        chosen = value[band == index]
        if len(chosen) >= MIN_SAMPLES:
            spread = MAD_TO_SD * float(np.median(chosen)) / MASK_NORM
            found.append(((index + 0.5) * 256.0 / BANDS, spread**2, float(len(chosen))))
    table = np.array(found, dtype=np.float64).reshape(-1, 3)
    return table[:, 0], table[:, 1], table[:, 2]


def _variance_line(grey: Floats, variance: Floats, count: Floats) -> Floats:
    """The weighted fit variance = a + b grey with a, b >= 0, at the 256 levels."""
    weight = np.sqrt(count)
    a, b = float(np.average(variance, weights=weight)), 0.0
    if len(grey) > 1:
        mean_grey = float(np.average(grey, weights=weight))
        spread = float(np.sum(weight * (grey - mean_grey) ** 2))
        b = max(0.0, float(np.sum(weight * (grey - mean_grey) * (variance - a))) / spread)
        a -= b * mean_grey
        if a < 0.0:
            a, b = 0.0, float(np.sum(weight * grey * variance) / np.sum(weight * grey * grey))
    return np.asarray(a + b * np.arange(256.0), dtype=np.float64)


def gradient_scale(image: NDArray[np.uint8], noise: Floats) -> float:
    """Scale of the gradient that suits an image: fine when clean, coarse when noise drowns its contrast.

    Parameters
    ----------
    image
        uint8 grey, (H, W).
    noise
        float64 (256,), its noise from `grey_noise`.

    Returns
    -------
    Sigma of the Gaussian derivative, px.
    """
    sample = np.sort(image[::4, ::4], axis=None)
    low, middle, high = (int(sample[int(q * (len(sample) - 1))]) for q in (0.01, 0.5, 0.99))
    share = float(noise[(middle + high) // 2]) / max(high - low, 1)
    return float(np.clip(SCALE_PER_ROOT * np.cbrt(share), FINEST_SCALE_PX, COARSEST_SCALE_PX))
