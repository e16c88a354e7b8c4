"""Sub-pixel edge points: maxima of the Gaussian derivative along the normals of model lines (`search`).

In go samples of lines with their normals, out come places along these, px, with the noise of each: the one-
dimensional search of RAPiD (Harris and Stennett 1990), with Canny's derivative of a Gaussian as its detector.
Tiles of gradients are made where it looks.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from numerics.arrays import Field, Floats, Grey, Ints
from numerics.kernels import kernel
from vision_server.channels.gradients import (
    SCALES_PX,
    SIDE_PX,
    TILE_BITS,
    TILE_PX,
    Frame,
    GradientChannel,
    Normals,
    Tiles,
    noise_at,
)

BITS, INSIDE = np.uint32(TILE_BITS), np.uint32(TILE_PX - 1)  # of a row or column: its tile, its place in that

# Of the reach, that the kernel looks at: the next step, bilinear, around the maximum; and the flanks of that.
PREPARED_BEYOND_PX = 12
PEAKS = 3  # kept for each sample and channel, strongest first: the edge's own and one to either side
MIN_SNR = 4.0  # chosen by hand, of the derivative against its noise: noise alone passes 6 times in 100 000
MIN_ALIGNED = 0.85  # chosen by hand: least |cos| of the gradient with the line's normal, about 30 degrees
CLIPPED_SD_PX = 0.5  # saturation moves an edge towards its dark side by up to the blur
LEAST_FLANK_SHARE = 0.02  # of the peak, that its neighbours count with at least: logarithms stay finite
MOST_SHIFT_PX = 1.0  # of a peak from where the pixel-wide steps see it
# Standard deviation of the first and the second derivative of white noise of sd 1 under a Gaussian of sigma,
# times sigma^2 and sigma^3.
DERIVATIVE_NOISE, CURVATURE_NOISE = 1.0 / math.sqrt(8.0 * math.pi), math.sqrt(3.0 / (16.0 * math.pi))


class Channel(NamedTuple):
    """The tiles of one channel at one scale, see `Tiles`, and that scale, px."""

    number: NDArray[np.int32]
    gradient: Field
    near_clipped: Grey
    sigma: float


@kernel()
def _gradient(channel: Channel, x: float, y: float) -> tuple[float, float]:
    """Derivatives along x and y between pixels, bilinear; the caller keeps 0 <= x < W - 1, 0 <= y < H - 1.

    Unsigned places spare the look for negative ones.
    """
    column, row = np.uint32(x), np.uint32(y)
    a, b = x - np.float64(column), y - np.float64(row)
    c, d = (1.0 - a) * (1.0 - b), a * (1.0 - b)
    e, f = (1.0 - a) * b, a * b
    tile = channel.gradient[np.uint32(channel.number[row >> BITS, column >> BITS])]
    here = (row & INSIDE) * np.uint32(SIDE_PX) + (column & INSIDE)
    right, below, last = here + np.uint32(1), here + np.uint32(SIDE_PX), here + np.uint32(SIDE_PX + 1)
    along_x = c * tile[here, 0] + d * tile[right, 0] + e * tile[below, 0] + f * tile[last, 0]
    along_y = c * tile[here, 1] + d * tile[right, 1] + e * tile[below, 1] + f * tile[last, 1]
    return along_x, along_y


@kernel()
def derivative_at(channel: Channel, x: float, y: float, nx: float, ny: float) -> float:
    """Derivative along (nx, ny) at a place as in `_gradient`."""
    along_x, along_y = _gradient(channel, x, y)
    return float(nx * along_x + ny * along_y)


@kernel()
def _parabola(before: float, here: float, after: float) -> tuple[float, float]:
    """Place of the maximum of a Gaussian through three values one px apart, and minus its log curvature."""
    least = LEAST_FLANK_SHARE * here
    before, here, after = math.log(max(before, least)), math.log(here), math.log(max(after, least))
    bend = 2.0 * here - before - after
    return (0.5 * (after - before) / bend if bend > 0.0 else np.inf), bend


class EdgePoints(NamedTuple):
    """Edge points on the normals of N samples in C channels, PEAKS at most of each, (C, N, PEAKS).

    Attributes
    ----------
    offset : px along the normal, NaN where there is none.
    snr : of the derivative there against its noise, 0 where there is none.
    sd : standard deviation of ``offset``, px.
    strength : the signed derivative, grey per px.
    """

    offset: Floats
    snr: Floats
    sd: Floats
    strength: Floats


def search(channels: Sequence[GradientChannel], scale: Ints, normals: Normals) -> EdgePoints:
    """Edge points in all channels, see `find_edge_points`.

    Parameters
    ----------
    scale
        (C, N), index into SCALES_PX for each channel and sample; C-contiguous, as kernels expect.
    """
    shape = (len(channels), len(normals.image), PEAKS)
    out = EdgePoints(*(np.empty(shape) for _ in EdgePoints._fields))
    if len(normals.image) > 0:
        sigmas = np.array(SCALES_PX)
        for c, channel in enumerate(channels):
            channel.prepare(scale[c], normals, PREPARED_BEYOND_PX)
            find_edge_points(channel.frame, channel.tiles, scale[c], sigmas, normals, c, out)
    return out


@kernel()
def find_edge_points(
    frame: Frame,
    tiles: Tiles,
    scale: Ints,
    sigmas: Floats,
    normals: Normals,
    c: int,
    out: EdgePoints,
) -> None:
    """Look for edges on the normals of samples, in one channel, the c-th of ``out``.

    The derivative g . n along the normal, where g is the smoothed gradient, is looked at in steps of a pixel.
    Each maximum of its magnitude is placed by a parabola through the logarithms of three values one px apart
    (exact for a Gaussian-shaped response), first on the steps and then around the place so found, which frees
    it from their phase. Its standard deviation follows from the noise of the second derivative divided by the
    curvature. The strongest maxima are kept.

    Parameters
    ----------
    frame, tiles
        Of the channel; the tiles that the normals run into are there, see `GradientChannel.prepare`.
    scale, sigmas
        (N,), index into (S,) px for each sample.
    c
        Which channel it is.
    """
    rows, columns = frame.shape
    out.offset[c], out.snr[c], out.sd[c], out.strength[c] = np.nan, 0.0, 0.0, 0.0
    profile = np.empty(2 * int(np.ceil(normals.reach_px.max())) + 3)
    for i in range(len(scale)):
        s = scale[i]
        channel = Channel(tiles.number[s], tiles.gradient[s], tiles.near_clipped[s], sigmas[s])
        image, normal = normals.image[i], normals.normal[i]
        nx, ny = normal[0], normal[1]
        half = int(np.ceil(normals.reach_px[i])) + 1
        for k in range(2 * half + 1):
            u = float(k - half)
            x, y = image[0] + u * nx, image[1] + u * ny
            inside = x >= 0.0 and y >= 0.0 and x < columns - 1 and y < rows - 1
            profile[k] = derivative_at(channel, x, y, nx, ny) if inside else 0.0
        found = 0
        for k in range(1, 2 * half):
            here = abs(profile[k])
            if here <= abs(profile[k - 1]) or here < abs(profile[k + 1]):
                continue
            place, snr, sd, strength = _refined_maximum(
                frame, channel, image, normal, float(k - half), profile[k - 1 : k + 2]
            )
            if snr == 0.0 or abs(place) > normals.reach_px[i]:
                continue
            slot = found
            if found == PEAKS:
                slot = int(np.argmin(out.snr[c, i]))
                if out.snr[c, i, slot] >= snr:
                    continue
            else:
                found += 1
            out.offset[c, i, slot], out.snr[c, i, slot] = place, snr
            out.sd[c, i, slot], out.strength[c, i, slot] = sd, strength


@kernel()
def _refined_maximum(
    frame: Frame, channel: Channel, image: Floats, normal: Floats, u: float, values: Floats
) -> tuple[float, float, float, float]:
    """Place, SNR, standard deviation and strength of a maximum ``u`` px from a sample; SNR 0 for none.

    ``values`` (3,) are the derivatives from u - 1 to u + 1.
    """
    none = (0.0, 0.0, 0.0, 0.0)
    rows, columns = frame.shape
    right, bottom = columns - 2.0, rows - 2.0
    nx, ny, sigma = normal[0], normal[1], channel.sigma
    x, y = image[0] + u * nx, image[1] + u * ny
    if x < 1.0 or y < 1.0 or x >= right or y >= bottom:
        return none
    pixel_noise = noise_at(frame, int(y + 0.5), int(x + 0.5))
    to_snr = sigma * sigma / (DERIVATIVE_NOISE * pixel_noise)
    sign = 1.0 if values[1] > 0.0 else -1.0
    here = abs(values[1])
    if here * to_snr < MIN_SNR:
        return none
    shift, bend = _parabola(sign * values[0], here, sign * values[2])
    if not abs(shift) <= MOST_SHIFT_PX:
        return none
    place = u + shift
    x, y = image[0] + place * nx, image[1] + place * ny
    if x < 2.0 or y < 2.0 or x >= right - 1.0 or y >= bottom - 1.0:
        return none
    along_x, along_y = _gradient(channel, x, y)
    here = sign * (nx * along_x + ny * along_y)
    if not here > 0.0:
        return none
    before = sign * derivative_at(channel, x - nx, y - ny, nx, ny)
    after = sign * derivative_at(channel, x + nx, y + ny, nx, ny)
    shift, bend = _parabola(before, here, after)
    across = nx * along_y - ny * along_x
    if not abs(shift) <= 0.5 or here < MIN_ALIGNED * math.sqrt(here * here + across * across):
        return none
    snr = here * to_snr
    if snr < MIN_SNR:
        return none
    sd = CURVATURE_NOISE * pixel_noise / (sigma * sigma * sigma * here * bend)
    row, column = int(y + 0.5), int(x + 0.5)
    tile = channel.near_clipped[channel.number[row >> TILE_BITS, column >> TILE_BITS]]
    if tile[row % TILE_PX * TILE_PX + column % TILE_PX] != 0:
        sd = math.sqrt(sd * sd + (CLIPPED_SD_PX * sigma) ** 2)
        snr *= 0.5
    return place + shift, snr, sd, sign * here
