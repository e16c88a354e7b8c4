"""Bit depth: images of more than eight bits a pixel, and how many of these they use.

Grey counts from 0 to 255 whatever the depth: an image of 8 bits is uint8, a deeper one uint16 with 257 to a
grey, and one of a float file float32 with its fractions. Where grey only chooses an entry of a table (noise,
light, clipping), a deep image is looked at in its rounded values; where edges are measured, in full.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from bridge.errors import BadInput
from numerics.arrays import Field, Floats, Grey

Deep = NDArray[np.uint16]  # PER_GREY to a grey
Pixels = NDArray[Any]  # uint8, uint16 of PER_GREY to a grey, or float32

PIXEL_TYPES = (np.uint8, np.uint16, np.float32)
WHITE_BITS, WHITE, PER_GREY = 16, 65535, 257  # of uint16: 255 grey
DEPTHS = (10, 12, 14, 16)  # bits of cameras whose files have 16
ROUNDING_SD = 0.3  # of steps of 1, uniform: 1/sqrt(12)
FINEST_STEP_GREY = 255.0 / 65535.0  # finer ones no camera has
SAMPLED_ROWS, SAMPLED_VALUES = 60, 20_000  # of an image, to find its steps
LEVELS = np.arange(256.0)
MOSAIC_TAPS = np.array([0.25, 0.5, 0.25], np.float32)
STRETCHED_RANGE = 232.0  # grey, from 8 to 240: what is measured on a stretched image leaves out what clips
MOST_STRETCH = 256.0  # to steps of 16 bits


def is_deep(image: NDArray[Any]) -> bool:
    """Whether an image has fractions of grey."""
    return image.dtype != np.uint8


def in_grey(image: Pixels) -> Field:
    """The image (H, W) in grey with its fractions, float32; itself if it is that."""
    if image.dtype == np.uint16:
        return np.multiply(image, np.float32(1.0 / PER_GREY), dtype=np.float32)
    return np.asarray(image, np.float32)


def deepened(grey: Pixels) -> Deep:
    """Grey with fractions, float32 (H, W), as uint16."""
    return np.asarray(np.clip(np.rint(grey * np.float32(PER_GREY)), 0.0, WHITE), np.uint16)


@dataclass(frozen=True)
class Raw:
    """What the pixels of a camera are.

    Attributes
    ----------
    bits : of a value in pixels of 16 bits; None where nobody told.
    bayer : whether its colours are a Bayer mosaic, of any order.
    """

    bits: int | None = None
    bayer: bool = False

    def grey(self, pixels: NDArray[Any], highest: int | None = None) -> Pixels:
        """Grey (H, W) of pixels as they came, uint8, uint16 or float32 0..1, see `depth`.

        Without ``bits`` the camera has the fewest of 10, 12, 14 or 16 that hold the pixels, or ``highest``.

        Raises
        ------
        BadInput
            A value of more bits.
        """
        if pixels.dtype == np.uint8:
            return _without_mosaic(pixels) if self.bayer else pixels
        if pixels.dtype != np.uint16:
            grey: Pixels = np.asarray(pixels * np.float32(255.0), np.float32)
            return _without_mosaic(grey) if self.bayer else grey
        most = int(pixels.max(initial=0))
        bits = fewest_bits(max(most, highest or 0)) if self.bits is None else self.bits
        if most >= 2**bits:
            raise BadInput(f"An image has values up to {most}, more than {bits} bits hold.", "Correct bits.")
        scaled = pixels if bits == WHITE_BITS else _scaled(bits)[pixels]
        return _without_mosaic(scaled) if self.bayer else scaled


def _scaled(bits: int) -> Deep:
    """Each value of so many bits as one of sixteen, rounded."""
    most = 2**bits - 1
    return np.asarray((np.arange(2**bits) * WHITE + most // 2) // most, np.uint16)


def fewest_bits(highest: int) -> int:
    """The depth of a camera of 10, 12, 14 or 16 bits that has given this value."""
    return next(bits for bits in DEPTHS if highest < 2**bits)


def _without_mosaic(pixels: Pixels) -> Pixels:
    """(R + 2 G + B) / 4 around each pixel, a deep image: the same weights wherever the mosaic begins.

    Nothing is interpolated, so nothing is made up at edges; they are blurred by 0.7 px more.
    """
    even = cv2.sepFilter2D(
        in_grey(pixels), cv2.CV_32F, MOSAIC_TAPS, MOSAIC_TAPS, borderType=cv2.BORDER_REFLECT_101
    )
    return np.asarray(even, np.float32) if pixels.dtype == np.float32 else deepened(np.asarray(even))


def rounded(image: Pixels) -> Grey:
    """The image (H, W) in whole grey, uint8; itself if it is of 8 bits."""
    if not is_deep(image):
        return np.asarray(image, np.uint8)
    return np.asarray(cv2.convertScaleAbs(image, alpha=grey_per_count(image)), np.uint8)


def grey_per_count(image: Pixels) -> float:
    """Grey of 1 in the image's type."""
    return 1.0 / PER_GREY if image.dtype == np.uint16 else 1.0


def linear_table(gamma: float) -> Floats:
    """Linear intensity 0..255 of each whole grey, float64 (256,): linear = grey^gamma."""
    return np.asarray(255.0 * (LEVELS / 255.0) ** gamma)


@lru_cache
def linear_slope(gamma: float) -> Floats:
    """By how much `linear_table` grows with grey, at each whole one, float64 (256,)."""
    return np.gradient(linear_table(gamma))


def linear_image(image: Pixels, gamma: float, table: Field) -> Field:
    """Linear intensity of an image, float32 (H, W), 0..255; ``table`` is `linear_table` of the gamma."""
    if not is_deep(image):
        return np.asarray(cv2.LUT(image, table), np.float32)
    grey = in_grey(image)
    if gamma == 1.0:
        return grey
    return np.asarray(np.float32(255.0) * cv2.pow(grey * np.float32(1.0 / 255.0), gamma), np.float32)


def rounding_sd(image: Pixels) -> float:
    """Standard deviation of what rounding to the image's own steps leaves, grey.

    The step is the least difference between the values that occur; cameras of 10 or 12 bits often fill 16.
    """
    if not is_deep(image):
        return ROUNDING_SD
    sampled = image[:: max(1, len(image) // SAMPLED_ROWS)].ravel()
    values = np.unique(in_grey(sampled[:: max(1, len(sampled) // SAMPLED_VALUES)]))
    steps = np.diff(values)
    steps = steps[steps > 0.5 * FINEST_STEP_GREY]
    return ROUNDING_SD * max(float(steps.min(initial=1.0)), FINEST_STEP_GREY)


def stretched(image: Pixels) -> Grey:
    """A deep image (H, W) in 8 bits of its own range, where that is narrow; its ends clip then, as at 255."""
    if not is_deep(image):
        return rounded(image)
    scale = grey_per_count(image)
    low, high = (scale * np.percentile(image[::2, ::2], (1.0, 99.9))).tolist()
    factor = STRETCHED_RANGE / max(high - low, STRETCHED_RANGE / MOST_STRETCH)
    if factor <= 1.0:
        return rounded(image)
    whole = np.clip((in_grey(image) - np.float32(low)) * np.float32(factor) + np.float32(8.0), 0.0, 255.0)
    return rounded(whole)
