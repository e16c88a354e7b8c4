"""Sensor noise of one image as a function of grey, measured on the image itself; the scale that suits it."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from numerics.kernels import kernel

QUANTISATION_SD_GREY = 0.3  # an 8-bit step of 1 grey, uniform: 1/sqrt(12)
MAD_TO_SD = 1.4826  # of a Gaussian
MASK_NORM = 6.0  # Euclidean norm of the mask [1 -2 1; -2 4 -2; 1 -2 1]
LARGEST_RESPONSE = 8 * 255  # of that mask
MIN_SAMPLES = 200  # in a grey band before its spread is believed
BANDS = 16
SAMPLED_ROWS = 60  # of second differences: tens of thousands of samples are plenty
FINEST_SCALE_PX = 0.7
COARSEST_SCALE_PX = 2.0
SCALE_PER_ROOT = (
    3.0  # scale = 3 (noise / range)^(1/3): found best on renders over noise 1..8, contrast .15..1
)
SAMPLE_STEP = 4  # of the greys whose range is taken
BLACK_GREY, SATURATED_GREY = 1, 250  # up to the one and from the other on the sensor clips: no noise there
MOST_SMOOTHING = 2.0  # beyond this the weakest quarter of the gradients is texture, not noise
RAYLEIGH_QUARTER = 0.7585  # lower quartile of the length of a plane Gaussian vector, in standard deviations
FEWEST_FLAT = 500  # gradients before their lower quartile is believed

LEVELS = np.arange(256.0)

Grey = NDArray[np.uint8]
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
    a, b = 0.0, 0.0
    if min(image.shape) >= 5:
        a, b = _variance_line(image, max(3, image.shape[0] // SAMPLED_ROWS))
    return np.asarray(np.sqrt(np.maximum(a + b * LEVELS, QUANTISATION_SD_GREY**2)), dtype=np.float64)


@kernel(inline="always")
def _band_medians(image: Grey, step: int) -> tuple[Floats, Floats]:
    """Median of the mask's absolute response in each band of grey, and how many responses it is of."""
    rows, columns = image.shape
    histogram = np.zeros((BANDS, LARGEST_RESPONSE + 1), np.int32)
    column = np.empty(columns, np.int32)
    for y in range(0, rows - 2, step):
        top, middle, bottom = image[y], image[y + 1], image[y + 2]
        for x in range(columns):
            column[x] = np.int32(top[x]) - 2 * np.int32(middle[x]) + np.int32(bottom[x])
        for x in range(2, columns - 2):
            # grey from pixels beside the mask: the mask's own noise must not choose its band
            centre = (np.int32(middle[x - 2]) + np.int32(middle[x + 2])) >> 1
            if BLACK_GREY < centre < SATURATED_GREY:
                response = abs(column[x - 1] - 2 * column[x] + column[x + 1])
                histogram[(centre * BANDS) >> 8, response] += 1
    medians, counts = np.zeros(BANDS), np.zeros(BANDS)
    for band in range(BANDS):
        total = 0
        for k in range(LARGEST_RESPONSE + 1):
            total += histogram[band, k]
        counts[band] = total
        if total == 0:
            continue
        below, k = histogram[band, 0], 0
        while below <= (total - 1) // 2:
            k += 1
            below += histogram[band, k]
        lower = k
        while below <= total // 2:
            k += 1
            below += histogram[band, k]
        medians[band] = 0.5 * (lower + k)
    return medians, counts


@kernel(nogil=True)
def _variance_line(image: Grey, step: int) -> tuple[float, float]:
    """The weighted fit variance = a + b grey with a, b >= 0 over the bands that have enough samples."""
    medians, counts = _band_medians(image, step)
    n, sg, sv, sgg, sgv = 0.0, 0.0, 0.0, 0.0, 0.0
    for band in range(BANDS):
        if counts[band] >= MIN_SAMPLES:
            grey = (band + 0.5) * 256.0 / BANDS
            variance = (MAD_TO_SD * medians[band] / MASK_NORM) ** 2
            weight = np.sqrt(counts[band])
            n += weight
            sg += weight * grey
            sv += weight * variance
            sgg += weight * grey * grey
            sgv += weight * grey * variance
    if n <= 0.0:
        return 0.0, 0.0
    spread = sgg - sg * sg / n
    slope = max(0.0, (sgv - sg * sv / n) / spread) if spread > 1e-6 * sgg else 0.0
    offset = (sv - slope * sg) / n
    if offset < 0.0:
        return 0.0, sgv / sgg
    return offset, slope


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
    sampled = np.ascontiguousarray(image[::SAMPLE_STEP, ::SAMPLE_STEP])
    below = np.cumsum(cv2.calcHist([sampled], [0], None, [256], [0, 256]))
    ranks = [int(share * (below[-1] - 1)) for share in (0.01, 0.5, 0.99)]
    low, middle, high = np.searchsorted(below, ranks, side="right").tolist()
    share = float(noise[(middle + high) // 2]) / max(high - low, 1)
    scale: float = SCALE_PER_ROOT * share ** (1.0 / 3.0)
    return min(max(scale, FINEST_SCALE_PX), COARSEST_SCALE_PX)


def smooth_noise_factor(
    magnitude: NDArray[np.float32], grey: NDArray[np.uint8], noise_of: NDArray[np.float32]
) -> float:
    """How much stronger the weakest quarter of the gradients is than white noise of the measured size.

    Demosaicing, compression and scaling smooth the noise of a camera: its second differences, on which the
    noise is measured, fall more than its gradient does. Flat parts show it, and the weakest quarter is there.

    Parameters
    ----------
    magnitude, grey
        float32 and uint8, same shape: gradients of a sample of pixels, and their grey.
    noise_of
        float32 (256,), standard deviation of the gradient from white noise, for each grey.

    Returns
    -------
    1 to 2.
    """
    telling = (grey > BLACK_GREY) & (grey < SATURATED_GREY)
    ratio = magnitude[telling] / noise_of[grey[telling]]
    if len(ratio) < FEWEST_FLAT:
        return 1.0
    quarter = float(np.partition(ratio, len(ratio) // 4)[len(ratio) // 4])
    return float(min(max(quarter / RAYLEIGH_QUARTER, 1.0), MOST_SMOOTHING))
