"""Per-channel statistics: what one image says about edges, computed once and kept.

A *channel* is one image of the set. Its gradient is measured on linear intensity (tone curve undone) with the
exposure divided out, so that channels are comparable. Each pixel gets a weight that says how lit it is in
this channel, and the noise that the gradient carries there. Weight and noise are smooth and are kept for
each 2 x 2 px; the gradient is kept as a list of the pixels where it exceeds its noise.

The weight is 2^(k l). l is the mean of the darkest and the brightest log2 intensity within reach: a shadow
edge has a side that is darker than in the other channels, so its weight collapses, and because darkest and
brightest are the same all across an edge, the weight does not move the edge."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from bridge.errors import BadInput
from numerics.two_cores import both
from vision_server.channels.blur import blur_sigma, halved
from vision_server.channels.gaussian import gaussian_kernels
from vision_server.channels.gradient_pixels import GradientFilter, GradientPixels, Places, joined
from vision_server.channels.lighting import light_rows
from vision_server.channels.noise import FINEST_SCALE_PX, gradient_scale, grey_noise

Grey = NDArray[np.uint8]
Field = NDArray[np.float32]

WEIGHT_EXPONENT = 12.0  # k: how steeply a channel loses its say where it is darker
LIT_OFFSET_GREY = 8.0  # grey at reference exposure added before the logarithm: black is black
REACH = 2.5  # how far they are taken from, in standard deviations of an edge's spread
SHARP_PX = 2.0  # blur up to this is what any lens and pixel do
SHARPNESS_EXPONENT = (
    4.0  # a channel's say falls with its blur to this power: sharp ones know where an edge is
)
SATURATED_GREY = 250  # from here on a pixel is clipped
SCALE_OF_BLUR = 0.2  # of the gradient, at least: much finer than the blur it would see noise only
CLIPPED_STOPS = 0.25  # beside a clipped pixel a channel counts as so much darker: others know better
FLOOR_NOISE_RATIO = 3.0  # a gradient under so many of its own standard deviations is no edge
LOG2_WEIGHT_LIMIT = 100.0  # float32 holds 2^126; room for sums


@dataclass(frozen=True, eq=False)
class ChannelStatistics:
    """What one image contributes to the merged edge map.

    Attributes
    ----------
    image
        uint8 (H, W), as it came.
    gradient
        Pixels whose gradient stands out of the noise. Magnitudes are contrasts: the height in grey, at
        reference exposure, of the ideal step edge that would give the gradient (gradient times
        sqrt(2 pi) sigma).
    coarse_weight
        float32 (H // 2, W // 2), 2^(k l) for 2 x 2 px: how lit they are in this channel.
    coarse_noise
        float32 (H // 2, W // 2), standard deviation of the contrast from sensor noise.
    coarse_clear
        bool (H // 2, W // 2), False within reach of a clipped pixel.
    linear_of
        float32 (256,), linear intensity of each grey at this frame's own exposure, 0..255 (255 is full
        scale).
    exposure, sigma_px, blur_px
        Relative exposure of the frame; scale of the gradient; blur found in the image.
    noise_factor
        By so much ``coarse_noise`` exceeds what white noise of the measured size would give: 1 to 2.
    """

    image: Grey
    gradient: GradientPixels
    coarse_weight: Field
    coarse_noise: Field
    coarse_clear: NDArray[np.bool_]
    linear_of: Field
    exposure: float
    sigma_px: float
    blur_px: float
    noise_factor: float

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width of the image in px."""
        height, width = self.image.shape
        return height, width

    @cached_property
    def linear(self) -> Field:
        """Linear intensity at this frame's own exposure, 0..255, float32 (H, W)."""
        return np.asarray(cv2.LUT(self.image, self.linear_of), dtype=np.float32)

    @cached_property
    def contrast(self) -> Field:
        """Contrast, 0 where it is below the noise floor, float32 (H, W)."""
        return self._scattered(self.gradient.magnitude)

    @property
    def orientation(self) -> Field:
        """Axis of the gradient, rad in [0, pi), 0 below the noise floor, float32 (H, W)."""
        return self._scattered(self.gradient.axis)

    @cached_property
    def weight(self) -> Field:
        """How lit each pixel is, float32 (H, W)."""
        return self._at_full_size(self.coarse_weight)

    @cached_property
    def noise(self) -> Field:
        """Standard deviation of ``contrast`` from sensor noise, float32 (H, W)."""
        return self._at_full_size(self.coarse_noise)

    @property
    def unsaturated(self) -> NDArray[np.bool_]:
        """False within reach of a clipped pixel, bool (H, W)."""
        return np.asarray(self._at_full_size(self.coarse_clear.astype(np.float32)) > 0, dtype=np.bool_)

    def _scattered(self, values: Field) -> Field:
        field = np.zeros(self.shape, np.float32)
        field.ravel()[self.gradient.places] = values
        return field

    def _at_full_size(self, coarse: Field) -> Field:
        rows, columns = self.shape
        field = np.repeat(np.repeat(coarse, 2, axis=0), 2, axis=1)
        return np.pad(field, ((0, rows - len(field)), (0, columns - field.shape[1])), mode="edge")


def _tables(
    image: Grey, exposure: float, gamma: float, exponent: float
) -> tuple[Field, Field, NDArray[np.float64], NDArray[np.float64]]:
    """Per grey level: linear intensity, root of the weight, noise in grey, noise in linear intensity."""
    linear, slope = _linear(gamma)
    grey_sd = grey_noise(image)
    stops = np.log2((linear / exposure + LIT_OFFSET_GREY) / 128.0)
    exponents = np.clip(exponent * stops, -LOG2_WEIGHT_LIMIT, LOG2_WEIGHT_LIMIT)
    return linear.astype(np.float32), np.exp2(0.5 * exponents).astype(np.float32), grey_sd, grey_sd * slope


@cache
def _linear(gamma: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Linear intensity of each grey, 0..255, and its slope."""
    linear = 255.0 * (np.arange(256, dtype=np.float64) / 255.0) ** gamma
    return linear, np.gradient(linear)


class _Gradient(NamedTuple):
    """The filter, its noise for each grey if the image's is white, and by so much that is exceeded."""

    filter: GradientFilter
    noise_of: Field
    noise_factor: float


def _gradient(
    image: Grey, linear_of: Field, linear_sd: NDArray[np.float64], scale: float, exposure: float
) -> _Gradient:
    smooth, derivative = gaussian_kernels(scale)
    scaled = derivative * np.float32(np.sqrt(2.0 * np.pi) * scale / exposure)
    noise_of = (linear_sd * float(np.linalg.norm(smooth) * np.linalg.norm(scaled))).astype(np.float32)
    gradient = GradientFilter(image, linear_of, (smooth, scaled))
    return _Gradient(gradient, noise_of, gradient.noise_factor(noise_of))


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

    def blurred() -> tuple[Grey, float]:
        half = halved(image)
        return half, blur_sigma(half)

    def noisy() -> tuple[Field, Field, NDArray[np.float64], float, _Gradient]:
        linear_of, root, grey_sd, linear_sd = _tables(image, exposure, gamma, weight_exponent)
        scale = gradient_scale(image, grey_sd) if sigma_px is None else sigma_px
        return linear_of, root, linear_sd, scale, _gradient(image, linear_of, linear_sd, scale, exposure)

    (half, blur), (linear_of, root, linear_sd, scale, gradient) = both(blurred, noisy)
    if sigma_px is None and scale < SCALE_OF_BLUR * blur:
        scale = SCALE_OF_BLUR * blur
        gradient = _gradient(image, linear_of, linear_sd, scale, exposure)
    noise_of = gradient.noise_of * np.float32(gradient.noise_factor)
    floor_of = np.float32(FLOOR_NOISE_RATIO * gradient.noise_factor) * gradient.noise_of
    spread = np.sqrt(scale**2 + max(blur**2 - SHARP_PX**2, 0.0))
    reach = max(int(np.round(0.5 * REACH * spread)), 1)
    root *= np.float32((FINEST_SCALE_PX / spread) ** (0.5 * SHARPNESS_EXPONENT))
    clipped_factor = np.float32(2.0 ** (-weight_exponent * CLIPPED_STOPS))
    level, clear = np.empty(half.shape, np.uint8), np.empty(half.shape, np.bool_)
    weight, noise = np.empty((2, *half.shape), np.float32)

    def rows(first: int, end: int) -> tuple[Places, Field]:
        """Of the image, both even unless they are all there are."""
        light_rows(
            half, reach, root, noise_of, SATURATED_GREY, clipped_factor, first >> 1, end >> 1,
            level, weight, noise, clear,
        )  # fmt: skip
        return gradient.filter.pixels(level, floor_of, first, end)

    middle = len(image) // 4 * 2
    parts = both(lambda: rows(0, middle), lambda: rows(middle, len(image)))
    return ChannelStatistics(
        image,
        joined(parts),
        weight,
        noise,
        clear,
        linear_of,
        exposure,
        scale,
        blur,
        gradient.noise_factor,
    )
