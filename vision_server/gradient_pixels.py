"""Pixels of one image whose gradient stands out of the noise: one pass, no image in between.

The separable Gaussian derivative runs row by row over a ring of rows that stays in the processor's cache.
Where the magnitude exceeds the noise floor the pixel is listed, with its axis and the magnitude one step to
either side along its gradient; everything after this pass works on the list."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vision_server.axis import axis_of
from vision_server.noise import smooth_noise_factor

Grey = NDArray[np.uint8]
Field = NDArray[np.float32]
Places = NDArray[np.int32]

SAMPLED_ROW_STEP = 16  # rows whose magnitudes are sampled, for the noise in flat parts
FLANK_RATIO = 0.65  # under this share of what is a step along its gradient a pixel lies on an edge's foot
TAPS = 3  # of a kernel's arm that are summed at once, in registers
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


@njit(inline="always")
def _correlate_columns(
    ring: Field, y: int, smooth: Field, derivative: Field, smoothed: Field, derived: Field
) -> None:
    """Both kernels down the columns around row ``y`` of the ring, with replicated ends for the next pass."""
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
    for t in range(radius):
        smoothed[t], smoothed[radius + columns + t] = inner[0], inner[columns - 1]
        derived[t], derived[radius + columns + t] = inner_derived[0], inner_derived[columns - 1]


@njit(inline="always")
def _correlate_row(
    smoothed: Field, derived: Field, smooth: Field, derivative: Field, gx: Field, gy: Field, magnitude: Field
) -> None:
    """The other kernel along the row: the gradient and its length."""
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
    for x in range(columns):
        magnitude[x] = np.sqrt(gx[x] * gx[x] + gy[x] * gy[x])


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "nsz"})
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
    left, middle, right, up, down = here[:-2], here[1:-1], here[2:], above[1:-1], below[1:-1]
    along_x, along_y = gx[1:-1], gy[1:-1]
    for x in range(columns - 2):  # no branches: fills vector registers
        beside, stacked = max(left[x], right[x]), max(up[x], down[x])
        across = beside if abs(along_x[x]) > abs(along_y[x]) else stacked
        kept[x] = (middle[x] > lowest) & (middle[x] >= ratio * across)
    words = kept.view(np.uint64)
    count = 0
    for word in range(len(words)):
        if words[word] != 0:
            for x in range(8 * word, 8 * word + 8):
                chosen[count] = x + 1
                count += kept[x]
    for i in range(count):  # no branches either: they would be guesses
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


@njit(inline="always")
def _fill(ring: Field, y: int, image: Grey, table: Field) -> None:
    """Row ``y`` of the image, or the nearest there is, into its place in the ring."""
    source, target = image[min(max(y, 0), len(image) - 1)], ring[y % len(ring)]
    for x in range(len(target)):
        target[x] = table[source[x]]


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz"})
def _sample(image: Grey, table: Field, smooth: Field, derivative: Field, samples: Field) -> None:
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
            _fill(ring, v, image, table)
        _correlate_columns(ring, y, smooth, derivative, smoothed, derived)
        _correlate_row(smoothed, derived, smooth, derivative, gx, gy, samples[i])


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz"})
def _pass(
    image: Grey,
    table: Field,
    smooth: Field,
    derivative: Field,
    level: Grey,
    floor_of: Field,
    places: Places,
    values: Field,
) -> int:
    """All rows; how many pixels were found."""
    rows, columns = image.shape
    count = len(smooth)
    radius = count // 2
    ring = np.empty((count, columns), np.float32)
    smoothed, derived = np.empty(columns + 2 * radius, np.float32), np.empty(columns + 2 * radius, np.float32)
    gx, gy = np.empty((2, columns), np.float32), np.empty((2, columns), np.float32)
    magnitude = np.empty((3, columns), np.float32)
    kept = np.zeros(-(-columns // 8) * 8, np.bool_)
    chosen = np.empty(len(kept), np.int32)
    lowest = floor_of.min()
    for y in range(-radius, radius):
        _fill(ring, y, image, table)
    found = 0
    for y in range(rows):
        _fill(ring, y + radius, image, table)
        _correlate_columns(ring, y, smooth, derivative, smoothed, derived)
        _correlate_row(smoothed, derived, smooth, derivative, gx[y & 1], gy[y & 1], magnitude[y % 3])
        if y < 2:
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


def _padded(kernel: Field) -> Field:
    """The kernel with zeros on both ends, so that its radius is a multiple of TAPS."""
    more = -(len(kernel) // 2) % TAPS
    padded = np.zeros(len(kernel) + 2 * more, np.float32)
    padded[more : more + len(kernel)] = kernel
    return padded


def find_gradient_pixels(
    image: Grey,
    table: Field,
    kernels: tuple[Field, Field],
    level: Grey,
    noise_of: Field,
    floor_ratio: float,
) -> tuple[GradientPixels, float]:
    """Pixels whose gradient exceeds so many standard deviations of its noise.

    Parameters
    ----------
    image
        uint8 (H, W).
    table
        float32 (256,), the intensity whose gradient is taken, for each grey.
    kernels
        float32 (2 R + 1,) each, the correlation kernels across and along the derivative; symmetric and
        antisymmetric.
    level
        uint8 (H // 2, W // 2), grey by which the noise is looked up.
    noise_of
        float32 (256,), standard deviation of the gradient from white noise of the measured size, for each
        grey.
    floor_ratio
        The floor in standard deviations.

    Returns
    -------
    pixels
        Those above the floor; the outermost row or column of the image is not among them.
    noise_factor
        By so much the noise of flat parts exceeds ``noise_of``, see `smooth_noise_factor`; the floor
        follows it.
    """
    smooth, derivative = _padded(kernels[0]), _padded(kernels[1])
    sampled = image[SAMPLED_ROW_STEP // 2 :: SAMPLED_ROW_STEP]
    samples = np.empty(sampled.shape, np.float32)
    _sample(image, table, smooth, derivative, samples)
    factor = smooth_noise_factor(samples, sampled, noise_of)
    floor_of = np.float32(floor_ratio * factor) * noise_of
    places, values = np.empty(image.size, np.int32), np.empty((VALUES, image.size), np.float32)
    found = _pass(image, table, smooth, derivative, level, floor_of, places, values)
    return GradientPixels(places[:found].copy(), *(row[:found].copy() for row in values)), factor
