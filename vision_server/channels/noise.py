"""Sensor noise of one image by grey (Immerkaer 1996), measured on the image; the scale that suits it."""

from __future__ import annotations

import math

import numpy as np

from numerics.arrays import Field, Floats, Grey, Ints
from numerics.kernels import kernel
from vision_server.channels.depth import (
    FINEST_STEP_GREY,
    LEVELS,
    Pixels,
    grey_per_count,
    in_grey,
    is_deep,
    rounded,
    rounding_sd,
)

MAD_TO_SD = 1.4826  # of a Gaussian
MASK_NORM = 6.0  # Euclidean norm of the mask [1 -2 1; -2 4 -2; 1 -2 1]
LARGEST_RESPONSE = 8 * 255  # of that mask
USUAL_RESPONSE = 255  # medians are hardly ever more: a table that the processor's first cache holds
# Chosen by hand where nothing else is said.
MIN_SAMPLES = 200  # in a grey band before its spread is believed
BANDS = 16  # of grey; chosen by hand
SAMPLED_ROWS = 60  # of second differences: tens of thousands of samples are plenty
FINEST_SCALE_PX = 0.7  # chosen by hand, and:
COARSEST_SCALE_PX = 2.0
SCALE_PER_ROOT = (
    3.0  # scale = 3 (noise / range)^(1/3): found best on renders over noise 1..8, contrast .15..1
)
SAMPLE_STEP = 4  # of the greys whose range is taken
TELLING_RANKS = (0.01, 0.5, 0.99)  # darkest, middle and brightest of them
BLACK_GREY, SATURATED_GREY = 1, 250  # up to the one and from the other on the sensor clips: no noise there
MOST_SMOOTHING = 2.0  # beyond this the weakest quarter of the gradients is texture, not noise
RAYLEIGH_QUARTER = 0.7585  # lower quartile of the length of a plane Gaussian vector, in standard deviations
FEWEST_FLAT = 500  # gradients before their lower quartile is believed
FEWEST_CLIPPED = 50  # sampled pixels of the brightest grey before it is where an image clips
LEAST_CLIPPED = 64  # grey
CLIPPED_SPREAD, NOISY = 3.0, 0.6  # standard deviations below it, and their least, grey: else faces are even


