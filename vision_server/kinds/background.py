"""The background of a set of images: how dark or how lit it is, and which edges adjoin it.

Some shadows are as dark as a dark background. They are surrounded by what is lit; the background goes on to
the border of the image, as does a table that is too dim for a wall (`kinds.ground`). A lit one is a wall:
most of the border has its grey in each light.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from numerics.arrays import Field, Floats, Grey, Ints
from numerics.kernels import kernel
from numerics.ranks import at_share
from vision_server.channels.channel import ChannelStatistics
from vision_server.channels.depth import is_deep
from vision_server.edges.edge_map import EdgeMap
from vision_server.kinds.ground import CELL_PX, dark_or_even, free_cells, like_wall, sides_met
from vision_server.kinds.sides import Sides

# Chosen by hand on renders and photographs: `python -m benchmarks.edge_kinds`.
BACKGROUND_SHARE = 0.02  # of the image, in its best lights, that is darker than what counts as background
SAMPLE_CELLS = 4  # step of the cells that say how dark a background is
SAMPLE_PX = 4  # side of the squares whose middles say that it is a wall
FRAME_CELLS = 2  # of these, at the image's border, by which a wall is told
WALL_SPREAD, LEAST_WALL = 0.1, 0.6  # of its logarithm there, in such a share: the rest is in shadow
WALL_FITS = 10  # with 5 large shadows at the dim end still pull it
LIT = 4.0  # times what is black, in every light: less tells no wall


class Background(NamedTuple):
    """What is behind, as N edgels see it.

    Attributes
    ----------
    dark
        Grey at reference exposure that only few pixels stay under in their best light.
    met
        uint8 (N,), how many of an edgel's sides meet the ground (`kinds.ground`); None: that is not known.
    wall
        Its grey beside each in each light at reference exposure (C, N); None where it is dark or no wall.
    """

    dark: float
    met: Grey | None = None
    wall: Field | None = None

    def of(self, edgels: slice | Ints) -> Background:
        """As some of the edgels see it."""
        met = None if self.met is None else self.met[edgels]
        wall = None if self.wall is None else self.wall[:, edgels]
        return Background(self.dark, met, wall)


def background_of(edges: EdgeMap, sides: Sides) -> Background:
    """What is behind the edgels of a merged set, of which ``sides`` are."""
    best = brightest_cells(edges.channels)
    dark = float(at_share(best[::SAMPLE_CELLS, ::SAMPLE_CELLS], BACKGROUND_SHARE))
    fits = _wall_fits(edges.channels, sides.dark)
    free = free_cells(edges, sides, best.shape)
    if fits is None:
        return Background(dark, sides_met(edges, dark_or_even(best, dark, sides.dark, free)))
    walls = _walls_at_cells(fits, best.shape)
    in_image = (edges.points / np.float32(CELL_PX)).T / [[best.shape[1]], [best.shape[0]]]
    at_edgels = np.exp(fits @ _quadratic(*in_image).T) - sides.dark
    greys = (_coarse(channel, CELL_PX) for channel in edges.channels)
    met = sides_met(edges, like_wall(greys, walls, best, sides.dark, free))
    return Background(dark, met, np.asarray(at_edgels, np.float32))


def _wall_fits(channels: Sequence[ChannelStatistics], dark: float) -> Floats | None:
    """What a wall's logarithm is in each light, as the frame tells it: of `_quadratic` (C, 6); or None.

    It is a quadratic of the place, as lamps are near, and is fitted again and again to what fits.
    """
    rows, columns = (max(side // SAMPLE_PX, 1) for side in channels[0].shape)
    frame = np.ones((rows, columns), np.bool_)
    frame[FRAME_CELLS:-FRAME_CELLS, FRAME_CELLS:-FRAME_CELLS] = False
    greys = []
    for channel in channels:
        greys.append(_coarse(channel, SAMPLE_PX)[frame].astype(np.float64) + dark)
        if np.count_nonzero(greys[-1] < (LIT + 1.0) * dark) > len(greys[-1]) / 2:
            return None
    y, x = np.nonzero(frame)
    at_frame = _quadratic((x + 0.5) / columns, (y + 0.5) / rows)
    fits = []
    for logs in np.log(greys):
        left = logs - np.median(logs)
        for _ in range(WALL_FITS):
            weight = 1.0 / (1.0 + np.square(left / WALL_SPREAD))
            weighted = at_frame * weight[:, None]
            fitted = np.linalg.lstsq(weighted.T @ at_frame, weighted.T @ logs)[0]
            left = logs - at_frame @ fitted
        if (np.abs(left) < WALL_SPREAD).mean() < LEAST_WALL:
            return None
        fits.append(fitted)
    return np.asarray(fits)


def _walls_at_cells(fits: Floats, shape: tuple[int, int]) -> Field:
    """Grey of the wall in each light, as its logarithm's ``fits`` tell it, float32 (C, rows, columns)."""
    rows, columns = shape
    x, y = (np.arange(columns) + 0.5) / columns, (np.arange(rows) + 0.5) / rows
    # the terms of `_quadratic` that are of a column, those that are of a row, and the one of both
    along = fits[:, [0, 1, 3]] @ np.stack([np.ones_like(x), x, x * x])
    down = fits[:, [2, 5]] @ np.stack([y, y * y])
    of_both = fits[:, 4, None, None] * (y[:, None] * x)
    return np.asarray(np.exp(along[:, None] + down[:, :, None] + of_both), np.float32)


