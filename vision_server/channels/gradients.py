"""The smoothed gradient of one channel at the scales that refinement asks for, computed where it looks.

A pose is measured on the normals of lines, a few pixels to either side: of a large image hardly anything is
ever looked at. So the image is cut into tiles, and a tile is computed when a normal first runs into it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from threading import Lock
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from numerics.arrays import Field, Floats, Grey, Ints
from numerics.kernels import kernel
from vision_server.channels.channel import ChannelStatistics
from vision_server.channels.depth import PER_GREY, Deep, Pixels, is_deep, linear_image, rounded
from vision_server.channels.gaussian import contrast_kernels, gaussian_gradient, gaussian_kernels, noise_gain
from vision_server.channels.noise import SATURATED_GREY

Numbers = NDArray[np.int32]

SCALES_PX = (1.0, 2.0, 4.0, 8.0)  # Gaussian derivatives: sharp, soft, defocused, motion-blurred
# Chosen by hand: smaller tiles cost more for what surrounds each of them, larger ones hold more that nobody
# looks at.
TILE_BITS = 5
TILE_PX = 1 << TILE_BITS
FULL = 0.2  # of a block of tiles, at least, that are computed at once
ALIGNED_PX = 32  # blocks start at multiples: filters of some pixels at once give the same everywhere
SIDE_PX = TILE_PX + 1  # kept of a tile: with the first row and column of the next, to look between pixels
NONE: Deep = np.empty((0, 0), np.uint16)


class Normals(NamedTuple):
    """Where edges are looked for.

    Attributes
    ----------
    image, normal : (N, 2) px; the unit normal of the line in the image.
    reach_px : (N,), how far to look to either side.
    """

    image: Floats
    normal: Floats
    reach_px: Floats


class Picture(NamedTuple):
    """What tiles are made of: pixels (H, W) as they came, and their tone curve, see `linear_image`."""

    pixels: Pixels
    gamma: float
    linear_of: Field


class Frame(NamedTuple):
    """How large a channel is, and its noise.

    Attributes
    ----------
    shape
        Height and width in px.
    level
        uint8 (H, W) or (H // 2, W // 2), grey of each pixel or of each 2 x 2 px, and ``noise_of`` (256,) the
        standard deviation of the linear intensity from sensor noise at each grey.
    deep_level
        uint16, as ``level`` and in its place, of an image of more than 8 bits; (0, 0) of others.
    """

    shape: tuple[int, int]
    level: Grey
    deep_level: Deep
    noise_of: Field

    @classmethod
    def of(cls, shape: tuple[int, ...], level: Pixels, noise_of: Field) -> Frame:
        """With (0, 0) for the level that it does not have."""
        level, size = np.ascontiguousarray(level), (shape[0], shape[1])
        if is_deep(level):
            return cls(size, NONE.astype(np.uint8), level, noise_of)
        return cls(size, level, NONE, noise_of)


@kernel()
def noise_at(frame: Frame, row: int, column: int) -> float:
    """Standard deviation of the linear intensity of a pixel from sensor noise."""
    deep = frame.deep_level.size > 0
    rows, columns = frame.deep_level.shape if deep else frame.level.shape
    if rows < frame.shape[0]:
        row, column = min(row >> 1, rows - 1), min(column >> 1, columns - 1)
    if not deep:
        return float(frame.noise_of[frame.level[row, column]])
    grey = frame.deep_level[row, column] / PER_GREY
    low = min(int(grey), 254)
    share = min(grey - low, 1.0)
    return float((1.0 - share) * frame.noise_of[low] + share * frame.noise_of[low + 1])


class Tiles(NamedTuple):
    """The tiles of a channel, in the order in which they were asked for; memory that is not used is none.

    Attributes
    ----------
    number
        int32 (S, V, U), of each tile at each scale, -1 where nobody has looked.
    gradient
        float32 (S, V U, SIDE_PX^2, 2), derivatives along x and y per px.
    near_clipped
        uint8 (S, V U, TILE_PX^2), 1 where a saturated pixel is within the filter's reach.
    smooth
        float32 (V U, TILE_PX^2), linear intensity smoothed at the first scale, numbered as that.
    """

    number: Numbers
    gradient: Field
    near_clipped: Grey
    smooth: Field


@dataclass(eq=False)
class GradientChannel:
    """One channel as refinement sees it: its tiles, what they are made of, how many there are by scale.

    Parameters
    ----------
    around_px
        So much farther than asked tiles are computed where a scale is first looked at: later looks go beside
        that, and each that finds a tile missing costs as much as many at once do.
    blur_px
        Of the image, 0 where nobody knows.
    """

    name: str
    picture: Picture
    frame: Frame
    around_px: float = 0.0
    blur_px: float = 0.0
    tiles: Tiles = field(init=False)
    count: Ints = field(init=False)
    _lock: Lock = field(init=False, default_factory=Lock, repr=False)

    def __post_init__(self) -> None:
        rows, columns = (-(-side // TILE_PX) for side in self.frame.shape)
        scales, total = len(SCALES_PX), rows * columns
        self.tiles = Tiles(
            np.full((scales, rows, columns), -1, np.int32),
            np.empty((scales, total, SIDE_PX * SIDE_PX, 2), np.float32),
            np.zeros((scales, total, TILE_PX * TILE_PX), np.uint8),
            np.empty((total, TILE_PX * TILE_PX), np.float32),
        )
        self.count = np.zeros(scales, np.int64)

    def prepare(self, scale: Ints, normals: Normals, beyond_px: float) -> None:
        """Compute the tiles that normals run into, and so many px farther, that are not there yet.

        Parameters
        ----------
        scale
            (N,), index into SCALES_PX for each normal; the first scale is needed everywhere.
        """
        with self._lock:  # of two threads that look at a pose each, one may need what the other has begun
            known = self.count.copy()
            if known[scale.max(initial=0)] == 0:
                beyond_px += self.around_px
            new = _claimed(self.tiles.number, self.count, self.frame.shape, scale, normals, float(beyond_px))
            for index in np.flatnonzero(self.count > known).tolist():
                first = int(known[index])
                for block in blocks_of(new[index, first : self.count[index]]):
                    self._fill(index, first, block)

    def _fill(self, index: int, first: int, block: Numbers) -> None:
        """The new tiles of a block, numbered from ``first`` on, from what surrounds it."""
        kernels, tiles = gaussian_kernels(SCALES_PX[index]), self.tiles
        reach = len(kernels[0]) // 2
        top, left = (max(TILE_PX * int(start) - reach, 0) for start in block[:2])
        bottom, right = (TILE_PX * int(end) + 1 + reach for end in block[2:])
        left -= left % ALIGNED_PX
        pixels = self.picture.pixels[top:bottom, left : right + ALIGNED_PX]
        source = linear_image(pixels, self.picture.gamma, self.picture.linear_of)
        corner, number = np.array([top, left]), tiles.number[index]

        def lay(field: Pixels, out: Pixels) -> None:
            _cut(field, corner, block, number, first, out)

        along_x, along_y = gaussian_gradient(source, kernels)
        _cut_gradient(along_x, along_y, corner, block, number, first, tiles.gradient[index])
        if index == 0:
            smooth = kernels[0]
            blurred = cv2.sepFilter2D(source, cv2.CV_32F, smooth, smooth, borderType=cv2.BORDER_REPLICATE)
            lay(blurred, tiles.smooth)
        clipped = (rounded(pixels) >= SATURATED_GREY).astype(np.uint8)
        if cv2.countNonZero(clipped):
            side = 2 * clip_reach(index) + 1
            lay(cv2.dilate(clipped, np.ones((side, side), np.uint8)), tiles.near_clipped[index])


def clip_reach(index: int) -> int:
    """How far from a saturated pixel the filter of a scale is not to be trusted, px."""
    return int(np.ceil(2.0 * SCALES_PX[index]))


@kernel()
def _claimed(
    number: Numbers, count: Ints, shape: tuple[int, int], scale: Ints, normals: Normals, beyond_px: float
) -> Numbers:
    """Number the tiles that are missing; row and column (S, V U, 2) of those by their numbers."""
    places = np.empty((number.shape[0], number[0].size, 2), np.int32)
    for i in range(len(scale)):
        reach, image, normal = normals.reach_px[i] + beyond_px, normals.image[i], normals.normal[i]
        across, down = reach * abs(normal[0]) + 1.0, reach * abs(normal[1]) + 1.0
        left, right = max(image[0] - across, 0.0), min(image[0] + across, shape[1] - 1.0)
        top, bottom = max(image[1] - down, 0.0), min(image[1] + down, shape[0] - 1.0)
        if not (left <= right and top <= bottom):
            continue
        for index in (0, scale[i]):
            for v in range(int(top) >> TILE_BITS, (int(bottom) >> TILE_BITS) + 1):
                for u in range(int(left) >> TILE_BITS, (int(right) >> TILE_BITS) + 1):
                    if number[index, v, u] < 0:
                        number[index, v, u] = count[index]
                        places[index, count[index], 0], places[index, count[index], 1] = v, u
                        count[index] += 1
    return places


def blocks_of(places: Numbers) -> Iterator[Numbers]:
    """Rectangles that hold all of some tiles (N, 2), and hardly others: first and last row and column."""
    low, high = places.min(axis=0), places.max(axis=0) + 1
    if len(places) >= FULL * np.prod(high - low):
        yield np.concatenate([low, high])
        return
    axis = int(np.argmax(high - low))
    before = places[:, axis] < (low[axis] + high[axis]) // 2
    for part in (places[before], places[~before]):
        if len(part):
            yield from blocks_of(part)


@kernel()
def _cut(image: Field, corner: Ints, block: Numbers, number: Numbers, first: int, out: Field) -> None:
    """Lay an image whose first pixel is at a ``corner`` (row, column) into the new tiles of a block.

    ``out`` (V U, TILE_PX^2) has one value of each pixel of a tile.
    """
    for v in range(block[0], block[2]):
        for u in range(block[1], block[3]):
            if number[v, u] < first:
                continue
            top, left, tile = TILE_PX * v - corner[0], TILE_PX * u - corner[1], out[number[v, u]]
            there = min(TILE_PX, image.shape[1] - left)  # beyond, it is as at its border
            for y in range(TILE_PX):
                given = image[min(top + y, len(image) - 1), left : left + there]
                row = tile[y * TILE_PX : (y + 1) * TILE_PX]
                for x in range(there):
                    row[x] = given[x]
                row[there:] = given[there - 1]


@kernel()
def _cut_gradient(
    along_x: Field, along_y: Field, corner: Ints, block: Numbers, number: Numbers, first: int, out: Field
) -> None:
    """`_cut` of both derivatives into ``out`` (V U, SIDE_PX^2, 2)."""
    for v in range(block[0], block[2]):
        for u in range(block[1], block[3]):
            if number[v, u] < first:
                continue
            top, left, tile = TILE_PX * v - corner[0], TILE_PX * u - corner[1], out[number[v, u]]
            there = min(SIDE_PX, along_x.shape[1] - left)
            for y in range(SIDE_PX):
                place = min(top + y, len(along_x) - 1)
                one, two = along_x[place, left : left + there], along_y[place, left : left + there]
                row = tile[y * SIDE_PX : (y + 1) * SIDE_PX]
                for x in range(there):
                    row[x, 0], row[x, 1] = one[x], two[x]
                row[there:, 0], row[there:, 1] = one[there - 1], two[there - 1]


def gradient_channel(name: str, known: ChannelStatistics) -> GradientChannel:
    """The refinement's view of a channel whose edge statistics are known.

    Their noise is that of the contrast, and is brought back to single pixels here.
    """
    kernels = contrast_kernels(known.sigma_px, known.exposure)
    noise_of = known.light.noise_of / np.float32(noise_gain(kernels) * known.noise_factor)
    picture = Picture(known.pixels, known.gamma, known.linear_of)
    frame = Frame.of(known.shape, known.light.level, noise_of)
    return GradientChannel(name, picture, frame, blur_px=known.blur_px)
