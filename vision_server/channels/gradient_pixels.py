"""Pixels of one image whose gradient stands out of the noise: one pass, no image in between.

The separable Gaussian derivative runs row by row over a ring of rows that stays in the processor's cache.
Where the magnitude exceeds the noise floor the pixel is listed, with its axis and the magnitude one step to
either side along its gradient; everything after this pass works on the list."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from numerics.axis import axis_of
from numerics.flags import set_places
from numerics.kernels import kernel
from vision_server.channels.noise import LEVELS, smooth_noise_factor

Grey = NDArray[np.uint8]
Field = NDArray[np.float32]
Places = NDArray[np.int32]

SAMPLED_ROW_STEP = 16  # rows whose magnitudes are sampled, for the noise in flat parts
FLANK_RATIO = 0.65  # under this share of what is a step along its gradient a pixel lies on an edge's foot
TAPS = 3  # of a kernel's arm that are summed at once, in registers
NARROW = 2  # radius of the kernels of sharp and clean images, which are most: two taps at once are all
NEGLIGIBLE = 0.015  # of a kernel's largest tap: less at both ends of both kernels is left out
VALUES = 5  # per pixel: magnitude, axis, sum of the flanks, their difference along x and y


@dataclass(frozen=True, eq=False)
class GradientPixels:
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

    def __len__(self) -> int:
        return len(self.places)


@kernel(inline="always")
def _correlate_columns(
    ring: Field, y: int, smooth: Field, derivative: Field, smoothed: Field, derived: Field
) -> None:
    """Both kernels down the columns around row ``y`` of the ring."""
    count = len(ring)
    radius, columns = count // 2, ring.shape[1]
    inner, inner_derived = smoothed[radius : radius + columns], derived[radius : radius + columns]
    here, middle = ring[y % count], smooth[radius]
    for t in range(1, radius + 1, TAPS):
        a, b, c = ring[(y + t) % count], ring[(y + t + 1) % count], ring[(y + t + 2) % count]
        d, e, f = ring[(y - t) % count], ring[(y - t - 1) % count], ring[(y - t - 2) % count]
        p, q, r = smooth[radius + t], smooth[radius + t + 1], smooth[radius + t + 2]
        u, v, w = derivative[radius + t], derivative[radius + t + 1], derivative[radius + t + 2]
        if t == 1:
            for x in range(columns):
                inner[x] = middle * here[x] + p * (a[x] + d[x]) + q * (b[x] + e[x]) + r * (c[x] + f[x])
            for x in range(columns):
                inner_derived[x] = u * (a[x] - d[x]) + v * (b[x] - e[x]) + w * (c[x] - f[x])
        else:
            for x in range(columns):
                inner[x] += p * (a[x] + d[x]) + q * (b[x] + e[x]) + r * (c[x] + f[x])
            for x in range(columns):
                inner_derived[x] += u * (a[x] - d[x]) + v * (b[x] - e[x]) + w * (c[x] - f[x])


@kernel(inline="always")
def _correlate_narrow_columns(
    ring: Field, y: int, smooth: Field, derivative: Field, smoothed: Field, derived: Field
) -> None:
    """`_correlate_columns` with kernels of radius NARROW."""
    columns = ring.shape[1]
    inner, inner_derived = smoothed[NARROW : NARROW + columns], derived[NARROW : NARROW + columns]
    a, b, d, e = ring[(y + 1) % 5], ring[(y + 2) % 5], ring[(y - 1) % 5], ring[(y - 2) % 5]
    here, middle = ring[y % 5], smooth[NARROW]
    p, q, u, v = smooth[NARROW + 1], smooth[NARROW + 2], derivative[NARROW + 1], derivative[NARROW + 2]
    for x in range(columns):
        inner[x] = middle * here[x] + p * (a[x] + d[x]) + q * (b[x] + e[x])
        inner_derived[x] = u * (a[x] - d[x]) + v * (b[x] - e[x])


@kernel(inline="always")
def _correlate_narrow_row(
    smoothed: Field, derived: Field, smooth: Field, derivative: Field, gx: Field, gy: Field, magnitude: Field
) -> None:
    """`_correlate_row` with kernels of radius NARROW, and the gradient's length."""
    columns = len(gx)
    middle = smooth[NARROW]
    p, q, u, v = smooth[NARROW + 1], smooth[NARROW + 2], derivative[NARROW + 1], derivative[NARROW + 2]
    for x in range(columns):
        dx = u * (smoothed[x + 3] - smoothed[x + 1]) + v * (smoothed[x + 4] - smoothed[x])
        dy = (
            middle * derived[x + 2]
            + p * (derived[x + 3] + derived[x + 1])
            + q * (derived[x + 4] + derived[x])
        )
        gx[x], gy[x] = dx, dy
        magnitude[x] = np.sqrt(dx * dx + dy * dy)


