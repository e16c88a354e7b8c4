"""What the channels show on either side of each edgel: intensities, their noise, and which are clipped."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from numerics.kernels import kernel
from vision_server.channels.channel import ChannelStatistics
from vision_server.channels.depth import Field
from vision_server.channels.gaussian import contrast_kernels, noise_gain
from vision_server.channels.lighting import LENS_BLUR_PX
from vision_server.channels.noise import SATURATED_GREY
from vision_server.edges.edge_map import EdgeMap

# Beside the edge's own blur and still on the surface that ends there; then where a background goes on and a
# groove ends; of sharp images, in others as much further as they are blurred. Chosen by hand:
# `python -m benchmarks.edge_kinds`.
REACH_PX = np.array([2.0, 4.0, 6.0], np.float32)
SMOOTHED_NOISE = 0.44  # of the noise of single pixels, in the mean of three bilinear values a pixel apart
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
    dark
        Grey at reference exposure that is added before logarithms are taken.
    """

    near: Field
    brightest: Field
    noise: Field
    known: NDArray[np.bool_]
    dark: float = DARK_GREY


def evenly_weighted(channel: ChannelStatistics) -> ChannelStatistics:
    """The channel with the same say everywhere: merged so, shadows and highlights stay edges."""
    even = np.ones_like(channel.light.weight)
    return replace(channel, light=channel.light._replace(weight=even))


def sides_of(edges: EdgeMap) -> Sides:
    """Both sides of each edgel in each of the channels that were merged."""
    rows, columns = np.divmod(edges.places, np.int32(edges.shape[1]))
    reach = REACH_PX * np.float32(max(edges.blur_px / LENS_BLUR_PX, 1.0))
    near, brightest, noise, known = [], [], [], []
    for channel in edges.channels:
        beside, lit = _read(channel.linear, edges.points, edges.normals, reach)
        known.append(beside.max(axis=0) < channel.linear_of[SATURATED_GREY])
        near.append(beside / np.float32(channel.exposure))
        brightest.append(lit / np.float32(channel.exposure))
        noise.append(_noise(channel, rows, columns))
    dark = DARK_GREY / max(channel.exposure for channel in edges.channels)
    return Sides(np.stack(near), np.stack(brightest), np.stack(noise), np.stack(known), dark)


@kernel(inline="always")
def _bilinear(linear: Field, x: np.float32, y: np.float32) -> np.float32:
    """Intensity between pixels; outside, the image is as at its border."""
    rows, columns = linear.shape
    x = min(max(x, np.float32(0.0)), np.float32(columns - 1))
    y = min(max(y, np.float32(0.0)), np.float32(rows - 1))
    u, v = min(int(x), columns - 2), min(int(y), rows - 2)
    right, down = x - np.float32(u), y - np.float32(v)
    a, b, c, d = linear[v, u], linear[v, u + 1], linear[v + 1, u], linear[v + 1, u + 1]
    above, below = a + right * (b - a), c + right * (d - c)
    value: np.float32 = above + down * (below - above)
    return value


@kernel(nogil=True, error_model="numpy")
def _read(linear: Field, points: Field, normals: Field, reach: Field) -> tuple[Field, Field]:
    """Intensities (2, N) behind and ahead of each point, and the largest up to further away.

    Beside the edge each is the mean of three places along it, a pixel apart.
    """
    near, brightest = np.empty((2, len(points)), np.float32), np.empty((2, len(points)), np.float32)
    third = np.float32(1.0 / 3.0)
    for i in range(len(points)):
        nx, ny = normals[i, 0], normals[i, 1]
        for side in range(2):
            sign = np.float32(2 * side - 1)
            x, y = points[i, 0] + sign * reach[0] * nx, points[i, 1] + sign * reach[0] * ny
            value = _bilinear(linear, x, y) + _bilinear(linear, x - ny, y + nx)
            value = (value + _bilinear(linear, x + ny, y - nx)) * third
            near[side, i] = value
            for k in range(1, len(reach)):
                x, y = points[i, 0] + sign * reach[k] * nx, points[i, 1] + sign * reach[k] * ny
                value = max(value, _bilinear(linear, x, y))
            brightest[side, i] = value
    return near, brightest


def _noise(channel: ChannelStatistics, rows: NDArray[np.int32], columns: NDArray[np.int32]) -> Field:
    """Standard deviation of a smoothed intensity: that of the contrast there, brought back to one place."""
    coarse = channel.light.noise
    v, u = np.minimum(rows >> 1, coarse.shape[0] - 1), np.minimum(columns >> 1, coarse.shape[1] - 1)
    gain = noise_gain(contrast_kernels(channel.sigma_px, 1.0))
    least = channel.rounding_sd / channel.exposure
    return np.asarray(np.maximum(coarse[v, u] * (SMOOTHED_NOISE / gain), least), np.float32)
