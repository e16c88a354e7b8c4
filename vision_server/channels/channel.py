"""Per-channel statistics: what one image says about edges, computed once and kept.

A *channel* is one image of the set. Three things are known of it: how lit each of its pixels is, by which
channels are weighted against each other (`lighting`, the part that matters most); where its gradient stands
out of its noise, with which contrast and which axis (`gradient_pixels`); and how large that noise is
(`noise`). All is measured on linear intensity (tone curve undone) with the exposure divided out, so that
channels can be compared.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from bridge.errors import BadInput
from numerics.arrays import Field, Grey
from numerics.two_cores import both
from vision_server.channels.bands import GradientRows
from vision_server.channels.blur import blur_sigma, halved, lone_edge_blur
from vision_server.channels.depth import (
    PIXEL_TYPES,
    ROUNDING_SD,
    Pixels,
    linear_image,
    linear_slope,
    linear_table,
    rounded,
    rounding_sd,
    stretched,
)
from vision_server.channels.gaussian import contrast_kernels, noise_gain
from vision_server.channels.gradient_pixels import GradientPixels, joined
from vision_server.channels.lighting import LENS_BLUR_PX, WEIGHT_EXPONENT, Lighting, lighting, smoothed
from vision_server.channels.noise import (
    SATURATED_GREY,
    clipping_grey,
    gradient_scale,
    grey_noise,
    sampled_greys,
    smooth_noise_factor,
)

# Chosen by hand where nothing else is said.
SCALE_OF_BLUR = 0.2  # of the gradient, at least: much finer than the blur it would see noise only
FLOOR_NOISE_RATIO = 3.0  # a gradient under so many of its own standard deviations is no edge: 1.1 % of noise
SHARE_BESIDE_LIGHTING = 0.65  # of the rows, listed on one core while the other finds how lit the image is


@dataclass(frozen=True, eq=False)
class ChannelStatistics:
    """What one image contributes to the merged edge map.

    Attributes
    ----------
    pixels
        (H, W), as they came, see `depth`; ``gamma`` is their tone curve.
    gradient
        Pixels whose gradient stands out of the noise. Magnitudes are contrasts: the height in grey, at
        reference exposure, of the ideal step edge that would give the gradient (gradient times
        sqrt(2 pi) sigma).
    light
        How lit each 2 x 2 px are in this channel, and the noise of the contrast there.
    linear_of
        float32 (256,), linear intensity of each grey at this frame's own exposure, 0..255 (255 is full
        scale).
    exposure, sigma_px, blur_px
        Relative exposure of the frame; scale of the gradient; blur found in the image.
    noise_factor
        By so much the noise exceeds what white noise of the measured size would give: 1 to 2.
    rounding_sd
        Standard deviation of what rounding to the image's steps leaves, grey.
    clipped_from
        Grey from which its pixels are clipped.
    """

    pixels: Pixels
    gamma: float
    gradient: GradientPixels
    light: Lighting
    linear_of: Field
    exposure: float
    sigma_px: float
    blur_px: float
    noise_factor: float
    rounding_sd: float = ROUNDING_SD
    clipped_from: int = SATURATED_GREY

    @property
    def image(self) -> Grey:
        """The image as a picture, uint8 (H, W)."""
        return rounded(self.pixels)

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width of the image in px."""
        height, width = self.pixels.shape
        return height, width

    def same_picture(self, other: ChannelStatistics) -> bool:
        """Whether two images are alike to the last pixel; of one grey they may be without being the same."""
        one, two = self.pixels, other.pixels
        middle = len(one) // 2
        if one.dtype != two.dtype or not np.array_equal(one[middle], two[middle]):
            return False
        return np.array_equal(one, two) and bool(one.min() < one.max())

    @cached_property
    def linear(self) -> Field:
        """Linear intensity at this frame's own exposure, 0..255, float32 (H, W)."""
        return linear_image(self.pixels, self.gamma, self.linear_of)

    def linear_at(self, rows: slice, columns: slice) -> Field:
        """`linear` of some rows and columns, without the others."""
        return linear_image(np.ascontiguousarray(self.pixels[rows, columns]), self.gamma, self.linear_of)

    @cached_property
    def lone_blur_px(self) -> float | None:
        """Blur of the edges that stand alone, px, which is that of lens and motion; None where none tells."""
        return lone_edge_blur(stretched(halved(self.pixels)))

    @cached_property
    def contrast(self) -> Field:
        """Contrast, 0 where it is below the noise floor, float32 (H, W)."""
        return self._scattered(self.gradient.magnitude)

    @cached_property
    def orientation(self) -> Field:
        """Axis of the gradient, rad in [0, pi), 0 below the noise floor, float32 (H, W)."""
        return self._scattered(self.gradient.axis)

    @cached_property
    def weight(self) -> Field:
        """How lit each pixel is, float32 (H, W)."""
        return self._at_full_size(self.light.weight)

    @cached_property
    def noise(self) -> Field:
        """Standard deviation of ``contrast`` from sensor noise, float32 (H, W)."""
        return self._at_full_size(self.light.noise)

    def _scattered(self, values: Field) -> Field:
        field = np.zeros(self.shape, np.float32)
        field.ravel()[self.gradient.places] = values
        return field

    def _at_full_size(self, coarse: Field) -> Field:
        rows, columns = self.shape
        field = np.repeat(np.repeat(coarse, 2, axis=0), 2, axis=1)
        return np.pad(field, ((0, rows - len(field)), (0, columns - field.shape[1])), mode="edge")


