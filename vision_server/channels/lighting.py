"""How lit one image is, and how noisy there: weight and noise for each 2 x 2 px, in one pass."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from numerics.kernels import kernel

Grey = NDArray[np.uint8]
Field = NDArray[np.float32]

SMOOTHING = (27, 202, 27)  # of 256: a Gaussian of 0.5 px of the halved image, against noise


@kernel(nogil=True)
def _smooth_row(half: Grey, y: int, column: Field, out: Grey) -> None:
    """Row ``y`` smoothed both ways, rounded once; the sums are whole numbers that float32 holds."""
    columns = half.shape[1]
    above, here, below = half[max(y - 1, 0)], half[y], half[min(y + 1, len(half) - 1)]
    side, middle = np.float32(SMOOTHING[0]), np.float32(SMOOTHING[1])
    inner = column[1 : columns + 1]
    for x in range(columns):
        inner[x] = side * (np.float32(above[x]) + np.float32(below[x])) + middle * np.float32(here[x])
    column[0], column[columns + 1] = column[1], column[columns]
    before, after = column, column[2:]
    scale, half_step = np.float32(1.0 / 65536.0), np.float32(32768.0)
    for x in range(columns):
        total = side * (before[x] + after[x]) + middle * inner[x]
        out[x] = np.uint8((total + half_step) * scale)


@kernel(nogil=True)
def light_rows(
    half: Grey, reach: int, root: Field, noise_of: Field, clipped_grey: int, clipped_factor: np.float32,
    first: int, end: int, level: Grey, weight: Field, noise: Field, clear: NDArray[np.bool_],
) -> None:  # fmt: skip
    """Weight and noise of rows ``first`` up to ``end``.

    Parameters
    ----------
    half
        uint8 (H, W), the image halved.
    reach
        How far the darkest and the brightest grey are taken from, Chebyshev, px of ``half``.
    root, noise_of
        float32 (256,), root of the weight of each grey, and its noise.
    clipped_grey, clipped_factor
        From this grey on a pixel is clipped; by so much it and those within reach count less.
    first, end
        The rows; other rows may be computed elsewhere at the same time.
    level, weight, noise, clear
        uint8, float32, float32, bool, (H, W), output: ``half`` smoothed (also of rows within reach); root of
        the weight of the darkest times that of the brightest; noise; False within reach of a clipped pixel.
    """
    rows, columns = half.shape
    column = np.empty(columns + 2, np.float32)
    for y in range(max(first - reach, 0), min(end + reach, rows)):
        _smooth_row(half, y, column, level[y])
    low, high = np.empty(columns + 2 * reach, np.uint8), np.empty(columns + 2 * reach, np.uint8)
    inner_low, inner_high = low[reach : reach + columns], high[reach : reach + columns]
    darkest, brightest = np.empty(columns, np.uint8), np.empty(columns, np.uint8)
    for y in range(first, end):
        for x in range(columns):
            inner_low[x] = inner_high[x] = level[y, x]
        for v in range(max(y - reach, 0), min(y + reach + 1, rows)):
            for x in range(columns):
                inner_low[x] = min(inner_low[x], level[v, x])
            for x in range(columns):
                inner_high[x] = max(inner_high[x], level[v, x])
        for u in range(reach):
            low[u], low[reach + columns + u] = inner_low[0], inner_low[columns - 1]
            high[u], high[reach + columns + u] = inner_high[0], inner_high[columns - 1]
        for x in range(columns):
            darkest[x] = low[x]
            brightest[x] = high[x]
        for u in range(1, 2 * reach + 1):
            other_low, other_high = low[u:], high[u:]
            for x in range(columns):
                darkest[x] = min(darkest[x], other_low[x])
            for x in range(columns):
                brightest[x] = max(brightest[x], other_high[x])
        greys, weights, noises, clears = level[y], weight[y], noise[y], clear[y]
        for x in range(columns):
            w = root[darkest[x]] * root[brightest[x]]
            unclipped = brightest[x] < clipped_grey
            clears[x] = unclipped
            weights[x] = w if unclipped else w * clipped_factor
            noises[x] = noise_of[greys[x]]
