"""Per-channel statistics: what one image says about edges, computed once and kept.

A *channel* is one image of the set. Its gradient is measured on linear intensity (tone curve undone) with the
exposure divided out, so that channels are comparable. Each pixel gets a weight that says how lit it is in
this channel, and the noise that the gradient carries there.

The weight is 2^(k l). l is the mean of the darkest and the brightest log2 intensity within reach: a shadow
edge has a side that is darker than in the other channels, so its weight collapses, and because darkest and
brightest are the same all across an edge, the weight does not move the edge."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from bridge.errors import BadInput
from vision_server.blur import blur_sigma
from vision_server.gaussian import gaussian_kernels
from vision_server.noise import FINEST_SCALE_PX, gradient_scale, grey_noise

Grey = NDArray[np.uint8]
Field = NDArray[np.float32]

WEIGHT_EXPONENT = 12.0  # k: how steeply a channel loses its say where it is darker
LIT_OFFSET_GREY = 8.0  # grey at reference exposure added before the logarithm: black is black
SMOOTHING_SIGMA_PX = 1.0  # before the darkest and brightest are taken, against noise
SHARP_PX = 2.0  # blur up to this is what any lens and pixel do
SHARPNESS_EXPONENT = (
    4.0  # a channel's say falls with its blur to this power: sharp ones know where an edge is
)
SATURATED_GREY = 250  # from here on a pixel is clipped
MOST_SMOOTHING = 2.0  # beyond this the weakest quarter of the gradients is texture, not noise
RAYLEIGH_QUARTER = 0.7585  # lower quartile of the length of a plane Gaussian vector, in standard deviations
SAMPLE_STEP, MIN_SAMPLES = 4, 500
SCALE_OF_BLUR = 0.2  # of the gradient, at least: much finer than the blur it would see noise only
CLIPPED_STOPS = 0.25  # beside a clipped pixel a channel counts as so much darker: others know better
FLOOR_NOISE_RATIO = 3.0  # a gradient under so many of its own standard deviations is no edge
LOG2_WEIGHT_LIMIT = 100.0  # float32 holds 2^126; room for sums


@dataclass(frozen=True)
class ChannelStatistics:
    """What one image contributes to the merged edge map; all arrays (H, W).

    Attributes
    ----------
    linear
        float32, linear intensity at this frame's own exposure, 0..255 (255 is full scale).
    contrast
        float32, gradient magnitude as the height in grey, at reference exposure, of the ideal step edge that
        would give it (gradient times sqrt(2 pi) sigma); 0 where below the noise floor.
    orientation
        float32, direction of the gradient taken as an axis, rad in [0, pi), 0 along x, pi/2 along y (down).
    weight
        float32, 2^(k l): how lit the pixel is in this channel.
    noise
        float32, standard deviation of ``contrast`` from sensor noise.
    unsaturated
        bool, False within reach of a clipped pixel.
    exposure, sigma_px, blur_px
        Relative exposure of the frame; scale of the gradient; blur found in the image.
    noise_factor
        By so much ``noise`` exceeds what white noise of the measured size would give: 1 to 2.
    """

    linear: Field
    contrast: Field
    orientation: Field
    weight: Field
    noise: Field
    unsaturated: NDArray[np.bool_]
    exposure: float
    sigma_px: float
    blur_px: float
    noise_factor: float

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width of the image in px."""
        height, width = self.linear.shape
        return height, width


@njit(cache=True)
def _describe(
    magnitude: Field,
    angle: Field,
    smoothed: Grey,
    darkest: Grey,
    brightest: Grey,
    half_weight: Field,
    noise_of: Field,
    clipped_grey: int,
    clipped_factor: float,
    floor_ratio: float,
    contrast: Field,
    orientation: Field,
    weight: Field,
    noise: Field,
    unsaturated: NDArray[np.bool_],
) -> None:
    """Contrast, axis, weight and noise at each pixel; the equations of `channel_statistics`."""
    rows, columns = magnitude.shape
    pi = np.float32(np.pi)
    clipped_scale = np.float32(clipped_factor)
    ratio = np.float32(floor_ratio)
    for y in range(rows):
        for x in range(columns):
            w = half_weight[darkest[y, x]] * half_weight[brightest[y, x]]
            clear = brightest[y, x] < clipped_grey
            unsaturated[y, x] = clear
            weight[y, x] = w if clear else w * clipped_scale
            sd = noise_of[smoothed[y, x]]
            noise[y, x] = sd
            m, a = magnitude[y, x], angle[y, x]
            if a >= pi:
                a -= pi
            contrast[y, x] = m if m > ratio * sd else np.float32(0.0)
            orientation[y, x] = a if a < pi else np.float32(0.0)


def _smooth_noise_factor(magnitude: Field, image: Grey, noise_of: Field) -> np.float32:
    """How much stronger the weakest quarter of the gradients is than white noise of the measured size.

    Demosaicing, compression and scaling smooth the noise of a camera: its second differences, on which the
    noise is measured, fall more than its gradient does. Flat parts show it, and the weakest quarter is there.
    """
    sample = np.s_[1::SAMPLE_STEP, 1::SAMPLE_STEP]
    ratio = magnitude[sample] / noise_of[image[sample]]
    ratio = ratio[(image[sample] > 1) & (image[sample] < SATURATED_GREY)]
    if ratio.size < MIN_SAMPLES:
        return np.float32(1.0)
    rank = ratio.size // 4
    quarter = float(np.partition(ratio, rank)[rank])
    return np.float32(min(max(quarter / RAYLEIGH_QUARTER, 1.0), MOST_SMOOTHING))


