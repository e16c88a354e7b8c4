"""Merging channels into one edge map: a mixture of orientations at each pixel, fitted by EM.

The state kept per pixel is a histogram of axial orientation (weight times contrast, linear split between
neighbouring bins) with the sums that place a ridge between pixels. It is additive over channels, so the merge
does not depend on how many there are, and it is kept only where some channel has a gradient.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bridge.errors import BadInput
from numerics.kernels import kernel
from numerics.two_cores import both
from vision_server.channels.channel import ChannelStatistics, Field
from vision_server.edges.edge_map import EdgeMap
from vision_server.edges.mixture import BINS
from vision_server.edges.ridges import FLANK_X, FLANK_Y, FLANKS, MASS, find_crests

WORTH_TWO_CORES = 15000  # pixels: summing fewer is done before the other core has begun


@kernel(nogil=True, error_model="numpy")
def _number(places: NDArray[np.int32], index: NDArray[np.int32], count: int) -> int:
    """Give a number to each of the pixels that has none; how many there are then."""
    flat = index.ravel()
    for place in places:
        if flat[place] < 0:
            flat[place] = count
            count += 1
    return count


@kernel(nogil=True, error_model="numpy")
def _accumulate(
    places: NDArray[np.int32],
    magnitude: Field,
    axis: Field,
    flank_sum: Field,
    flank_x: Field,
    flank_y: Field,
    coarse_weight: Field,
    coarse_noise: Field,
    known: int,
    begin: int,
    end: int,
    weights: Field,
    noises: Field,
    index: NDArray[np.int32],
    histograms: Field,
    sums: Field,
) -> None:
    """Add one channel's rows ``begin`` (even) up to ``end``; pixels numbered from ``known`` on are new."""
    rows, columns = index.shape
    last_row, last_column = coarse_weight.shape[0] - 1, coarse_weight.shape[1] - 1
    for v in range(begin >> 1, last_row + 1 if end == rows else end >> 1):
        for u in range(weights.shape[1]):
            weights[v, u] += coarse_weight[v, u]
            noises[v, u] += coarse_weight[v, u] * coarse_noise[v, u]
    per_rad = np.float32(BINS / np.pi)
    one = np.float32(1.0)
    y = begin
    for i in range(np.searchsorted(places, begin * columns), np.searchsorted(places, end * columns)):
        place = places[i]
        while place >= (y + 1) * columns:
            y += 1
        x = place - y * columns
        at = index[y, x]
        if at >= known:
            for k in range(BINS):
                histograms[at, k] = np.float32(0.0)
            for k in range(sums.shape[1]):
                sums[at, k] = np.float32(0.0)
        w = coarse_weight[min(y >> 1, last_row), min(x >> 1, last_column)]
        mass = w * magnitude[i]
        position = axis[i] * per_rad
        low = int(position)
        part = position - np.float32(low)
        histograms[at, low % BINS] += mass * (one - part)
        histograms[at, (low + 1) % BINS] += mass * part
        sums[at, MASS] += mass
        sums[at, FLANKS] += w * flank_sum[i]
        sums[at, FLANK_X] += w * flank_x[i]
        sums[at, FLANK_Y] += w * flank_y[i]


class ImageSetStatistics:
    """Running sums over the channels of one image set.

    Adding a channel costs that channel alone, when the set is merged. Removing one sums the kept statistics
    of the others again, which is a small part of computing a channel, and leaves exactly what a set without
    it has: the weights span so many powers of two that a subtraction would not."""

    def __init__(self) -> None:
        self.channels: dict[str, ChannelStatistics] = {}
        self._summed = 0  # the first so many of the channels are in the sums
        self._count = 0
        self._index = np.zeros((0, 0), np.int32)
        self._histograms, self._sums = np.zeros((0, BINS), np.float32), np.zeros((0, 4), np.float32)
        self._weights = self._noises = np.zeros((0, 0), np.float32)

    def add(self, name: str, channel: ChannelStatistics) -> None:
        """Add a channel under a name of its own.

        Raises
        ------
        BadInput
            The name is taken, or the image has another size than the set.
        """
        if name in self.channels:
            raise BadInput(f"Image {name} is in the set already.")
        if not self.channels:
            self._clear(channel)
        if self._index.shape != channel.shape:
            raise BadInput(
                f"Image {name} has {channel.shape[1]}x{channel.shape[0]} px, "
                f"the image set {self._index.shape[1]}x{self._index.shape[0]}."
            )
        self.channels[name] = channel

    def remove(self, name: str) -> None:
        """Take a channel out again, exactly.

        Raises
        ------
        BadInput
            No channel of that name.
        """
        if name not in self.channels:
            raise BadInput(f"No image {name} in the set.")
        self._clear(self.channels.pop(name))

    def merge(self) -> EdgeMap:
        """The merged edge map of all channels in the set.

        Raises
        ------
        BadInput
            The set is empty.
        """
        if not self.channels:
            raise BadInput("An empty image set has no edges.")
        self._sum(list(self.channels.values())[self._summed :])
        edgels = find_crests(
            self._index,
            self._histograms[: self._count],
            self._sums[: self._count],
            self._weights,
            self._noises,
        )
        channels = tuple(self.channels.values())
        return EdgeMap(self._index.shape, *edgels, max(channel.blur_px for channel in channels), channels)

    def _clear(self, like: ChannelStatistics) -> None:
        self._summed = self._count = 0
        if self._index.shape != like.shape:
            self._index = np.empty(like.shape, np.int32)
        self._index.fill(-1)
        self._weights, self._noises = np.zeros((2, *like.coarse_weight.shape), np.float32)

    def _sum(self, channels: Sequence[ChannelStatistics]) -> None:
        known = []
        for channel in channels:
            known.append(self._count)
            self._count = _number(channel.gradient.places, self._index, self._count)
        self._reserve(self._count, known[0] if known else self._count)

        def add(begin: int, end: int) -> None:
            for channel, known_then in zip(channels, known, strict=True):
                pixels = channel.gradient
                _accumulate(
                    pixels.places,
                    pixels.magnitude,
                    pixels.axis,
                    pixels.flank_sum,
                    pixels.flank_x,
                    pixels.flank_y,
                    channel.coarse_weight,
                    channel.coarse_noise,
                    known_then,
                    begin,
                    end,
                    self._weights,
                    self._noises,
                    self._index,
                    self._histograms,
                    self._sums,
                )

        rows = len(self._index)
        if sum(len(channel.gradient) for channel in channels) < WORTH_TWO_CORES:
            add(0, rows)
        else:
            both(lambda: add(rows // 4 * 2, rows), lambda: add(0, rows // 4 * 2))
        self._summed += len(channels)

    def _reserve(self, wanted: int, used: int) -> None:
        if wanted <= len(self._sums):
            return
        room = 2 * wanted  # what is not used is never touched, and costs nothing
        self._histograms = _extended(self._histograms, used, room)
        self._sums = _extended(self._sums, used, room)


def _extended(array: Field, used: int, room: int) -> Field:
    """A longer array with the same beginning."""
    longer = np.empty((room, *array.shape[1:]), array.dtype)
    longer[:used] = array[:used]
    return longer


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
