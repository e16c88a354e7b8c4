"""How lit each channel is: the weight that decides which channel is believed where, and the noise there.

This weight does nearly all that the merge of channels achieves (docs/edges.md). At each pixel it is

    w = 2^(k l),   l = (stops(darkest) + stops(brightest)) / 2,   stops(I) = log2((I / e + 8) / 128)

with k = 12, I the linear grey, e the exposure, and the darkest and the brightest taken within reach of the
pixel. A shadow edge has a side that is darker than in the other channels, so its weight collapses. Because
darkest and brightest are the same all across an edge, the weight does not move the edge. An outline that is
lit in few channels is not averaged with dark ones. Blurred channels and clipped pixels count less.

All of it is smooth, and kept for each 2 x 2 px.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from numerics.arrays import Field, Floats, Grey
from numerics.kernels import kernel
from vision_server.channels.depth import LEVELS, PER_GREY, WHITE, Pixels, is_deep, rounded
from vision_server.channels.noise import SATURATED_GREY

# Chosen by hand on renders and on photographs of leaves: `python -m benchmarks.edge_quality`.
WEIGHT_EXPONENT = 12.0  # k: how steeply a channel loses its say where it is darker
LIT_OFFSET_GREY = 8.0  # grey at reference exposure added before the logarithm: black is black
REACH = 2.5  # how far darkest and brightest are looked for, in standard deviations of an edge's spread
LENS_BLUR_PX = 2.0  # blur up to this is what any lens and pixel do
SHARPNESS_EXPONENT = 4.0  # a channel's say falls with its blur to this power: sharp ones place an edge
SHARPEST_PX = 0.7  # the spread of an edge in the sharpest channel: the finest scale of the gradient
CLIPPED_STOPS = 0.25  # beside a clipped pixel a channel counts as so much darker: others know better
LOG2_WEIGHT_LIMIT = 100.0  # float32 holds 2^126; room for sums
SMOOTHING_PX = 0.5  # of the halved image, against noise
COUNTS = np.arange(WHITE + 1) / PER_GREY  # grey of each of uint16


class Lighting(NamedTuple):
    """For each 2 x 2 px, (H // 2, W // 2) each.

    Attributes
    ----------
    level
        Their grey, smoothed, uint8 or uint16, see `depth`.
    reach
        How far the darkest and the brightest of them are looked for, of them.
    noise_of
        float32 (256,), for each grey the standard deviation of the contrast from sensor noise, grey at
        reference exposure.
    weight_of_darkest, weight_of_brightest
        float32 (256,), for each grey its factor of the weight.
    is_even
        Whether the weight is 1 everywhere instead.
    """

    level: Pixels
    reach: int
    noise_of: Field
    weight_of_darkest: Field
    weight_of_brightest: Field
    is_even: bool = False

    def weight_of_rows(self, first: int, end: int) -> Field:
        """`weight` of these rows; (1, 1) where it is even."""
        if self.is_even:
            return np.ones((1, 1), np.float32)
        top = max(first - self.reach, 0)
        level, there = self.level[top : end + self.reach], np.s_[first - top : end - top]
        darkest = _looked_up(cv2.erode(level, self._window)[there], self.weight_of_darkest)
        brightest = _looked_up(cv2.dilate(level, self._window)[there], self.weight_of_brightest)
        return np.asarray(cv2.multiply(darkest, brightest))

    @property
    def weight(self) -> Field:
        """How lit they are in this channel, float32 (H // 2, W // 2)."""
        weight = self.weight_of_rows(0, len(self.level))
        return np.full(self.level.shape, weight) if self.is_even else weight

    @property
    def brightest(self) -> Grey:
        """Grey of the brightest within reach, uint8 (H // 2, W // 2)."""
        return np.asarray(cv2.dilate(rounded(self.level), self._window), np.uint8)

    @property
    def _window(self) -> Grey:
        return np.ones((2 * self.reach + 1, 2 * self.reach + 1), np.uint8)

    def noise_at(self, places: NDArray[np.int32]) -> Field:
        """`noise` at flat indices (N,) into the 2 x 2 px."""
        if is_deep(self.level):
            return _looked_up(self.level.ravel()[places], self.noise_of)
        return _noise_at(self.level, places, self.noise_of)

    @property
    def noise(self) -> Field:
        """Standard deviation of the contrast from sensor noise, float32 (H // 2, W // 2)."""
        return self.noise_of_rows(0, len(self.level))

    def noise_of_rows(self, first: int, end: int) -> Field:
        """`noise` of these rows."""
        return _looked_up(self.level[first:end], self.noise_of)


def smoothed(half: Pixels) -> Pixels:
    """The halved image without its pixels' noise, same type and shape."""
    level = cv2.GaussianBlur(half, (3, 3), SMOOTHING_PX, borderType=cv2.BORDER_REPLICATE)
    return np.asarray(level, half.dtype)


def lighting(
    level: Pixels, linear_of: Floats, exposure: float, spread_px: float, noise_of: Field,
    weight_exponent: float = WEIGHT_EXPONENT,
) -> Lighting:  # fmt: skip
    """Weight and noise of one channel.

    Parameters
    ----------
    level
        uint8 or uint16 (H // 2, W // 2), the image halved and smoothed.
    linear_of, noise_of
        (256,), for each grey its linear intensity (0..255) and the noise of the contrast there.
    exposure
        Relative exposure.
    spread_px
        Standard deviation of an ideal edge in the gradient: scale and blur together.
    weight_exponent
        k; 0 weighs all channels alike.
    """
    sharpness = (SHARPEST_PX / spread_px) ** SHARPNESS_EXPONENT
    root, root_of_brightest = _roots(linear_of, exposure, math.sqrt(sharpness), weight_exponent)
    reach = max(int(np.round(0.5 * REACH * spread_px)), 1)
    return Lighting(level, reach, noise_of, root, root_of_brightest)


@kernel()
def _roots(
    linear_of: Floats, exposure: float, sharpness: float, weight_exponent: float
) -> tuple[Field, Field]:
    """Factors of the weight (256,) by the darkest and by the brightest grey, each times ``sharpness``."""
    darkest, brightest = np.empty(256, np.float32), np.empty(256, np.float32)
    less = np.float32(2.0 ** (-weight_exponent * CLIPPED_STOPS))
    for grey in range(256):
        stops = math.log2((linear_of[grey] / exposure + LIT_OFFSET_GREY) / 128.0)
        exponent = min(max(weight_exponent * stops, -LOG2_WEIGHT_LIMIT), LOG2_WEIGHT_LIMIT)
        darkest[grey] = 2.0 ** (0.5 * exponent) * sharpness
        brightest[grey] = darkest[grey] * less if grey >= SATURATED_GREY else darkest[grey]
    return darkest, brightest


def _looked_up(level: Any, table: Field) -> Field:
    """Entries (256,) of a table for each grey, between them where it has fractions."""
    if is_deep(level):
        return np.asarray(np.interp(COUNTS, LEVELS, table).astype(np.float32)[level])
    return np.asarray(cv2.LUT(level, table), np.float32)


@kernel()
def _noise_at(level: Grey, places: NDArray[np.int32], noise_of: Field) -> Field:
    """As `Lighting.noise_at`, of whole greys."""
    found, flat = np.empty(len(places), np.float32), level.ravel()
    for i in range(len(places)):
        found[i] = noise_of[flat[places[i]]]
    return found


@kernel()
def coarse_places(places: NDArray[np.int32], columns: int, coarse: tuple[int, int]) -> NDArray[np.int32]:
    """Flat indices (N,) of the 2 x 2 px, of which there are ``coarse`` rows and columns, that hold pixels."""
    found = np.empty(len(places), np.int32)
    for i in range(len(places)):
        y = places[i] // columns
        v, u = min(y >> 1, coarse[0] - 1), min((places[i] - y * columns) >> 1, coarse[1] - 1)
        found[i] = v * coarse[1] + u
    return found
