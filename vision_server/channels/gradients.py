"""The smoothed gradient of one channel at the scales that refinement asks for, computed once and kept."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

import cv2
import numpy as np

from vision_server.channels.channel import ChannelStatistics
from vision_server.channels.depth import Field, Grey, linear_image
from vision_server.channels.gaussian import contrast_kernels, gaussian_gradient, gaussian_kernels, noise_gain
from vision_server.channels.noise import SATURATED_GREY

SCALES_PX = (1.0, 2.0, 4.0, 8.0)  # Gaussian derivatives: sharp, soft, defocused, motion-blurred


Region = tuple[int, int, int, int]  # left, top, right, bottom, px; right and bottom are one past

NOWHERE: Region = (0, 0, 0, 0)
# Chosen by hand where nothing else is said.
MARGIN_PX = 32  # filled around what is asked for: the next pose is near this one
ALIGNED_PX = 32  # regions start at multiples: filters that work on blocks then give the same everywhere


class FrameSource(Protocol):
    """A frame, of which a part is computed when that is asked for."""

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width, px."""

    def within(self, region: Region) -> tuple[Field, Field, Grey]:
        """Linear intensity 0..255 at the frame's own exposure; the standard deviation of its noise; 1 where
        the sensor was saturated; (h, w) each, of a region."""


class WholeFrame(NamedTuple):
    """A frame that is computed already, (H, W) each, as `FrameSource.within` tells it."""

    linear: Field
    noise: Field
    clipped: Grey

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width, px."""
        height, width = self.linear.shape
        return height, width

    def within(self, region: Region) -> tuple[Field, Field, Grey]:
        """Of a region."""
        left, top, right, bottom = region
        there = np.s_[top:bottom, left:right]
        return self.linear[there], self.noise[there], self.clipped[there]


@dataclass(eq=False)
class GradientChannel:
    """One channel as refinement sees it.

    The arrays have the image's size, but are filled only where and when something is looked for: memory that
    nobody writes to is none.

    Attributes
    ----------
    name
        Of the image.
    frame
        What is filled in from.
    noise
        float32 (H, W), standard deviation of the linear intensity from sensor noise.
    gradient
        float32 (S, H, W, 2), derivatives along x and y per px; filled per scale, see `prepare`.
    smooth
        float32 (H, W), linear intensity smoothed at the first scale, filled with that.
    near_clipped
        uint8 (S, H, W), 1 where a saturated pixel is within the filter's reach.
    """

    name: str
    frame: FrameSource
    noise: Field = field(init=False)
    gradient: Field = field(init=False)
    smooth: Field = field(init=False)
    near_clipped: Grey = field(init=False)
    _filled: list[Region] = field(init=False)

    def __post_init__(self) -> None:
        shape = (len(SCALES_PX), *self.frame.shape)
        self.gradient = np.empty((*shape, 2), np.float32)
        self.noise, self.smooth = np.empty(shape[1:], np.float32), np.empty(shape[1:], np.float32)
        self.near_clipped = np.zeros(shape, np.uint8)
        self._filled = [NOWHERE] * len(SCALES_PX)

    def prepare(self, scales: int, needed: Region | None = None) -> None:
        """Fill the first ``scales`` scales of SCALES_PX where ``needed`` says; everywhere without it."""
        height, width = self.frame.shape
        wanted = (0, 0, width, height) if needed is None else _within(needed, width, height)
        for index in range(scales):
            filled = self._filled[index]
            if wanted == NOWHERE or _union(filled, wanted) == filled:
                continue
            left, top, right, bottom = wanted
            around = (left - MARGIN_PX, top - MARGIN_PX, right + MARGIN_PX, bottom + MARGIN_PX)
            self._filled[index] = _union(filled, _within(around, width, height))
            self._fill(index, self._filled[index])

    def _fill(self, index: int, region: Region) -> None:
        """One scale in one region, from what surrounds it."""
        height, width = self.frame.shape
        kernels = gaussian_kernels(SCALES_PX[index])
        reach = len(kernels[0]) // 2
        left, top, right, bottom = region
        x0, y0, x1, y1 = _within(
            (left - reach, top - reach, right + reach + ALIGNED_PX, bottom + reach), width, height
        )
        x0 -= x0 % ALIGNED_PX
        source, noise, clipped = self.frame.within((x0, y0, x1, y1))
        there = np.s_[top:bottom, left:right]
        inner = np.s_[top - y0 : bottom - y0, left - x0 : right - x0]
        along_x, along_y = gaussian_gradient(source, kernels)
        cv2.merge([along_x[inner], along_y[inner]], dst=self.gradient[index][there])
        if index == 0:
            blurred = cv2.GaussianBlur(source, (0, 0), SCALES_PX[0], borderType=cv2.BORDER_REPLICATE)
            self.smooth[there], self.noise[there] = blurred[inner], noise[inner]
        if cv2.countNonZero(clipped):
            side = 2 * int(np.ceil(2.0 * SCALES_PX[index])) + 1
            grown = cv2.dilate(clipped, np.ones((side, side), np.uint8))
            self.near_clipped[index][there] = grown[inner]


def _within(region: Region, width: int, height: int) -> Region:
    """The part of a region that is in the image."""
    left, top, right, bottom = region
    left, top, right, bottom = max(left, 0), max(top, 0), min(right, width), min(bottom, height)
    return (left, top, right, bottom) if left < right and top < bottom else NOWHERE


def _union(one: Region, other: Region) -> Region:
    """The least region that holds both."""
    if NOWHERE in (one, other):
        return other if one == NOWHERE else one
    return (min(one[0], other[0]), min(one[1], other[1]), max(one[2], other[2]), max(one[3], other[3]))


@dataclass(frozen=True, eq=False)
class _OfStatistics:
    """The frame whose edge statistics are known; their noise is that of the contrast, and is brought back to
    single pixels here."""

    statistics: ChannelStatistics

    @property
    def shape(self) -> tuple[int, int]:
        return self.statistics.shape

    def within(self, region: Region) -> tuple[Field, Field, Grey]:
        known, (left, top, right, bottom) = self.statistics, region
        image = known.image[top:bottom, left:right]
        deep = None if known.deep is None else known.deep[top:bottom, left:right]
        kernels = contrast_kernels(known.sigma_px, known.exposure)
        gain = np.float32(noise_gain(kernels) * known.noise_factor)
        coarse = known.light.noise
        rows = np.minimum(np.arange(top, bottom) // 2, coarse.shape[0] - 1)
        columns = np.minimum(np.arange(left, right) // 2, coarse.shape[1] - 1)
        noise = coarse[np.ix_(rows, columns)] / gain
        linear = linear_image(image, 1.0, known.linear_of) if deep is None else deep
        return linear, np.asarray(noise, np.float32), (image >= SATURATED_GREY).astype(np.uint8)


def gradient_channel(name: str, statistics: ChannelStatistics) -> GradientChannel:
    """The refinement's view of a channel whose edge statistics are known."""
    return GradientChannel(name, _OfStatistics(statistics))