@kernel(inline="always")
def _correlate_row(
    smoothed: Field, derived: Field, smooth: Field, derivative: Field, gx: Field, gy: Field
) -> None:
    """The other kernel along the row: the gradient."""
    columns = len(gx)
    radius = len(smooth) // 2
    middle = smooth[radius]
    for t in range(1, radius + 1, TAPS):
        i, j = radius + t, radius - t
        # slices, so that no index can be negative: only then do the loops fill vector registers
        a, b, c = smoothed[i:], smoothed[i + 1 :], smoothed[i + 2 :]
        d, e, f = smoothed[j:], smoothed[j - 1 :], smoothed[j - 2 :]
        u, v, w = derivative[i], derivative[i + 1], derivative[i + 2]
        if t == 1:
            for x in range(columns):
                gx[x] = u * (a[x] - d[x]) + v * (b[x] - e[x]) + w * (c[x] - f[x])
        else:
            for x in range(columns):
                gx[x] += u * (a[x] - d[x]) + v * (b[x] - e[x]) + w * (c[x] - f[x])
        here, a, b, c = derived[radius:], derived[i:], derived[i + 1 :], derived[i + 2 :]
        d, e, f = derived[j:], derived[j - 1 :], derived[j - 2 :]
        p, q, r = smooth[i], smooth[i + 1], smooth[i + 2]
        if t == 1:
            for x in range(columns):
                gy[x] = middle * here[x] + p * (a[x] + d[x]) + q * (b[x] + e[x]) + r * (c[x] + f[x])
        else:
            for x in range(columns):
                gy[x] += p * (a[x] + d[x]) + q * (b[x] + e[x]) + r * (c[x] + f[x])


@kernel(inline="always")
def _gradient_of_row(
    ring: Field, y: int, smooth: Field, derivative: Field, smoothed: Field, derived: Field,
    gx: Field, gy: Field, magnitude: Field,
) -> None:  # fmt: skip
    """Gradient of row ``y`` of the ring, and its length; ``smoothed`` and ``derived`` are room to work in."""
    radius, columns = len(ring) // 2, len(gx)
    if radius == NARROW:
        _correlate_narrow_columns(ring, y, smooth, derivative, smoothed, derived)
    else:
        _correlate_columns(ring, y, smooth, derivative, smoothed, derived)
    for t in range(radius):  # replicated ends
        smoothed[t], smoothed[radius + columns + t] = smoothed[radius], smoothed[radius + columns - 1]
        derived[t], derived[radius + columns + t] = derived[radius], derived[radius + columns - 1]
    if radius == NARROW:
        _correlate_narrow_row(smoothed, derived, smooth, derivative, gx, gy, magnitude)
    else:
        _correlate_row(smoothed, derived, smooth, derivative, gx, gy)
        for x in range(columns):
            magnitude[x] = np.sqrt(gx[x] * gx[x] + gy[x] * gy[x])