def grey_noise(image: Pixels) -> Floats:
    """Standard deviation of the noise at each of the 256 grey levels.

    The second-difference mask of Immerkaer (1996) removes planes and straight axis-parallel edges; the median
    of its absolute value in bands of equal grey gives points of variance = a + b grey (read and shot noise),
    fitted with a, b >= 0.

    Parameters
    ----------
    image
        Grey, (H, W), encoded as it came (before any tone curve is undone).

    Returns
    -------
    float64 (256,), grey; never under what rounding to the image's steps leaves.
    """
    a, b = 0.0, 0.0
    if min(image.shape) >= 5:
        step = max(3, image.shape[0] // SAMPLED_ROWS)
        medians, counts = _deep_medians(image, step) if is_deep(image) else _medians(image, step)
        a, b = _variance_line(medians, counts)
    return np.asarray(np.sqrt(np.maximum(a + b * LEVELS, rounding_sd(image) ** 2)), dtype=np.float64)


def _deep_medians(image: Pixels, step: int) -> tuple[Floats, Floats]:
    """`_band_medians` of an image with fractions of grey; only 0 itself counts as black there."""
    rows = np.arange(0, len(image) - 2, step)
    top, middle, bottom = (in_grey(image[rows + k]) for k in range(3))
    column = top - 2 * middle + bottom
    response = np.abs(column[:, 1:-3] - 2 * column[:, 2:-2] + column[:, 3:-1])
    centre = 0.5 * (middle[:, :-4] + middle[:, 4:])
    medians, counts = np.zeros(BANDS), np.zeros(BANDS)
    band = np.where((centre > 0.0) & (centre < SATURATED_GREY), centre * (BANDS / 256.0), BANDS).astype(int)
    for number in range(BANDS):
        of_band = response[band == number]
        counts[number] = len(of_band)
        medians[number] = np.median(of_band) if len(of_band) else 0.0
    return medians, counts


def _medians(image: Grey, step: int) -> tuple[Floats, Floats]:
    """`_band_medians`, of which all are less than the largest that is counted."""
    medians, counts = _band_medians(image, step, USUAL_RESPONSE)
    if medians.max() < USUAL_RESPONSE:
        return medians, counts
    return _band_medians(image, step, LARGEST_RESPONSE)


@kernel()
def _band_medians(image: Grey, step: int, largest: int) -> tuple[Floats, Floats]:
    """Median of the mask's absolute response in each band of grey, and how many responses it is of.

    Responses of more than ``largest`` count as that: medians that reach it are no medians.
    """
    rows, columns = image.shape
    histogram = np.zeros((BANDS, largest + 1), np.int32)
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
                histogram[(centre * BANDS) >> 8, min(response, largest)] += 1
    medians, counts = np.zeros(BANDS), np.zeros(BANDS)
    for band in range(BANDS):
        total = 0
        for k in range(largest + 1):
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


@kernel()
def _variance_line(medians: Floats, counts: Floats) -> tuple[float, float]:
    """The weighted fit variance = a + b grey with a, b >= 0 over the bands that have enough samples."""
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


def gradient_scale(image: Pixels, noise: Floats, counts: Ints) -> float:
    """Scale of the gradient that suits an image: fine when clean, coarse when noise drowns its contrast.

    Parameters
    ----------
    image
        Grey, (H, W).
    noise
        float64 (256,), its noise from `grey_noise`.
    counts
        Of its greys, from `sampled_greys`.

    Returns
    -------
    Sigma of the Gaussian derivative, px.
    """
    if is_deep(image):
        sampled = image[::SAMPLE_STEP, ::SAMPLE_STEP]
        low, middle, high = (grey_per_count(image) * np.quantile(sampled, TELLING_RANKS)).tolist()
        share = float(noise[int(0.5 * (middle + high))]) / max(high - low, FINEST_STEP_GREY)
    else:
        low, middle, high = _of_ranks(counts)
        share = float(noise[(middle + high) // 2]) / max(high - low, 1)
    scale: float = SCALE_PER_ROOT * share ** (1.0 / 3.0)
    return min(max(scale, FINEST_SCALE_PX), COARSEST_SCALE_PX)


@kernel()
def _of_ranks(counts: Ints) -> tuple[int, int, int]:
    """Greys of `TELLING_RANKS`, by how many pixels have each of 256."""
    greys, total = np.zeros(3, np.int64), counts.sum() - 1
    for number, rank in enumerate(TELLING_RANKS):
        left = int(rank * total) - counts[0]
        while left >= 0:
            greys[number] += 1
            left -= counts[greys[number]]
    return greys[0], greys[1], greys[2]


def clipping_grey(counts: Ints, noise: Floats) -> int:
    """Grey from which an image clips: `SATURATED_GREY`, or less where it was scaled after it was taken.

    Noise spreads what is brightest. Where as many pixels have the brightest grey of all as within that noise
    below it, the sensor clipped there.

    Parameters
    ----------
    counts
        Of its greys, from `sampled_greys`.
    noise
        float64 (256,), its noise from `grey_noise`.
    """
    top = int(np.flatnonzero(counts)[-1])
    below = counts[max(top - math.ceil(CLIPPED_SPREAD * noise[top]), 0) : top].sum()
    if not LEAST_CLIPPED <= top < SATURATED_GREY or noise[top] < NOISY:
        return SATURATED_GREY
    if counts[top] < max(FEWEST_CLIPPED, below):
        return SATURATED_GREY
    return top - (255 - SATURATED_GREY)


def sampled_greys(image: Pixels) -> Ints:
    """How many of an image's pixels (H, W), of which some are sampled, have each of the 256 whole greys."""
    return _counts(rounded(image[::SAMPLE_STEP, ::SAMPLE_STEP]), 1) if is_deep(image) else _counts(image)


@kernel()
def _counts(image: Grey, step: int = SAMPLE_STEP) -> Ints:
    """How many of the sampled pixels have each of the 256 greys."""
    counts = np.zeros(256, np.int64)
    for y in range(0, len(image), step):
        for x in range(0, image.shape[1], step):
            counts[image[y, x]] += 1
    return counts


def smooth_noise_factor(magnitude: Field, grey: Pixels, noise_of: Field) -> float:
    """How much stronger the weakest quarter of the gradients is than white noise of the measured size.

    Demosaicing, compression and scaling smooth the noise of a camera: its second differences, on which the
    noise is measured, fall more than its gradient does. Flat parts show it, and the weakest quarter is there.

    Parameters
    ----------
    magnitude, grey
        Same shape: gradients of a sample of pixels, float32, and their grey.
    noise_of
        float32 (256,), standard deviation of the gradient from white noise, for each grey.

    Returns
    -------
    1 to 2.
    """
    ratio = _of_noise(magnitude, grey, rounded(grey), 0 if is_deep(grey) else BLACK_GREY, noise_of)
    if len(ratio) < FEWEST_FLAT:
        return 1.0
    quarter = float(np.partition(ratio, len(ratio) // 4)[len(ratio) // 4])
    return float(min(max(quarter / RAYLEIGH_QUARTER, 1.0), MOST_SMOOTHING))


@kernel()
def _of_noise(magnitude: Field, grey: Pixels, whole: Grey, black: int, noise_of: Field) -> Field:
    """Gradients (N,) over their noise, of the pixels (R, W) that are neither black nor clipped."""
    found, count = np.empty(magnitude.size, np.float32), 0
    for y in range(len(whole)):
        for x in range(whole.shape[1]):
            found[count] = magnitude[y, x] / noise_of[whole[y, x]]
            count += (grey[y, x] > black) & (whole[y, x] < SATURATED_GREY)
    return found[:count]