def _tables(
    image: Grey, exposure: float, gamma: float, exponent: float
) -> tuple[Field, Field, NDArray[np.float64], NDArray[np.float64]]:
    """Per grey level: linear intensity, root of the weight, noise in grey, noise in linear intensity."""
    level = np.arange(256, dtype=np.float64) / 255.0
    linear = 255.0 * level**gamma
    slope = np.gradient(linear)
    grey_sd = grey_noise(image)
    stops = np.log2((linear / exposure + LIT_OFFSET_GREY) / 128.0)
    exponents = np.clip(exponent * stops, -LOG2_WEIGHT_LIMIT, LOG2_WEIGHT_LIMIT)
    return linear.astype(np.float32), np.exp2(0.5 * exponents).astype(np.float32), grey_sd, grey_sd * slope


def channel_statistics(
    image: Grey,
    exposure: float = 1.0,
    gamma: float = 1.0,
    *,
    sigma_px: float | None = None,
    weight_exponent: float = WEIGHT_EXPONENT,
) -> ChannelStatistics:
    """Edge statistics of one image.

    Parameters
    ----------
    image
        uint8 grey, (H, W).
    exposure
        Relative exposure, > 0: shutter / aperture^2 times gain over that of the reference settings.
        Everything measured is divided by it.
    gamma
        Tone curve to undo: linear = grey^gamma. 1 for linear files.
    sigma_px
        Scale of the Gaussian derivative, px; chosen from the image's noise when left out.
    weight_exponent
        k of the weight 2^(k l), with l the mean of log2((I / exposure + 8) / 128) of the darkest and the
        brightest pixel within reach. 0 weighs all channels alike.

    Returns
    -------
    ChannelStatistics

    Raises
    ------
    BadInput
        Wrong type or shape of the image, exposure or gamma not positive.
    """
    if image.ndim != 2 or image.dtype != np.uint8 or min(image.shape) < 3:
        raise BadInput(f"A channel must be grey uint8 of at least 3x3 px, not {image.dtype} {image.shape}.")
    for name, value in (("exposure", exposure), ("gamma", gamma)):
        if not (np.isfinite(value) and value > 0.0):
            raise BadInput(f"The {name} of a channel must be a positive number, not {value}.")
    image = np.ascontiguousarray(image)
    linear_of, half_weight, grey_sd, linear_sd = _tables(image, exposure, gamma, weight_exponent)
    blur = blur_sigma(image)
    suited = max(gradient_scale(image, grey_sd), SCALE_OF_BLUR * blur)
    scale = suited if sigma_px is None else sigma_px

    smooth, derivative = gaussian_kernels(scale)
    to_contrast = float(np.sqrt(2.0 * np.pi) * scale / exposure)
    scaled = derivative * np.float32(to_contrast)
    linear = np.asarray(cv2.LUT(image, linear_of), dtype=np.float32)
    gx = cv2.sepFilter2D(linear, cv2.CV_32F, scaled, smooth, borderType=cv2.BORDER_REPLICATE)
    gy = cv2.sepFilter2D(linear, cv2.CV_32F, smooth, scaled, borderType=cv2.BORDER_REPLICATE)
    magnitude, angle = cv2.cartToPolar(gx, gy)
    noise_of = (linear_sd * float(np.linalg.norm(smooth) * np.linalg.norm(scaled))).astype(np.float32)

    noise_factor = _smooth_noise_factor(np.asarray(magnitude, np.float32), image, noise_of)
    noise_of *= noise_factor
    smoothed = cv2.GaussianBlur(image, (0, 0), SMOOTHING_SIGMA_PX, borderType=cv2.BORDER_REPLICATE)
    spread = np.sqrt(scale**2 + max(blur**2 - SHARP_PX**2, 0.0))
    side = 2 * int(np.ceil(2.5 * spread)) + 1
    window = np.ones((side, side), np.uint8)
    half_weight *= np.float32((FINEST_SCALE_PX / spread) ** (0.5 * SHARPNESS_EXPONENT))
    shape = image.shape
    contrast, orientation = np.empty(shape, np.float32), np.empty(shape, np.float32)
    weight, noise = np.empty(shape, np.float32), np.empty(shape, np.float32)
    unsaturated = np.empty(shape, np.bool_)
    _describe(
        np.asarray(magnitude, np.float32),
        np.asarray(angle, np.float32),
        np.asarray(smoothed, np.uint8),
        np.asarray(cv2.erode(smoothed, window), np.uint8),
        np.asarray(cv2.dilate(smoothed, window), np.uint8),
        half_weight,
        noise_of,
        SATURATED_GREY,
        2.0 ** (-weight_exponent * CLIPPED_STOPS),
        FLOOR_NOISE_RATIO,
        contrast,
        orientation,
        weight,
        noise,
        unsaturated,
    )
    return ChannelStatistics(
        linear, contrast, orientation, weight, noise, unsaturated, exposure, scale, blur, float(noise_factor)
    )