@kernel(inline="always")
def _list_row(
    y: int,
    magnitude: Field,
    gx: Field,
    gy: Field,
    level: Grey,
    floor_of: Field,
    lowest: np.float32,
    kept: NDArray[np.bool_],
    chosen: Places,
    places: Places,
    values: Field,
    found: int,
) -> int:
    """Append the pixels of row ``y`` above the floor; how many there are.

    ``magnitude`` is a ring of three rows, ``level`` that of two columns each.
    """
    columns = len(gx)
    last = len(level) - 1
    above, here, below = magnitude[(y - 1) % 3], magnitude[y % 3], magnitude[(y + 1) % 3]
    ring = magnitude.ravel()
    above_at, here_at, below_at = (y - 1) % 3 * columns, y % 3 * columns, (y + 1) % 3 * columns
    ratio = np.float32(FLANK_RATIO)
    for x in range(columns):  # fills vector registers
        kept[x] = here[x] > lowest
    kept[0] = kept[columns - 1] = False
    candidates, count = set_places(kept, chosen), 0
    for i in range(candidates):  # no branches: they would be guesses
        x = chosen[i]
        beside, stacked = max(here[x - 1], here[x + 1]), max(above[x], below[x])
        chosen[count] = x
        count += here[x] >= ratio * (beside if abs(gx[x]) > abs(gy[x]) else stacked)
    for i in range(count):
        x = chosen[i]
        m, dx, dy = here[x], gx[x], gy[x]
        a, b = abs(dx), abs(dy)
        u = 1 if dx > np.float32(0.0) else -1
        front = below_at if dy > np.float32(0.0) else above_at
        back = above_at if dy > np.float32(0.0) else below_at
        steep = b > a
        t = min(a, b) / max(a, b)
        ahead, behind = (
            ring[front + x if steep else here_at + x + u],
            ring[back + x if steep else here_at + x - u],
        )
        ahead += t * (ring[front + x + u] - ahead)
        behind += t * (ring[back + x - u] - behind)
        difference = (ahead - behind) / m
        places[found] = y * columns + x
        values[0, found] = m
        values[1, found] = axis_of(dx, dy)
        values[2, found] = ahead + behind
        values[3, found] = difference * dx
        values[4, found] = difference * dy
        found += (m > floor_of[level[min(x >> 1, last)]]) & (m >= ratio * max(ahead, behind))
    return found


@kernel(inline="always")
def _fill(ring: Field, y: int, image: Grey, table: Field, linear: bool) -> None:
    """Row ``y`` of the image, or the nearest there is, into its place in the ring."""
    source, target = image[min(max(y, 0), len(image) - 1)], ring[y % len(ring)]
    if linear:  # the table says each grey is itself, as it does for images without a tone curve
        for x in range(len(target)):
            target[x] = np.float32(source[x])
    else:
        for x in range(len(target)):
            target[x] = table[source[x]]


