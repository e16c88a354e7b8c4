"""Pixels of one image, as a list, whose Gaussian derivative stands out of the noise, as in Canny (1986)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from numerics.arrays import Field, Grey
from numerics.axis import axis_of
from numerics.kernels import kernel
from numerics.marks import Marks, list_marks, no_marks
from vision_server.channels.gaussian import Kernels, gaussian_gradient

Places = NDArray[np.int32]

# Chosen by hand.
FLANK_RATIO = np.float32(0.65)  # under this share of what is a step along its gradient it is an edge's foot
FIRST_ROOM = 8  # of so many pixels one has room at first: of most images fewer are listed


class Gradient(NamedTuple):
    """Gradient of an image: components along x and y, and length; float32 (H, W) each."""

    x: Field
    y: Field
    magnitude: Field


class GradientPixels(NamedTuple):
    """Pixels above the noise floor, in raster order; all arrays (N,).

    Attributes
    ----------
    places
        int32, flat index into the image.
    magnitude
        float32, length of the gradient.
    axis
        float32, direction of the gradient taken as an axis, rad in [0, pi), 0 along x, pi/2 along y (down).
    flank_sum
        float32, sum of the magnitudes one step ahead and behind, interpolated on the ring of the eight
        neighbours where the gradient's line meets it.
    flank_x, flank_y
        float32, magnitude ahead less that behind, times the unit vector of the gradient: a vector that does
        not depend on which way the axis is read.
    """

    places: Places
    magnitude: Field
    axis: Field
    flank_sum: Field
    flank_x: Field
    flank_y: Field


def gradient(linear: Grey | Field, kernels: Kernels) -> Gradient:
    """Gradient of an image's linear intensity.

    Parameters
    ----------
    linear
        Linear intensity, uint8 or float32 (H, W).
    kernels
        Across and along the derivative, see `contrast_kernels`.
    """
    along_x, along_y = gaussian_gradient(linear, kernels)
    return Gradient(along_x, along_y, _length(along_x, along_y))


@kernel()
def _length(along_x: Field, along_y: Field) -> Field:
    """Length of each vector; `cv2.magnitude` rounds by where its arrays lie in memory, run by run."""
    length = np.empty_like(along_x)
    for y in range(len(length)):
        for x in range(length.shape[1]):
            length[y, x] = np.sqrt(along_x[y, x] * along_x[y, x] + along_y[y, x] * along_y[y, x])
    return length


class PixelList(NamedTuple):
    """A list of pixels that grows: ``places`` (M,), and ``values`` (5, M), the rest of `GradientPixels`."""

    places: Places
    values: Field

    def first(self, found: int) -> GradientPixels:
        """The first so many."""
        return GradientPixels(self.places[:found], *self.values[:, :found])


@kernel()
def empty_list(pixels: int) -> PixelList:
    """For the pixels of some rows, of which there are so many."""
    room = pixels // FIRST_ROOM
    return PixelList(np.empty(room, np.int32), np.empty((5, room), np.float32))


@kernel()
def with_room(listed: PixelList, found: int, more: int) -> PixelList:
    """The same list, or a longer one, with room for so many more than the first ones that are found."""
    if found + more <= len(listed.places):
        return listed
    room = 2 * len(listed.places) + more
    places, values = np.empty(room, np.int32), np.empty((5, room), np.float32)
    places[:found], values[:, :found] = listed.places[:found], listed.values[:, :found]
    return PixelList(places, values)


@kernel(inline="always")
def list_row(
    flat: Gradient, rows: tuple[int, int, int], columns: int, place: int,
    floor: tuple[Field, np.float32, Grey], marks: Marks, listed: PixelList, found: int,
) -> int:  # fmt: skip
    """List the pixels of a row that `pixels_of_rows` gives; to be inlined in kernels.

    Parameters
    ----------
    flat
        Gradient of some rows, one behind the other, float32 (M,) each.
    rows
        Where in it the row before begins, the row itself, and the row after.
    columns, place
        How long a row is, and where this one begins in the image.
    floor
        For each grey, float32 (256,); the lowest of these; grey by which it is looked up, uint8 (W // 2,).
    marks
        Room to work in.
    listed, found
        Output, with room for the row, and how many pixels are listed already.

    Returns
    -------
    How many are listed then.
    """
    along_x, along_y, magnitude = flat
    places, values = listed
    above, strong = marks.marked, marks.numbers
    before, here, after = rows
    floor_of, lowest, greys = floor
    last, zero = len(greys) - 1, np.float32(0.0)
    of_row, dx_row, dy_row, above_row, below_row = (
        magnitude[here : here + columns], along_x[here : here + columns], along_y[here : here + columns],
        magnitude[before : before + columns], magnitude[after : after + columns],
    )  # fmt: skip
    for x in range(1, columns - 1):  # fills vector registers
        beside, across = max(of_row[x - 1], of_row[x + 1]), max(above_row[x], below_row[x])
        nearest = beside if abs(dx_row[x]) > abs(dy_row[x]) else across
        above[x] = (of_row[x] > lowest) & (of_row[x] >= FLANK_RATIO * nearest)
    candidates, count = strong[: list_marks(marks)], 0
    for x in candidates:
        strong[count] = x
        count += of_row[x] > floor_of[greys[min(x >> 1, last)]]
    for x in strong[:count]:
        at = here + x
        m, dx, dy = magnitude[at], along_x[at], along_y[at]
        a, b = abs(dx), abs(dy)
        # one step to either side: straight on, and on the diagonal that the gradient leans to
        right = 1 if dx > zero else -1
        down, up = (after + x, before + x) if dy > zero else (before + x, after + x)
        straight, back = (at + right, at - right) if a > b else (down, up)
        t = min(a, b) / max(a, b)
        ahead_of = magnitude[straight] + t * (magnitude[down + right] - magnitude[straight])
        behind_of = magnitude[back] + t * (magnitude[up - right] - magnitude[back])
        difference = (ahead_of - behind_of) / m
        places[found] = place + x
        values[0, found] = m
        values[1, found] = axis_of(dx, dy)
        values[2, found] = ahead_of + behind_of
        values[3, found] = difference * dx
        values[4, found] = difference * dy
        found += m >= FLANK_RATIO * max(ahead_of, behind_of)
    return found


def pixels_of_rows(gradient: Gradient, level: Grey, floor_of: Field, first: int, end: int) -> GradientPixels:
    """The pixels whose gradient is above the floor, and that are not on the foot of a stronger one.

    The outermost row or column of the image is not among them.

    Parameters
    ----------
    gradient
        Of the image.
    level
        uint8 (H // 2, W // 2), grey by which the floor is looked up.
    floor_of
        float32 (256,), the floor for each grey.
    first, end
        The rows that are looked at.
    """
    listed, found = _list_rows(gradient, level, floor_of, first, end)
    return listed.first(found)


@kernel(fastmath={"reassoc", "contract", "nsz"})
def _list_rows(
    gradient: Gradient, level: Grey, floor_of: Field, first: int, end: int
) -> tuple[PixelList, int]:
    rows, columns = gradient.magnitude.shape
    flat = Gradient(gradient.x.ravel(), gradient.y.ravel(), gradient.magnitude.ravel())
    first, end = max(first, 1), min(end, rows - 1)
    listed, marks, found = empty_list(max(end - first, 0) * columns), no_marks(columns), 0
    lowest = floor_of.min()
    for y in range(first, end):
        listed, at = with_room(listed, found, columns), y * columns
        floor = floor_of, lowest, level[min(y >> 1, len(level) - 1)]
        begin = at - columns, at, at + columns
        found = list_row(flat, begin, columns, at, floor, marks, listed, found)
    return listed, found


def joined(*parts: GradientPixels) -> GradientPixels:
    """The pixels of rows that follow each other."""
    return GradientPixels(*(np.concatenate(values) for values in zip(*parts, strict=True)))
