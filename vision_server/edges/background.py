"""The background of a set of images: how dark or how lit it is, and which dark places belong to it.

Some shadows are as dark as a dark background. They are surrounded by what is lit; the background goes on to
the border of the image, as does a table that is too dim for a wall. A lit one is a wall: most of the border
has its grey in each light.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from numerics.arrays import Field, Flags, Floats, Grey, Ints
from vision_server.channels.channel import ChannelStatistics
from vision_server.edges.edge_map import EdgeMap
from vision_server.edges.sides import Sides, furthest_reach

# Chosen by hand on renders and photographs: `python -m benchmarks.edge_kinds`.
BACKGROUND_SHARE = 0.02  # of the image, in its best lights, that is darker than what counts as background
CELL_PX = 4  # side of the squares of which the middle says whether they are dark
LEAST_AT_LARGE = 0.5  # share of what is dark, where the background is
DARK_RATIO = 2.7  # of such a mean in its best light to the background: more is none
EVEN = 0.3  # between the logarithms of a cell and of those beside it, in their best lights: no edge is there
FRAME_CELLS = 2  # at the image's border, by which a wall is told
WALL_SPREAD, LEAST_WALL = 0.1, 0.6  # of its logarithm there, in such a share: the rest is in shadow
WALL_FITS = 10  # with 5 large shadows at the dim end still pull it
LIT = 4.0  # times what is black, in every light: less tells no wall


class Background(NamedTuple):
    """What is behind, as N edgels see it.

    Attributes
    ----------
    dark
        Grey at reference exposure that only few pixels stay under in their best light.
    enclosed
        bool (N,), whether the darker side, in its best light, is none of the background at large; None: no
        edgel's is.
    wall
        Its grey beside each in each light at reference exposure (C, N); None where it is dark or no wall.
    """

    dark: float
    enclosed: Flags | None = None
    wall: Field | None = None

    def of(self, edgels: slice | Ints) -> Background:
        """As some of the edgels see it."""
        enclosed = None if self.enclosed is None else self.enclosed[edgels]
        wall = None if self.wall is None else self.wall[:, edgels]
        return Background(self.dark, enclosed, wall)


def background_of(edges: EdgeMap, sides: Sides) -> Background:
    """What is behind the edgels of a merged set, of which ``sides`` are."""
    means = [_coarse(channel) for channel in edges.channels]
    best = np.max(means, axis=0)
    dark = float(np.quantile(best, BACKGROUND_SHARE, method="nearest"))
    outside = _outside(best, dark, sides.dark)
    return Background(dark, _enclosed(edges, sides, outside), _wall(edges, means, sides.dark))


def _wall(edges: EdgeMap, means: Sequence[Field], dark: float) -> Field | None:
    """Grey (C, N) of a wall where each edgel is, in each light, as the frame tells it; or None.

    A wall's logarithm is a quadratic of the place: lamps are near. It is fitted again and again to what fits.
    """
    rows, columns = means[0].shape
    frame = np.ones((rows, columns), np.bool_)
    frame[FRAME_CELLS:-FRAME_CELLS, FRAME_CELLS:-FRAME_CELLS] = False
    greys = [mean[frame].astype(np.float64) + dark for mean in means]
    if any(np.median(grey) < (LIT + 1.0) * dark for grey in greys):
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
    at_edgels = _quadratic(*(edges.points / np.float32(CELL_PX)).T / [[columns], [rows]])
    return np.asarray(np.exp(fits @ at_edgels.T) - dark, np.float32)


def _quadratic(x: NDArray[np.floating], y: NDArray[np.floating]) -> Floats:
    """What a quadratic of places, as shares of the image, is linear in: (N, 6)."""
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=1).astype(np.float64)


def _enclosed(edges: EdgeMap, sides: Sides, outside: Grey) -> Flags:
    """Whether the darker side of each edgel, in its best light, is none of the background at large, (N,)."""
    lit = sides.brightest.max(axis=0)
    away = np.where(lit[0] < lit[1], -furthest_reach(edges), furthest_reach(edges))
    x, y = ((edges.points + away[:, None] * edges.normals) / CELL_PX).astype(np.int64).T
    rows, columns = outside.shape
    return np.asarray(outside[np.clip(y, 0, rows - 1), np.clip(x, 0, columns - 1)] == 0)


def _coarse(channel: ChannelStatistics) -> Field:
    """Mean intensity at reference exposure of two pixels in the middle of each whole cell."""
    first, step = CELL_PX // 2 - 1, CELL_PX
    rows, columns = (max(side // step, 1) * step for side in channel.shape)
    one, other = (
        channel.linear_at(slice(at, rows, step), slice(at, columns, step)) for at in (first, first + 1)
    )
    return np.asarray((one + other) * np.float32(0.5 / channel.exposure), np.float32)


def _outside(best: Field, background: float, dark: float) -> Grey:
    """1 for cells that are of the background at large or beside it.

    Those are dark ones that adjoin up to the border, and even ones that do, as of a table. All are where most
    of what is dark does not: then it is not the background that is dark.
    """
    is_dark = best + dark < DARK_RATIO * (background + dark)
    at_large = _up_to_the_border(is_dark)
    if at_large.sum() < LEAST_AT_LARGE * is_dark.sum():
        return np.ones_like(at_large)
    beside, logs = np.ones((3, 3), np.uint8), np.log(best + np.float32(dark))
    is_even = cv2.dilate(logs, beside) - cv2.erode(logs, beside) < EVEN
    return np.asarray(cv2.dilate(at_large | _up_to_the_border(np.asarray(is_even)), beside), np.uint8)


def _up_to_the_border(cells: Flags) -> Grey:
    """1 for those of the cells that adjoin each other up to the border of the image."""
    framed = np.pad(cells.astype(np.uint8), 1, constant_values=1)
    _, pieces = cv2.connectedComponents(framed, connectivity=4)
    return np.asarray((pieces == pieces[0, 0])[1:-1, 1:-1], np.uint8)