def _quadratic(x: NDArray[np.floating], y: NDArray[np.floating]) -> Floats:
    """What a quadratic of places, as shares of the image, is linear in: (N, 6)."""
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=1).astype(np.float64)


def _coarse(channel: ChannelStatistics, step: int) -> Field:
    """Mean intensity at reference exposure of two pixels in the middle of each whole square of so many px."""
    scale = np.float32(0.5 / channel.exposure)
    if not is_deep(channel.pixels):
        means = np.zeros([max(side // step, 1) for side in channel.shape], np.float32)
        _brighten(channel.pixels, channel.linear_of, scale, step, means)
        return means
    first = step // 2 - 1
    rows, columns = (max(side // step, 1) * step for side in channel.shape)
    one, other = (
        channel.linear_at(slice(at, rows, step), slice(at, columns, step)) for at in (first, first + 1)
    )
    return np.asarray((one + other) * scale, np.float32)


def brightest_cells(channels: Sequence[ChannelStatistics]) -> Field:
    """Grey of each cell in its best light: the largest that `_coarse` gives, of cells, in some channels."""
    rows, columns = (max(side // CELL_PX, 1) for side in channels[0].shape)
    if all(channel.gamma == 1.0 and not is_deep(channel.pixels) for channel in channels):
        everywhere = np.zeros((rows, CELL_PX * columns), np.float32)
        for channel in channels:
            _brighten_linear(channel.pixels, np.float32(0.5 / channel.exposure), everywhere)
        return np.ascontiguousarray(everywhere[:, ::CELL_PX])
    best = np.zeros((rows, columns), np.float32)
    for channel in channels:
        if is_deep(channel.pixels):
            np.maximum(best, _coarse(channel, CELL_PX), out=best)
        else:
            _brighten(channel.pixels, channel.linear_of, np.float32(0.5 / channel.exposure), CELL_PX, best)
    return best


@kernel()
def _brighten(pixels: Grey, linear_of: Field, scale: np.float32, step: int, best: Field) -> None:
    """Let squares (rows, columns) of ``best``, of so many px, be at least as bright as `_coarse` has them."""
    first = step // 2 - 1
    for v in range(len(best)):
        row, next_row, of_row = pixels[step * v + first], pixels[step * v + first + 1], best[v]
        for u in range(len(of_row)):
            at = step * u + first
            of_row[u] = max(of_row[u], (linear_of[row[at]] + linear_of[next_row[at + 1]]) * scale)


@kernel()
def _brighten_linear(pixels: Grey, scale: np.float32, best: Field) -> None:
    """`_brighten` by cells, without a tone curve: between them as well, which fills vector registers."""
    for v in range(len(best)):
        row, next_row, of_row = pixels[CELL_PX * v], pixels[CELL_PX * v + 1], best[v]
        for x in range(best.shape[1] - 1):
            of_row[x] = max(of_row[x], (np.float32(row[x]) + np.float32(next_row[x + 1])) * scale)
