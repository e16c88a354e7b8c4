"""Merging channels into one edge map: a mixture of orientations at each pixel, fitted by EM.

The state kept per pixel is a histogram of axial orientation (weight times contrast, linear split between
neighbouring bins) with the sums of weight, of weight times contrast and of weight times noise. It is additive
over channels, so the merge does not depend on how many there are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numba import njit

from bridge.errors import BadInput
from vision_server.channel import ChannelStatistics, Field
from vision_server.crests import find_crests, near_crest
from vision_server.mixture import BINS, fit_mixtures, orientation_windows

CANDIDATE_RATIO = 0.6  # a pixel under this share of the largest mass in 5 x 5 cannot be a ridge
CANDIDATE_WINDOW_PX = 5
SLACK = 0.95  # so close to a crest on the first, mean axis a pixel still enters the mixture


@dataclass(frozen=True)
class EdgeMap:
    """Merged edges of an image set; all arrays float32 (H, W).

    Attributes
    ----------
    mass
        Weighted mean contrast of the channels, grey at reference exposure.
    magnitude
        Mass times the share that the mixture's main component has in it; 0 where no ridge can be.
    orientation
        Direction across the edge, an axis, rad in [0, pi), 0 along x.
    ridge
        ``magnitude`` after non-maximum suppression, 0 off the ridges; no threshold, no hysteresis.
    offset
        Sub-pixel position of the ridge along ``orientation``, px, within [-0.5, 0.5].
    floor
        Standard deviation of ``mass`` from sensor noise.
    blur_px
        Blur of the most blurred channel, px.
    channels
        What was merged; empty when the map is not a merge of channels.
    """

    mass: Field
    magnitude: Field
    orientation: Field
    ridge: Field
    offset: Field
    floor: Field
    blur_px: float
    channels: tuple[ChannelStatistics, ...]


@njit(cache=True)
def _accumulate(
    contrast: Field,
    orientation: Field,
    weight: Field,
    noise: Field,
    bins: Field,
    weights: Field,
    masses: Field,
    noises: Field,
) -> None:
    """Add one channel to the sums."""
    rows, columns = contrast.shape
    count = bins.shape[2]
    per_rad = np.float32(count / np.pi)
    for y in range(rows):
        for x in range(columns):
            w = weight[y, x]
            weights[y, x] += w
            noises[y, x] += w * noise[y, x]
            m = contrast[y, x]
            if m <= 0.0:
                continue
            mass = w * m
            masses[y, x] += mass
            position = orientation[y, x] * per_rad
            low = int(position)
            part = position - np.float32(low)
            if low >= count:
                low -= count
            high = low + 1
            if high == count:
                high = 0
            bins[y, x, low] += mass * (np.float32(1.0) - part)
            bins[y, x, high] += mass * part


class ImageSetStatistics:
    """Running sums over the channels of one image set.

    Adding a channel costs that channel alone. Removing one sums the kept statistics of the others again,
    which is a small part of computing a channel, and leaves exactly what a set without it has: the weights
    span so many powers of two that a subtraction would not."""

    def __init__(self) -> None:
        self.channels: dict[str, ChannelStatistics] = {}
        self._shape: tuple[int, int] | None = None
        self._bins = np.zeros((0, 0, BINS), np.float32)
        self._weights = self._masses = self._noises = np.zeros((0, 0), np.float32)

    def add(self, name: str, channel: ChannelStatistics) -> None:
        """Add a channel under a name of its own.

        Raises
        ------
        BadInput
            The name is taken, or the image has another size than the set.
        """
        if name in self.channels:
            raise BadInput(f"Image {name} is in the set already.")
        if self._shape is not None and self._shape != channel.shape:
            raise BadInput(
                f"Image {name} has {channel.shape[1]}x{channel.shape[0]} px, "
                f"the image set {self._shape[1]}x{self._shape[0]}."
            )
        if self._shape is None:
            self._shape = channel.shape
            self._clear()
        self.channels[name] = channel
        self._sum(channel)

    def remove(self, name: str) -> None:
        """Take a channel out again, exactly.

        Raises
        ------
        BadInput
            No channel of that name.
        """
        if name not in self.channels:
            raise BadInput(f"No image {name} in the set.")
        del self.channels[name]
        self._clear()
        for channel in self.channels.values():
            self._sum(channel)

    def merge(self, candidate_ratio: float = CANDIDATE_RATIO) -> EdgeMap:
        """The merged edge map of all channels in the set.

        Raises
        ------
        BadInput
            The set is empty.
        """
        if not self.channels:
            raise BadInput("An empty image set has no edges.")
        mass = self._masses / self._weights
        floor = self._noises / self._weights
        window = np.ones((CANDIDATE_WINDOW_PX, CANDIDATE_WINDOW_PX), np.uint8)
        largest = np.asarray(cv2.dilate(mass, window), dtype=np.float32)
        channels = list(self.channels.values())
        least = np.maximum(floor, np.float32(candidate_ratio) * largest)
        places, windows, axes = orientation_windows(self._bins, self._weights, mass, least)
        near = near_crest(channels, places, axes, SLACK)
        places = places[near]
        share, axes = fit_mixtures(windows[near], axes[near])
        magnitude, orientation = np.zeros_like(mass), np.zeros_like(mass)
        magnitude.ravel()[places] = share * mass.ravel()[places]
        orientation.ravel()[places] = axes
        ridge, offset = find_crests(channels, magnitude, orientation)
        blur = max(channel.blur_px for channel in channels)
        return EdgeMap(mass, magnitude, orientation, ridge, offset, floor, blur, tuple(channels))

    def _clear(self) -> None:
        assert self._shape is not None
        self._bins = np.zeros((*self._shape, BINS), np.float32)
        self._weights, self._masses, self._noises = (np.zeros(self._shape, np.float32) for _ in range(3))

    def _sum(self, channel: ChannelStatistics) -> None:
        _accumulate(
            channel.contrast,
            channel.orientation,
            channel.weight,
            channel.noise,
            self._bins,
            self._weights,
            self._masses,
            self._noises,
        )


def merge_channels(channels: Sequence[ChannelStatistics]) -> EdgeMap:
    """The merged edge map of some channels; see `ImageSetStatistics` for a set that changes.

    Raises
    ------
    BadInput
        No channels, or of different sizes.
    """
    image_set = ImageSetStatistics()
    for number, channel in enumerate(channels, start=1):
        image_set.add(f"channel {number}", channel)
    return image_set.merge()
