"""Merging the channels of a set into one edge map: its definition at one pixel, then the whole image.

1. Each channel counts by how lit it is there (`channels.lighting`). That ranks true edges above shadow edges,
   and does nearly all of the work.
2. The orientations of all channels in the 3 x 3 px around a pixel, so weighted, are a mixture of the true
   edge and of the rest, fitted by EM (`edges.mixture`). Its main component says which way the edge runs.
3. The merged magnitude is the weighted mean contrast times the share of the main component; where that is a
   maximum across the edge, there is an edgel (`edges.ridges`).

The whole image keeps, per pixel, a histogram of axial orientation (weight times contrast, split linearly
between neighbouring bins) and the sums that place a ridge between pixels. These add up over channels, so the
merge does not depend on how many there are.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bridge.errors import BadInput
from numerics.arrays import Field
from numerics.kernels import kernel
from numerics.two_cores import both
from vision_server.channels.channel import ChannelStatistics
from vision_server.channels.gradient_pixels import GradientPixels
from vision_server.edges.edge_map import EdgeMap
from vision_server.edges.mixture import BINS, fit_mixture
from vision_server.edges.ridges import FLANK_X, FLANK_Y, FLANKS, FLOOR_RATIO, MASS, SetState, find_ridges

WORTH_TWO_CORES = 15000  # pixels: summing fewer is done before the other core has begun


def merged_at(channels: Sequence[ChannelStatistics], y: int, x: int) -> tuple[float, float, float]:
    """The merge at one pixel where some channel has a gradient: the definition, sample by sample.

    Returns
    -------
    Strength and mass (grey at reference exposure) and axis (rad in [0, pi)), as in `EdgeMap`.
    """
    window = np.s_[y - 1 : y + 2, x - 1 : x + 2]
    lit = [channel.weight[window].astype(np.float64) for channel in channels]
    contrast = np.stack(
        [weight * channel.contrast[window] for weight, channel in zip(lit, channels, strict=True)]
    ) / np.sum(lit, axis=0)
    orientation = np.stack([channel.orientation[window].astype(np.float64) for channel in channels])
    share, axis = fit_mixture(orientation[contrast > 0], contrast[contrast > 0])
    mass = float(contrast[:, 1, 1].sum())
    return share * mass, mass, axis


@kernel()
def _number(places: NDArray[np.int32], numbers: NDArray[np.int32], count: int) -> int:
    """Give a number to each of the pixels that has none; how many there are then."""
    flat = numbers.ravel()
    for place in places:
        if flat[place] < 0:
            flat[place] = count
            count += 1
    return count


@kernel()
def _accumulate(
    pixels: GradientPixels, weight: Field, noise: Field, state: SetState, begin: int, end: int
) -> None:
    """Add one channel's rows ``begin`` (even) up to ``end`` to the state.

    ``weight``, ``noise``: of their 2 x 2 px, see `Lighting`; an even weight is (1, 1).
    """
    columns = state.numbers.shape[1]
    first, last_row, last_column = begin >> 1, weight.shape[0] - 1, weight.shape[1] - 1
    for v in range(len(noise)):
        weights, noises, of_noise = state.weights[first + v], state.noises[first + v], noise[v]
        if weight.size == 1:
            for u in range(len(of_noise)):
                weights[u] += weight[0, 0]
                noises[u] += weight[0, 0] * of_noise[u]
        else:
            of_weight = weight[v]
            for u in range(len(of_noise)):
                weights[u] += of_weight[u]
                noises[u] += of_weight[u] * of_noise[u]
    per_rad = np.float32(BINS / np.pi)
    y = begin
    places = pixels.places
    for i in range(np.searchsorted(places, begin * columns), np.searchsorted(places, end * columns)):
        while places[i] >= (y + 1) * columns:
            y += 1
        x = places[i] - y * columns
        w = weight[min((y >> 1) - first, last_row), min(x >> 1, last_column)]
        mass = w * pixels.magnitude[i]
        position = pixels.axis[i] * per_rad
        low = int(position)
        part = position - np.float32(low)
        histogram, sums = state.histograms[state.numbers[y, x]], state.sums[state.numbers[y, x]]
        histogram[low % BINS] += mass * (np.float32(1.0) - part)
        histogram[(low + 1) % BINS] += mass * part
        sums[MASS] += mass
        sums[FLANKS] += w * pixels.flank_sum[i]
        sums[FLANK_X] += w * pixels.flank_x[i]
        sums[FLANK_Y] += w * pixels.flank_y[i]


class ImageSetStatistics:
    """Running sums over the channels of one image set.

    Adding a channel costs that channel alone, when the set is merged. Removing one sums the kept statistics
    of the others again, which is a small part of computing a channel, and leaves exactly what a set without
    it has: the weights span so many powers of two that a subtraction would not."""

    def __init__(self) -> None:
        self.channels: dict[str, ChannelStatistics] = {}
        self._summed = 0  # the first so many of the channels are in the state
        self._count = 0  # pixels of the state that are in use
        self._state = _empty_state((0, 0), (0, 0))

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
        if self._state.numbers.shape != channel.shape:
            raise BadInput(
                f"Image {name} has {channel.shape[1]}x{channel.shape[0]} px, "
                f"the image set {self._state.numbers.shape[1]}x{self._state.numbers.shape[0]}."
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

    def merge(self, floor_ratio: float = FLOOR_RATIO) -> EdgeMap:
        """The merged edge map of all channels in the set; ``floor_ratio`` as in `find_ridges`.

        Raises
        ------
        BadInput
            The set is empty.
        """
        if not self.channels:
            raise BadInput("An empty image set has no edges.")
        self._sum(list(self.channels.values())[self._summed :])
        count = self._count
        state = self._state._replace(histograms=self._state.histograms[:count], sums=self._state.sums[:count])
        places, (strength, mass, axis, offset, floor) = find_ridges(state, floor_ratio)
        channels = tuple(self.channels.values())
        blur_px = max(channel.blur_px for channel in channels)
        shape = (state.numbers.shape[0], state.numbers.shape[1])
        return EdgeMap(shape, places, strength, mass, axis, offset, floor, blur_px, channels)

    def _clear(self, like: ChannelStatistics) -> None:
        self._summed = self._count = 0
        self._state = _empty_state(like.shape, like.light.level.shape)

    def _sum(self, channels: Sequence[ChannelStatistics]) -> None:
        for channel in channels:
            self._count = _number(channel.gradient.places, self._state.numbers, self._count)
        self._reserve(self._count)
        state, rows, coarse_rows = self._state, len(self._state.numbers), len(self._state.weights)

        def add(begin: int, end: int) -> None:
            for channel in channels:
                if len(channel.gradient.places):  # a white image would have all the say, and nothing to say
                    light, coarse = channel.light, (begin // 2, coarse_rows if end == rows else end // 2)
                    weight, noise = light.weight_of_rows(*coarse), light.noise_of_rows(*coarse)
                    _accumulate(channel.gradient, weight, noise, state, begin, end)

        if sum(len(channel.gradient.places) for channel in channels) < WORTH_TWO_CORES:
            add(0, rows)
        else:
            both(lambda: add(rows // 4 * 2, rows), lambda: add(0, rows // 4 * 2))
        self._summed += len(channels)

    def _reserve(self, wanted: int) -> None:
        """Room for so many pixels, and a quarter more; what is new is zero."""
        known = len(self._state.sums)
        if wanted > known:
            longer = []
            for array in (self._state.histograms, self._state.sums):
                longer.append(np.zeros((wanted + wanted // 4, array.shape[1]), np.float32))
                longer[-1][:known] = array
            self._state = self._state._replace(histograms=longer[0], sums=longer[1])


def _empty_state(shape: tuple[int, int], coarse_shape: tuple[int, ...]) -> SetState:
    """The state of no channels."""
    weights, noises = np.zeros((2, *coarse_shape), np.float32)
    histograms, sums = np.zeros((0, BINS), np.float32), np.zeros((0, 4), np.float32)
    return SetState(np.full(shape, -1, np.int32), histograms, sums, weights, noises)


def merge_channels(channels: Sequence[ChannelStatistics], floor_ratio: float = FLOOR_RATIO) -> EdgeMap:
    """The merged edge map of some channels; see `ImageSetStatistics` for a set that changes.

    Parameters
    ----------
    channels
        Of one set.
    floor_ratio
        See `find_ridges`.

    Raises
    ------
    BadInput
        No channels, or of different sizes.
    """
    image_set = ImageSetStatistics()
    for number, channel in enumerate(channels, start=1):
        image_set.add(f"channel {number}", channel)
    return image_set.merge(floor_ratio)
