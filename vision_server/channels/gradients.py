"""The smoothed gradient of one channel at the scales that refinement asks for, computed once and kept."""

from __future__ import annotations

from dataclasses import dataclass, field

import cv2
import numpy as np

from vision_server.channels.channel import ChannelStatistics
from vision_server.channels.depth import Field, Grey
from vision_server.channels.gaussian import contrast_kernels, gaussian_gradient, gaussian_kernels, noise_gain
from vision_server.channels.noise import SATURATED_GREY

SCALES_PX = (1.0, 2.0, 4.0, 8.0)  # Gaussian derivatives: sharp, soft, defocused, motion-blurred


Region = tuple[int, int, int, int]  # left, top, right, bottom, px; right and bottom are one past

NOWHERE: Region = (0, 0, 0, 0)
MARGIN_PX = 32  # filled around what is asked for: the next pose is near this one
ALIGNED_PX = 32  # regions start at multiples: filters that work on blocks then give the same everywhere


@dataclass(eq=False)
class GradientChannel:
    """One channel as refinement sees it.

    The arrays have the image's size, but are filled only where and when something is looked for.

    Attributes
    ----------
    name
        Of the image.
    linear
        float32 (H, W), linear intensity at the frame's own exposure, 0..255.
    noise
        float32 (H, W), standard deviation of ``linear`` from sensor noise.
    clipped
        uint8 (H, W), 1 where the sensor was saturated.
    gradient
        float32 (S, H, W, 2), derivatives along x and y per px; filled per scale, see `prepare`.
    smooth
        float32 (H, W), ``linear`` smoothed at the first scale, filled with that.
    near_clipped
        uint8 (S, H, W), 1 where a saturated pixel is within the filter's reach.
    """

    name: str
    linear: Field
    noise: Field
    clipped: Grey
    gradient: Field = field(init=False)
    smooth: Field = field(init=False)
    near_clipped: Grey = field(init=False)
    _filled: list[Region] = field(init=False)
    _some_clipped: bool = field(init=False)

    def __post_init__(self) -> None:
        shape = (len(SCALES_PX), *self.linear.shape)
        self.gradient = np.empty((*shape, 2), np.float32)
        self.smooth = np.empty(self.linear.shape, np.float32)
        self.near_clipped = np.zeros(shape, np.uint8)
        self._filled = [NOWHERE] * len(SCALES_PX)
        self._some_clipped = cv2.countNonZero(self.clipped) > 0

    def prepare(self, scales: int, needed: Region | None = None) -> None:
        """Fill the first ``scales`` scales of SCALES_PX where ``needed`` says; everywhere without it."""
        height, width = self.linear.shape
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
        height, width = self.linear.shape
        kernels = gaussian_kernels(SCALES_PX[index])
        reach = len(kernels[0]) // 2
        left, top, right, bottom = region
        x0, y0, x1, y1 = _within(
            (left - reach, top - reach, right + reach + ALIGNED_PX, bottom + reach), width, height
        )
        x0 -= x0 % ALIGNED_PX
        source = self.linear[y0:y1, x0:x1]
        there = np.s_[top:bottom, left:right]
        inner = np.s_[top - y0 : bottom - y0, left - x0 : right - x0]
        along_x, along_y = gaussian_gradient(source, kernels)
        cv2.merge([along_x[inner], along_y[inner]], dst=self.gradient[index][there])
        if index == 0:
            blurred = cv2.GaussianBlur(source, (0, 0), SCALES_PX[0], borderType=cv2.BORDER_REPLICATE)
            self.smooth[there] = blurred[inner]
        if self._some_clipped:
            side = 2 * int(np.ceil(2.0 * SCALES_PX[index])) + 1
            grown = cv2.dilate(self.clipped[y0:y1, x0:x1], np.ones((side, side), np.uint8))
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


def gradient_channel(name: str, statistics: ChannelStatistics) -> GradientChannel:
    """The refinement's view of a channel whose edge statistics are known.

    Parameters
    ----------
    statistics
        Of its frame; its noise is that of the contrast, and is brought back to single pixels here.
    """
    kernels = contrast_kernels(statistics.sigma_px, statistics.exposure)
    gain = noise_gain(kernels) * statistics.noise_factor
    noise = np.asarray(statistics.noise / np.float32(gain), dtype=np.float32)
    clipped = (statistics.image >= SATURATED_GREY).astype(np.uint8)
    return GradientChannel(name, statistics.linear, noise, clipped)
