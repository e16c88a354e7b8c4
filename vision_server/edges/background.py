"""The background of a set of images: how dark it is, and which dark places belong to it.

Some shadows are as dark as the background. They are surrounded by what is lit; the background goes on to the
border of the image.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from vision_server.channels.channel import ChannelStatistics
from vision_server.edges.edge_map import EdgeMap
from vision_server.edges.sides import Sides, furthest_reach

# Chosen by hand on renders and photographs: `python -m benchmarks.edge_kinds`.
BACKGROUND_SHARE = 0.02  # of the pixels, in their best lights, that are darker than what counts as background
SAMPLE_STEP = 4  # of the pixels that are ranked for it
CELL_PX = 4  # side of the squares of which the middle says whether they are dark
LEAST_AT_LARGE = 0.5  # share of what is dark, where the background is
DARK_RATIO = 2.7  # of such a mean in its best light to the background: more is none


def background_grey(channels: Sequence[ChannelStatistics]) -> float:
    """Grey at reference exposure that only few pixels stay under in their best light."""
    some = slice(None, None, SAMPLE_STEP)
    sampled = [channel.linear_at(some, some) / np.float32(channel.exposure) for channel in channels]
    return float(np.quantile(np.max(sampled, axis=0), BACKGROUND_SHARE))


def is_enclosed(edges: EdgeMap, sides: Sides, background: float) -> NDArray[np.bool_]:
    """Whether the darker side of each edgel, in its best light, is none of the background at large, (N,).

    Parameters
    ----------
    edges
        N edgels.
    sides
        Theirs.
    background
        Grey at reference exposure.
    """
    outside = _outside([_coarse(channel) for channel in edges.channels], background, sides.dark)
    lit = sides.brightest.max(axis=0)
    away = np.where(lit[0] < lit[1], -furthest_reach(edges), furthest_reach(edges))
    x, y = ((edges.points + away[:, None] * edges.normals) / CELL_PX).astype(np.int64).T
    rows, columns = outside.shape
    return np.asarray(outside[np.clip(y, 0, rows - 1), np.clip(x, 0, columns - 1)] == 0)


def _coarse(channel: ChannelStatistics) -> NDArray[np.float32]:
    """Mean intensity at reference exposure of two pixels in the middle of each whole cell."""
    first, step = CELL_PX // 2 - 1, CELL_PX
    rows, columns = (max(side // step, 1) * step for side in channel.shape)
    one, other = (
        channel.linear_at(slice(at, rows, step), slice(at, columns, step)) for at in (first, first + 1)
    )
    return np.asarray((one + other) * np.float32(0.5 / channel.exposure), np.float32)


def _outside(means: Sequence[NDArray[np.float32]], background: float, dark: float) -> NDArray[np.uint8]:
    """1 for cells that are of the background at large or beside it: dark ones that adjoin up to the border.

    All are where most of what is dark does not: then it is not the background that is dark.
    """
    is_dark = np.max(means, axis=0) + dark < DARK_RATIO * (background + dark)
    framed = np.pad(is_dark.astype(np.uint8), 1, constant_values=1)
    _, pieces = cv2.connectedComponents(framed, connectivity=4)
    at_large = (pieces == pieces[0, 0]).astype(np.uint8)[1:-1, 1:-1]
    if at_large.sum() < LEAST_AT_LARGE * is_dark.sum():
        return np.ones_like(at_large)
    return np.asarray(cv2.dilate(at_large, np.ones((3, 3), np.uint8)), np.uint8)
