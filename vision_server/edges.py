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
from numpy.typing import NDArray

from bridge.errors import BadInput
from vision_server.canny import suppress_non_maxima
from vision_server.channel import ChannelStatistics, Field

BINS = 16  # of axial orientation over pi
EM_ITERATIONS = 4
MAIN_SD_RAD = 0.25  # spread of the orientation along a true edge inside the window
BACKGROUND_SD_RAD = 1.0  # shadow edges and noise: nearly anything
CANDIDATE_RATIO = 0.6  # a pixel under this share of the largest mass in 5 x 5 cannot be a ridge
CANDIDATE_WINDOW_PX = 5
SLACK = 0.97  # a pixel this close to a ridge on the first, mean orientation still enters the mixture
TABLE_STEPS = 1024  # of the Gaussian tables, over a difference of 0 to pi/2


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
    """

    mass: Field
    magnitude: Field
    orientation: Field
    ridge: Field
    offset: Field
    floor: Field
    blur_px: float


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


@njit(cache=True)
def _across(field: Field, y: int, x: int, cosine: float, sine: float) -> tuple[float, float]:
    """The field one step ahead and behind along a direction, interpolated on the ring of neighbours."""
    u = 1 if cosine > 0.0 else -1
    v = 1 if sine > 0.0 else -1
    along_x, along_y = abs(cosine), abs(sine)
    if along_x >= along_y:
        t = along_y / along_x
        ahead = (1.0 - t) * field[y, x + u] + t * field[y + v, x + u]
        behind = (1.0 - t) * field[y, x - u] + t * field[y - v, x - u]
    else:
        t = along_x / along_y
        ahead = (1.0 - t) * field[y + v, x] + t * field[y + v, x + u]
        behind = (1.0 - t) * field[y - v, x] + t * field[y - v, x - u]
    return ahead, behind


@njit(cache=True)
def _mixture(
    bins: Field,
    weights: Field,
    mass: Field,
    largest: Field,
    floor: Field,
    ratio: float,
    main_table: Field,
    background_table: Field,
    iterations: int,
    magnitude: Field,
    orientation: Field,
) -> None:
    """EM on the histogram of the 3 x 3 window of each pixel that may be on a ridge."""
    rows, columns, count = bins.shape
    steps = len(main_table) - 1
    per_rad = np.float32(steps / (0.5 * np.pi))
    pi = np.float32(np.pi)
    window = np.zeros(count, np.float32)
    cosine, sine = np.empty(count, np.float32), np.empty(count, np.float32)
    centre, background = np.empty(count, np.float32), np.empty(count, np.float32)
    held = np.empty(count, np.int64)
    for k in range(count):
        centre[k] = k * np.pi / count
        cosine[k], sine[k] = np.cos(2.0 * k * np.pi / count), np.sin(2.0 * k * np.pi / count)
    for y in range(1, rows - 1):
        for x in range(1, columns - 1):
            here = mass[y, x]
            if here <= floor[y, x] or here < ratio * largest[y, x]:
                continue
            if not (
                (here >= mass[y, x - 1] and here >= mass[y, x + 1])
                or (here >= mass[y - 1, x] and here >= mass[y + 1, x])
                or (here >= mass[y - 1, x - 1] and here >= mass[y + 1, x + 1])
                or (here >= mass[y - 1, x + 1] and here >= mass[y + 1, x - 1])
            ):
                continue
            window[:] = 0.0
            for v in range(y - 1, y + 2):
                for u in range(x - 1, x + 2):
                    if mass[v, u] > 0.0:
                        scale = np.float32(1.0) / weights[v, u]
                        for k in range(count):
                            window[k] += bins[v, u, k] * scale
            total, c, s = np.float32(0.0), np.float32(0.0), np.float32(0.0)
            filled = 0
            for k in range(count):
                if window[k] > 0.0:
                    total += window[k]
                    c += window[k] * cosine[k]
                    s += window[k] * sine[k]
                    held[filled] = k
                    filled += 1
            mean = np.float32(0.5) * np.arctan2(s, c)
            ahead, behind = _across(mass, y, x, np.cos(mean), np.sin(mean))
            if here < SLACK * ahead or here < SLACK * behind:
                continue
            for j in range(filled):
                d = abs(centre[held[j]] - mean)
                if d > pi:
                    d -= pi
                background[j] = background_table[int(min(d, pi - d) * per_rad)]
            share = np.float32(0.5)
            for _ in range(iterations):
                main_mass, c, s = np.float32(0.0), np.float32(0.0), np.float32(0.0)
                for j in range(filled):
                    k = held[j]
                    d = abs(centre[k] - mean)
                    if d > pi:
                        d -= pi
                    p = share * main_table[int(min(d, pi - d) * per_rad)]
                    r = p / (p + (np.float32(1.0) - share) * background[j]) * window[k]
                    main_mass += r
                    c += r * cosine[k]
                    s += r * sine[k]
                if main_mass <= 0.0:
                    break
                mean = np.float32(0.5) * np.arctan2(s, c)
                share = min(main_mass / total, np.float32(0.999))
            magnitude[y, x] = share * here
            axis = mean + pi if mean < 0.0 else mean
            orientation[y, x] = axis if axis < pi else np.float32(0.0)


def gaussian_table(sd_rad: float) -> NDArray[np.float32]:
    """Density of a normal on the axial circle (its range is pi), at differences 0 .. pi/2."""
    difference = np.linspace(0.0, 0.5 * np.pi, TABLE_STEPS + 1)
    turns = np.arange(-2, 3)[:, None] * np.pi
    density = np.exp(-0.5 * ((difference + turns) / sd_rad) ** 2).sum(axis=0) / (
        np.sqrt(2.0 * np.pi) * sd_rad
    )
    return np.asarray(density, dtype=np.float32)


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
        magnitude, orientation = np.zeros_like(mass), np.zeros_like(mass)
        _mixture(
            self._bins,
            self._weights,
            mass,
            largest,
            floor,
            candidate_ratio,
            gaussian_table(MAIN_SD_RAD),
            gaussian_table(BACKGROUND_SD_RAD),
            EM_ITERATIONS,
            magnitude,
            orientation,
        )
        ridge, offset = suppress_non_maxima(magnitude, orientation, mass)
        blur = max(channel.blur_px for channel in self.channels.values())
        return EdgeMap(mass, magnitude, orientation, ridge, offset, floor, blur)

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