@kernel(nogil=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz"})
def _sample(
    image: Grey, table: Field, linear: bool, smooth: Field, derivative: Field, samples: Field
) -> None:
    """Gradient magnitude of each 16th row."""
    columns = image.shape[1]
    count = len(smooth)
    radius = count // 2
    ring = np.empty((count, columns), np.float32)
    smoothed, derived = np.empty(columns + 2 * radius, np.float32), np.empty(columns + 2 * radius, np.float32)
    gx, gy = np.empty(columns, np.float32), np.empty(columns, np.float32)
    for i in range(len(samples)):
        y = SAMPLED_ROW_STEP // 2 + i * SAMPLED_ROW_STEP
        for v in range(y - radius, y + radius + 1):
            _fill(ring, v, image, table, linear)
        _gradient_of_row(ring, y, smooth, derivative, smoothed, derived, gx, gy, samples[i])


@kernel(nogil=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz"})
def _pass(
    image: Grey,
    table: Field,
    linear: bool,
    smooth: Field,
    derivative: Field,
    level: Grey,
    floor_of: Field,
    first: int,
    end: int,
    places: Places,
    values: Field,
) -> int:
    """Rows from ``first`` up to ``end``, neither of them an outermost one; how many pixels were found."""
    columns = image.shape[1]
    count = len(smooth)
    radius = count // 2
    ring = np.empty((count, columns), np.float32)
    smoothed, derived = np.empty(columns + 2 * radius, np.float32), np.empty(columns + 2 * radius, np.float32)
    gx, gy = np.empty((2, columns), np.float32), np.empty((2, columns), np.float32)
    magnitude = np.empty((3, columns), np.float32)
    kept = np.zeros(-(-columns // 8) * 8, np.bool_)
    chosen = np.empty(len(kept), np.int32)
    lowest = floor_of.min()
    for y in range(first - 1 - radius, first - 1 + radius):
        _fill(ring, y, image, table, linear)
    found = 0
    for y in range(first - 1, end + 1):
        _fill(ring, y + radius, image, table, linear)
        _gradient_of_row(
            ring, y, smooth, derivative, smoothed, derived, gx[y & 1], gy[y & 1], magnitude[y % 3]
        )
        if y <= first:
            continue
        found = _list_row(
            y - 1,
            magnitude,
            gx[(y - 1) & 1],
            gy[(y - 1) & 1],
            level[min((y - 1) >> 1, len(level) - 1)],
            floor_of,
            lowest,
            kept,
            chosen,
            places,
            values,
            found,
        )
    return found


def _fitted(smooth: Field, derivative: Field) -> tuple[Field, Field]:
    """The kernels without negligible ends, or with zeros there: of radius NARROW or a multiple of TAPS."""
    cut = len(smooth) // 2 - NARROW
    if cut > 0 and all(
        kernel[:cut].max() <= NEGLIGIBLE * kernel.max() for kernel in (smooth, abs(derivative))
    ):
        return smooth[cut:-cut].copy(), derivative[cut:-cut].copy()
    more = 0 if cut == 0 else -(len(smooth) // 2) % TAPS
    return np.pad(smooth, more), np.pad(derivative, more)


class GradientFilter:
    """The gradient of one image.

    Parameters
    ----------
    image
        uint8 (H, W).
    table
        float32 (256,), the intensity whose gradient is taken, for each grey.
    kernels
        float32 (2 R + 1,) each, the correlation kernels across and along the derivative; symmetric and
        antisymmetric.
    """

    def __init__(self, image: Grey, table: Field, kernels: tuple[Field, Field]) -> None:
        smooth, derivative = _fitted(*kernels)
        self._image = image
        self._arguments = (image, table, bool(np.array_equal(table, LEVELS)), smooth, derivative)

    def noise_factor(self, noise_of: Field) -> float:
        """By so much the noise of flat parts exceeds ``noise_of``, see `smooth_noise_factor`.

        ``noise_of``: float32 (256,), standard deviation of the gradient from white noise of the measured
        size, for each grey.
        """
        sampled = self._image[SAMPLED_ROW_STEP // 2 :: SAMPLED_ROW_STEP]
        samples = np.empty(sampled.shape, np.float32)
        _sample(*self._arguments, samples)
        return smooth_noise_factor(samples, sampled, noise_of)

    def pixels(self, level: Grey, floor_of: Field, first: int, end: int) -> tuple[Places, Field]:
        """Places (N,) and values (5, N) of the pixels above the floor in rows ``first`` up to ``end``.

        The outermost row or column of the image is not among them.

        Parameters
        ----------
        level
            uint8 (H // 2, W // 2), grey by which the floor is looked up.
        floor_of
            float32 (256,), the floor for each grey.
        first, end
            The rows.
        """
        first, end = max(first, 1), min(end, len(self._image) - 1)
        room = max(end - first, 0) * self._image.shape[1]
        places, values = np.empty(room, np.int32), np.empty((VALUES, room), np.float32)
        found = _pass(*self._arguments, level, floor_of, first, end, places, values) if room > 0 else 0
        return places[:found], values[:, :found]


def joined(parts: Sequence[tuple[Places, Field]]) -> GradientPixels:
    """The pixels of successive rows, from `GradientFilter.pixels`."""
    places = np.concatenate([places for places, _ in parts])
    return GradientPixels(places, *np.concatenate([values for _, values in parts], axis=1))
