"""What channels show on both sides of each edgel: intensities (C, 2, N), their noise, which are clipped."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from numerics.arrays import Field, Flags, Grey, Ints
from numerics.kernels import kernel
from numerics.logarithm import ZERO
from vision_server.channels.channel import ChannelStatistics
from vision_server.channels.depth import WHITE, Deep, deepened, is_deep, linear_image
from vision_server.channels.gaussian import contrast_kernels, noise_gain
from vision_server.channels.lighting import coarse_places
from vision_server.edges.edge_map import EdgeMap

# Beside the edge's own blur and still on the surface that ends there; then where a background goes on and a
# groove ends; of sharp images, in others as much further as they are blurred. Chosen by hand:
# `python -m benchmarks.edge_kinds`.
REACH_PX = np.array([2.0, 4.0, 6.0], np.float32)
SHARP_BLUR_PX = 1.25  # of images that are no sharper for it, as their blur is measured on them
ALONG = 3  # places beside the edge whose mean is taken
PLACES = ALONG + len(REACH_PX) - 1  # that are looked at on either side
SMOOTHED_NOISE = 0.44  # of the noise of single pixels, in the mean of three bilinear values a pixel apart
EACH_COUNT = np.arange(WHITE + 1, dtype=np.uint16)[None]
LEAST_CONTRAST = 1e-3  # that something is divided by
DARK_GREY = 4.0  # of the longest exposed frame: less is black, whatever its noise


class Sides(NamedTuple):
    """Intensities at reference exposure on both sides of N edgels in C channels.

    Attributes
    ----------
    near
        float32 (C, 2, N), behind and ahead of the edge along its normal.
    brightest
        float32 (C, 2, N), the largest on that side, near and further away.
    noise
        float32 (C, N), standard deviation of one intensity.
    known
        bool (C, N), False where a side is clipped: what is there is not known.
    axis
        float32 (N,), direction ahead, rad, 0 along x.
    dark
        Grey at reference exposure that is added before logarithms are taken.
    sharpness
        float32 (N,), how many times steeper the edge is than the slope from side to side, 1: it is that
        slope; None where that is not known.
    """

    near: Field
    brightest: Field
    noise: Field
    known: Flags
    axis: Field
    dark: float = DARK_GREY
    sharpness: Field | None = None

    def of(self, edgels: slice | Ints) -> Sides:
        """Those of some of the edgels."""
        if isinstance(edgels, slice):
            near, brightest = (np.ascontiguousarray(of[..., edgels]) for of in (self.near, self.brightest))
            noise = np.ascontiguousarray(self.noise[:, edgels])
            known = np.ascontiguousarray(self.known[:, edgels])
        else:  # many times as quick as an index
            near, brightest = self.near.take(edgels, axis=2), self.brightest.take(edgels, axis=2)
            noise, known = self.noise.take(edgels, axis=1), self.known.take(edgels, axis=1)
        axis = np.ascontiguousarray(self.axis[edgels])
        sharpness = None if self.sharpness is None else np.ascontiguousarray(self.sharpness[edgels])
        return Sides(near, brightest, noise, known, axis, self.dark, sharpness)

    def mean_of(self, number: Ints) -> Sides:
        """The means of channels that have the same number, (C,) from 0 on: known where all of them are."""
        share = (number == np.arange(number.max() + 1)[:, None]).astype(np.float32)
        known = np.array([self.known[one > 0.0].all(axis=0) for one in share])
        share /= share.sum(axis=1, keepdims=True)
        near, brightest = (np.tensordot(share, of, 1) for of in (self.near, self.brightest))
        noise = np.sqrt(share**2 @ self.noise**2)
        return self._replace(near=near, brightest=brightest, noise=noise, known=known)


class FlatGrey(NamedTuple):
    """The intensities of a channel, which are looked up pixel by pixel: `ChannelStatistics.linear`, flat.

    Attributes
    ----------
    pixels, linear_of
        uint8 or uint16, see `depth`, and the linear intensity of each of their values.
    columns
        Of a row.
    """

    pixels: Grey | Deep
    linear_of: Field
    columns: int


def _flat_grey(channel: ChannelStatistics) -> FlatGrey:
    pixels, linear_of = channel.pixels, channel.linear_of
    if is_deep(pixels):
        pixels = deepened(pixels) if pixels.dtype == np.float32 else pixels
        linear_of = linear_image(EACH_COUNT, channel.gamma, linear_of).ravel()
    return FlatGrey(pixels.ravel(), linear_of, channel.shape[1])


def evenly_weighted(channel: ChannelStatistics) -> ChannelStatistics:
    """The channel with the same say everywhere: merged so, shadows and highlights stay edges."""
    return replace(channel, light=channel.light._replace(is_even=True))


def furthest_reach(edges: EdgeMap) -> np.float32:
    """How far from the edgels their sides are looked at, px."""
    return np.float32(_reach(edges)[-1])


def _reach(edges: EdgeMap) -> Field:
    return REACH_PX * np.float32(max(edges.blur_px / SHARP_BLUR_PX, 1.0))


def sides_of(edges: EdgeMap) -> Sides:
    """Both sides of each edgel in each of the channels that were merged."""
    reach = _reach(edges)
    pixels, parts = _places(edges.points, edges.normals, reach, *edges.shape)
    count, channels = len(edges), edges.channels
    coarse = channels[0].light.level.shape
    coarse_at = coarse_places(edges.places, edges.shape[1], (coarse[0], coarse[1]))
    near, brightest = np.empty((2, len(channels), 2, count), np.float32)
    noise = np.empty((len(channels), count), np.float32)
    known = np.empty((len(channels), count), np.bool_)
    for number, channel in enumerate(channels):
        limits = channel.linear_of[channel.clipped_from], np.float32(channel.exposure)
        sides = near[number], brightest[number], known[number]
        _read(_flat_grey(channel), pixels, parts, limits, sides)
        noise[number] = _noise(channel, coarse_at)
    dark = DARK_GREY / max(channel.exposure for channel in channels)
    return Sides(near, brightest, noise, known, edges.axis, dark, _sharpness(edges, near, float(reach[0])))


def _sharpness(edges: EdgeMap, near: Field, reach: float) -> Field:
    """As in `Sides`: the contrast of a slope is sqrt(2 pi) sigma times what it climbs in a pixel."""
    sigma = np.mean([channel.sigma_px for channel in edges.channels])
    contrast = np.sqrt(2.0 * np.pi) * sigma / (2.0 * reach) / len(near)
    return _steepness(edges.mass, near, np.float32(contrast))


@kernel()
def _steepness(mass: Field, near: Field, contrast: np.float32) -> Field:
    """Contrasts (N,) over those of a slope, which are so many times the sum of steps (C, 2, N)."""
    found, least = np.zeros_like(mass), np.float32(LEAST_CONTRAST)
    for channel in range(len(near)):
        for i in range(len(mass)):
            found[i] += abs(near[channel, 1, i] - near[channel, 0, i])
    for i in range(len(mass)):
        found[i] = mass[i] / max(contrast * found[i], least) if mass[i] > ZERO else np.float32(np.inf)
    return found


@kernel()
def _places(
    points: Field, normals: Field, reach: Field, rows: int, columns: int
) -> tuple[NDArray[np.int32], Field]:
    """Where intensities are read: of each of N edgels PLACES behind and as many ahead.

    Beside the edge three along it, a pixel apart, and one at each further reach; outside, the image is as at
    its border.

    Returns
    -------
    Flat indices of the pixels above and left of them, int32 (N, 2 * PLACES), and which share of the way they
    are to the next column and to the next row, float32 (N, 2 * PLACES, 2).
    """
    pixels = np.empty((len(points), 2 * PLACES), np.int32)
    parts = np.empty((len(points), 2 * PLACES, 2), np.float32)
    away, along = np.empty(2 * PLACES, np.float32), np.empty(2 * PLACES, np.float32)
    for k in range(2 * PLACES):
        number = k % PLACES
        away[k] = reach[max(number - ALONG + 1, 0)] * np.float32(1 if k >= PLACES else -1)
        along[k] = np.float32((0, 1, -1, 0, 0)[number])
    right, bottom = np.float32(columns - 1), np.float32(rows - 1)
    last_column, last_row, width = np.int32(columns - 2), np.int32(rows - 2), np.int32(columns)
    for i in range(len(points)):
        at_x, at_y, nx, ny = points[i, 0], points[i, 1], normals[i, 0], normals[i, 1]
        for k in range(2 * PLACES):
            x = min(max(at_x + away[k] * nx - along[k] * ny, ZERO), right)
            y = min(max(at_y + away[k] * ny + along[k] * nx, ZERO), bottom)
            u, v = min(np.int32(x), last_column), min(np.int32(y), last_row)
            pixels[i, k] = v * width + u
            parts[i, k, 0], parts[i, k, 1] = x - np.float32(u), y - np.float32(v)
    return pixels, parts


@kernel()
def _read(
    grey: FlatGrey,
    pixels: NDArray[np.int32],
    parts: Field,
    limits: tuple[np.float32, np.float32],
    sides: tuple[Field, Field, Flags],
) -> None:
    """What one channel shows behind and ahead of each of N edgels.

    Beside the edge it is the mean of the three places along it; all are bilinear between four pixels.

    Parameters
    ----------
    grey, pixels, parts
        Of the channel, and where they are read.
    limits
        From where the channel is clipped; its exposure.
    sides
        Outputs: near and brightest (2, N), and known (N,) of `Sides`.
    """
    image, linear_of, columns = grey
    clipped, exposure = limits
    near, brightest, known = sides
    third = np.float32(1.0 / 3.0)
    next_column, next_row = np.uint64(1), np.uint64(columns)  # without a sign: none counts from the end
    for i in range(len(pixels)):
        known[i] = True
        for side in range(2):
            mean, largest = ZERO, ZERO
            for number in range(PLACES):
                k = side * PLACES + number
                at, right, down = np.uint64(pixels[i, k]), parts[i, k, 0], parts[i, k, 1]
                below = at + next_row
                a, b = linear_of[image[at]], linear_of[image[at + next_column]]
                c, d = linear_of[image[below]], linear_of[image[below + next_column]]
                a += right * (b - a)
                value = a + down * (c + right * (d - c) - a)
                if number < ALONG:
                    mean += value
                else:
                    largest = max(largest, value)
            mean *= third
            known[i] &= mean < clipped
            near[side, i] = mean / exposure
            brightest[side, i] = max(mean, largest) / exposure


def _noise(channel: ChannelStatistics, at: NDArray[np.int32]) -> Field:
    """Standard deviation of a smoothed intensity: that of the contrast there, brought back to one place.

    ``at`` are flat indices into the 2 x 2 px for which the noise is kept.
    """
    share = np.float32(SMOOTHED_NOISE / noise_gain(contrast_kernels(channel.sigma_px, 1.0)))
    least = np.float32(channel.rounding_sd / channel.exposure)
    return channel.light._replace(noise_of=np.maximum(channel.light.noise_of * share, least)).noise_at(at)