class _Measured(NamedTuple):
    """The gradient of an image at one scale, its noise for each grey, and by so much that is not white."""

    sigma_px: float
    gradient: GradientRows
    noise_of: Field
    noise_factor: float
    clipped_from: int


def _measured(image: Pixels, gamma: float, exposure: float, sigma_px: float | None) -> _Measured:
    """At a scale, or at the one that suits the image's noise."""
    grey_sd = grey_noise(image)
    counts = sampled_greys(image)
    sigma_px = gradient_scale(image, grey_sd, counts) if sigma_px is None else sigma_px
    kernels = contrast_kernels(sigma_px, exposure)
    found = GradientRows(image, gamma, kernels)
    white = (grey_sd * linear_slope(gamma) * noise_gain(kernels)).astype(np.float32)
    factor = smooth_noise_factor(*found.sampled(), white)
    return _Measured(sigma_px, found, white * np.float32(factor), factor, clipping_grey(counts, grey_sd))


def _check(image: Pixels, exposure: float, gamma: float) -> None:
    if image.ndim != 2 or image.dtype not in PIXEL_TYPES or min(image.shape) < 3:
        raise BadInput(
            "A channel must be grey of at least 3x3 px, uint8, uint16 or float32, "
            f"not {image.dtype} {image.shape}."
        )
    for name, value in (("exposure", exposure), ("gamma", gamma)):
        if not (np.isfinite(value) and value > 0.0):
            raise BadInput(f"The {name} of a channel must be a positive number, not {value}.")


def channel_statistics(
    image: Pixels,
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
        Grey, (H, W), see `depth`.
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
    _check(image, exposure, gamma)
    image = np.ascontiguousarray(image)

    def blurred() -> tuple[Pixels, float]:
        half = halved(image)
        return smoothed(half), blur_sigma(stretched(half))

    found, (level, blur_px) = both(lambda: _measured(image, gamma, exposure, sigma_px), blurred)
    if sigma_px is None and found.sigma_px < SCALE_OF_BLUR * blur_px:
        found = _measured(image, gamma, exposure, SCALE_OF_BLUR * blur_px)
    spread_px = float(np.sqrt(found.sigma_px**2 + max(blur_px**2 - LENS_BLUR_PX**2, 0.0)))
    floor_of = np.float32(FLOOR_NOISE_RATIO) * found.noise_of
    linear_of, whole = linear_table(gamma), rounded(level)
    split = int(SHARE_BESIDE_LIGHTING * len(image))

    def lower() -> tuple[Lighting, GradientPixels]:
        light = lighting(level, linear_of, exposure, spread_px, found.noise_of, weight_exponent)
        return light, found.gradient.pixels(whole, floor_of, split, len(image))

    pixels, (light, others) = both(lambda: found.gradient.pixels(whole, floor_of, 0, split), lower)
    table = linear_of.astype(np.float32)
    return ChannelStatistics(
        image, gamma, joined(pixels, others), light, table, exposure, found.sigma_px, blur_px,
        found.noise_factor, rounding_sd(image), found.clipped_from,
    )  # fmt: skip
