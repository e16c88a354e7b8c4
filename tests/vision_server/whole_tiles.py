"""The tiles of a channel put together to whole images, and channels whose linear intensity is given."""

from typing import NamedTuple

import numpy as np

from numerics.arrays import Field, Grey
from vision_server.channels.gradients import (
    SCALES_PX,
    SIDE_PX,
    TILE_PX,
    Frame,
    GradientChannel,
    Normals,
    Picture,
)


class Whole(NamedTuple):
    """(S, H, W, 2), (S, H, W) and (H, W); NaN, and 255 of ``near_clipped``, where no tile is."""

    gradient: Field
    near_clipped: Grey
    smooth: Field


def deep_channel(linear: Field, noise: float) -> GradientChannel:
    """A channel (H, W) of that intensity with the same noise everywhere."""
    level, table = np.zeros(linear.shape, np.uint8), np.full(256, noise, np.float32)
    picture = Picture(linear, 1.0, np.zeros(256, np.float32))
    return GradientChannel("i1", picture, Frame.of(linear.shape, level, table))


def everywhere(channel: GradientChannel) -> None:
    """Look at all of the image at all scales."""
    height, width = channel.frame.shape
    y, x = np.mgrid[0 : height + TILE_PX : TILE_PX, 0 : width + TILE_PX : TILE_PX].reshape(2, -1)
    image = np.column_stack([x, y]).astype(np.float64)
    normals = Normals(image, np.full(image.shape, 0.5**0.5), np.full(len(image), float(TILE_PX)))
    for scale in range(len(SCALES_PX)):
        channel.prepare(np.full(len(image), scale), normals, 0.0)


def whole(channel: GradientChannel) -> Whole:
    """What the tiles hold, each at its place; where two do, what the one holds whose place it is."""
    height, width = channel.frame.shape
    scales, tiles = len(SCALES_PX), channel.tiles
    gradient = np.full((scales, height, width, 2), np.nan, np.float32)
    clipped = np.full((scales, height, width), 255, np.uint8)
    smooth = np.full((height, width), np.nan, np.float32)
    for scale, v, u in np.argwhere(tiles.number >= 0).tolist():
        number, top, left = tiles.number[scale, v, u], v * TILE_PX, u * TILE_PX
        high, wide = min(TILE_PX, height - top), min(TILE_PX, width - left)
        there, inside = np.s_[top : top + high, left : left + wide], np.s_[:high, :wide]
        gradient[scale][there] = tiles.gradient[scale, number].reshape(SIDE_PX, SIDE_PX, 2)[inside]
        clipped[scale][there] = tiles.near_clipped[scale, number].reshape(TILE_PX, TILE_PX)[inside]
        if scale == 0:
            smooth[there] = tiles.smooth[number].reshape(TILE_PX, TILE_PX)[inside]
    return Whole(gradient, clipped, smooth)
