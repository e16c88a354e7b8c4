"""Contours that fade into the dark: edgels where the logarithm of the best light steps, and no others are.

Where shading goes down to nearly nothing before the contour, or what is painted dark ends there, a body
hardly steps on a linear scale: the merge's edgel is where the shading is steepest, some pixels further in, or
noise has drowned it in each image. The ratio of what is left to a dark ground steps nevertheless. It is
looked for in the best light of each 2 x 2 px, whose noise is half of that of single ones.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from numerics.arrays import Field
from numerics.kernels import kernel
from numerics.logarithm import log_of
from numerics.ranks import at_share
from vision_server.channels.channel import ChannelStatistics
from vision_server.channels.depth import Pixels, linear_image
from vision_server.channels.gaussian import contrast_kernels, gaussian_gradient, noise_gain
from vision_server.edges.edge_map import EdgeMap
from vision_server.kinds.background import BACKGROUND_SHARE
from vision_server.kinds.sides import DARK_GREY

Places = NDArray[np.int32]

# Chosen by hand on half of the rendered statues of docs/kinds.md.
SCALE = 1.0  # of the derivative, in squares of 2 x 2 px
LEAST_STEP = np.float32(0.5)  # of the logarithm
NOISE_RATIO = 4.0  # a step under so many standard deviations of its noise is none
DARK_SIDE = 2.0  # times the background in the best lights, at most, are the darker sides
BESIDE = np.float32(2.5)  # of these squares from the edge, where its dark side is
DARKEST_STEP = 4  # of the squares that say how dark the background is
MOST_OFFSET = np.float32(0.7)  # of a square, from its middle to the edge: half a diagonal


def with_fading(edges: EdgeMap) -> EdgeMap:
    """A merged map of at least two channels with the edgels of contours that fade, of strength and mass 0."""
    added = np.float32(DARK_GREY / max(channel.exposure for channel in edges.channels))
    best = _best_light(edges.channels)
    best += added
    logs = _logarithms(best)
    along = gaussian_gradient(logs, contrast_kernels(SCALE))
    ground = at_share(logs[::DARKEST_STEP, ::DARKEST_STEP], BACKGROUND_SHARE)
    ground += np.float32(math.log(DARK_SIDE))
    coarse, offset = steps_into_the_dark(logs, *along, LEAST_STEP, ground)
    gains = [noise_gain(contrast_kernels(channel.sigma_px)) for channel in edges.channels]
    noises = np.stack([channel.light.noise_at(coarse) for channel in edges.channels])
    of_pixels = np.max(noises / np.array(gains, np.float32)[:, None], axis=0)
    noise = 0.5 * noise_gain(contrast_kernels(SCALE)) * of_pixels / best.ravel()[coarse]
    along_x, along_y = (component.ravel()[coarse] for component in along)
    sure = np.hypot(along_x, along_y) > NOISE_RATIO * noise
    axis = np.mod(np.arctan2(along_y, along_x), np.float32(np.pi))
    return _joined(edges, coarse[sure], axis[sure], offset[sure], noises.mean(axis=0)[sure])


@kernel(fastmath={"reassoc", "contract", "nsz"})
def _logarithms(values: Field) -> Field:
    """`np.log` of an image."""
    logs = np.empty_like(values)
    for y in range(len(values)):
        for x in range(values.shape[1]):
            logs[y, x] = log_of(values[y, x])
    return logs


@kernel()
def steps_into_the_dark(
    logs: Field, along_x: Field, along_y: Field, least: np.float32, ground: np.float32
) -> tuple[Places, Field]:
    """Where the gradient of a logarithm is a maximum across an edge and goes down to less than ``ground``.

    Returns
    -------
    Flat indices (N,), and how far from the middles there the edge is along its axis in [0, pi), float32 (N,):
    what `suppress_non_maxima` gives, which it is tested against.
    """
    rows, columns = logs.shape
    places, offsets = np.empty(logs.size, np.int32), np.empty(logs.size, np.float32)
    found = 0
    for y in range(1, rows - 1):
        for x in range(1, columns - 1):
            dx, dy = along_x[y, x], along_y[y, x]
            squared = dx * dx + dy * dy
            if squared < least * least:
                continue
            here = np.sqrt(squared)
            v = min(max(int(y - BESIDE * dy / here + np.float32(0.5)), 0), rows - 1)
            u = min(max(int(x - BESIDE * dx / here + np.float32(0.5)), 0), columns - 1)
            if logs[v, u] > ground:
                continue
            longer, shorter = max(abs(dx), abs(dy)), min(abs(dx), abs(dy))
            right, down = 1 if dx > 0.0 else -1, 1 if dy > 0.0 else -1
            straight_x, straight_y = (right, 0) if abs(dx) >= abs(dy) else (0, down)
            part = shorter / longer
            ahead = (np.float32(1.0) - part) * _length(along_x, along_y, y + straight_y, x + straight_x)
            ahead += part * _length(along_x, along_y, y + down, x + right)
            behind = (np.float32(1.0) - part) * _length(along_x, along_y, y - straight_y, x - straight_x)
            behind += part * _length(along_x, along_y, y - down, x - right)
            if here < ahead or here <= behind:
                continue
            curvature = ahead - np.float32(2.0) * here + behind
            offset = np.float32(0.5) * (behind - ahead) / curvature * here / longer
            offset = min(max(offset, -MOST_OFFSET), MOST_OFFSET)
            places[found] = y * columns + x
            offsets[found] = -offset if dy < 0.0 else offset
            found += 1
    return places[:found], offsets[:found]


@kernel(inline="always")
def _length(along_x: Field, along_y: Field, y: int, x: int) -> np.float32:
    length: np.float32 = np.sqrt(along_x[y, x] * along_x[y, x] + along_y[y, x] * along_y[y, x])
    return length


def _best_light(channels: Sequence[ChannelStatistics]) -> Field:
    """Grey at reference exposure of each 2 x 2 px in its brightest channel, float32 (H // 2, W // 2)."""
    brightest: dict[tuple[float, float, str], tuple[ChannelStatistics, Pixels]] = {}
    for channel in channels:  # of those that are exposed alike the brightest grey is the most light
        level = channel.light.level
        alike = (channel.exposure, channel.gamma, level.dtype.str)
        if alike in brightest:
            level = np.maximum(brightest[alike][1], level)
        brightest[alike] = channel, level
    return reduce(
        np.maximum,
        [
            linear_image(level, one.gamma, one.linear_of) / np.float32(one.exposure)
            for one, level in brightest.values()
        ],
    )


def _joined(edges: EdgeMap, coarse: Places, axis: Field, offset: Field, floor: Field) -> EdgeMap:
    """The map with two edgels side by side in each of some 2 x 2 px, unless it has some there.

    ``offset`` is how far from their middle along ``axis`` the edge is, in such squares.
    """
    places, squares, from_pixels = _free_pairs(edges.index, coarse, np.cos(axis), np.sin(axis), offset)
    places, first = np.unique(places, return_index=True)
    squares, none = squares[first], np.zeros(len(places), np.float32)
    order = np.argsort(np.concatenate([edges.places, places]), kind="stable")

    def with_new(values: NDArray[Any], of_new: NDArray[Any]) -> NDArray[Any]:
        return np.concatenate([values, of_new])[order]

    return replace(
        edges,
        places=with_new(edges.places, places),
        strength=with_new(edges.strength, none),
        mass=with_new(edges.mass, none),
        axis=with_new(edges.axis, axis[squares]),
        offset=with_new(edges.offset, from_pixels[first]),
        floor=with_new(edges.floor, floor[squares]),
    )


@kernel()
def _free_pairs(
    number_at: Places, coarse: Places, cosine: Field, sine: Field, offset: Field
) -> tuple[Places, Places, Field]:
    """The pixels beside which no edgel is, of the two in each of M squares that lie on an edge across.

    Returns
    -------
    Their places, the number of the square of each, and how far from its centre along the axis the edge is.
    """
    columns, count = number_at.shape[1], 0
    places, squares = np.empty(2 * len(coarse), np.int32), np.empty(2 * len(coarse), np.int32)
    from_pixels = np.empty(2 * len(coarse), np.float32)
    for side in (-0.5, 0.5):
        for i in range(len(coarse)):
            v = coarse[i] // (columns // 2)
            u = coarse[i] - v * (columns // 2)
            along = side / max(abs(cosine[i]), abs(sine[i]))
            x = 2.0 * (u + offset[i] * cosine[i]) + 0.5 - along * sine[i]
            y = 2.0 * (v + offset[i] * sine[i]) + 0.5 + along * cosine[i]
            column, row = int(np.rint(x)), int(np.rint(y))
            if _is_free(number_at, row, column):
                places[count], squares[count] = row * columns + column, i
                from_pixels[count] = (x - column) * cosine[i] + (y - row) * sine[i]
                count += 1
    return places[:count], squares[:count], from_pixels[:count]


@kernel(inline="always")
def _is_free(number_at: Places, row: int, column: int) -> bool:
    """Whether neither a pixel nor one beside it has an edgel."""
    most = np.int32(-1)
    for y in range(row - 1, row + 2):
        for x in range(column - 1, column + 2):
            most = max(most, number_at[y, x])
    return bool(most < 0)
