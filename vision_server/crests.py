"""The merge itself: which pixels lie on a crest of the merged contrast, and what the mixture says of them.

The weights of the channels change from pixel to pixel, most of all across an edge whose sides different
lights reach, and would pull the crest of the merged mass to one side. So each pixel is judged by the
contrasts to either side that its own weights give; their sums are part of the state. The even part is a
number, the odd part a vector along the gradient, so that they add up whichever way an axis is read."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vision_server.axis import axis_of
from vision_server.mixture import BINS, EM_ITERATIONS, bin_directions, densities, fit_mixtures

Field = NDArray[np.float32]
Places = NDArray[np.int32]

FLOOR_RATIO = 3.0  # mass under so many standard deviations of its noise is none
CANDIDATE_RATIO = 0.55  # under this share of the largest mass in the 6 x 6 px around a pixel is no ridge
SLACK = 0.9  # so close to a crest a pixel still enters the mixture
BATCH = 32  # pixels whose mixtures are fitted side by side
MOST_OFFSET_PX = 0.7  # from a ridge pixel to the ridge: half a diagonal
MASS, FLANKS, FLANK_X, FLANK_Y = range(4)  # columns of the sums


@njit(inline="always")
def _log_ratio(a: np.float32, b: np.float32) -> np.float32:
    """Logarithm of a / b by the series of atanh: within 1 % for ratios up to 3, b may be 0."""
    r = (a - b) / (a + b)
    z = r * r
    return np.float32(2.0) * r * (np.float32(1.0) + z * (np.float32(1.0 / 3.0) + np.float32(0.2) * z))


@njit(cache=True, nogil=True, error_model="numpy")
def _candidates(
    sums: Field, place_of: Places, columns: int, weights: Field, noises: Field, mass: Field, share_of: Field,
    chosen: Places,
) -> int:  # fmt: skip
    """Pixels that may be on a crest; how many there are. Mass of each pixel, and one over its weight.

    The flanks' difference is taken whole, whatever its direction: more than it is along the axis that the
    mixture will find, but hardly so near a crest.
    """
    rows_of, columns_of = weights.shape
    last_row, last_column = rows_of - 1, columns_of - 1
    largest = np.zeros((rows_of + 2, columns_of + 2), np.float32)  # in each 2 x 2 px, with a border
    for i in range(len(place_of)):
        y = place_of[i] // columns
        x = place_of[i] - y * columns
        v, u = min(y >> 1, last_row), min(x >> 1, last_column)
        inverse = np.float32(1.0) / weights[v, u]
        m = sums[i, MASS] * inverse
        share_of[i] = inverse
        mass[i] = m
        largest[v + 1, u + 1] = max(largest[v + 1, u + 1], m)
    half_slack, ratio, share = np.float32(0.5 * SLACK), np.float32(FLOOR_RATIO), np.float32(CANDIDATE_RATIO)
    found = 0
    for i in range(len(place_of)):
        flank = sums[i, FLANKS] + np.sqrt(
            sums[i, FLANK_X] * sums[i, FLANK_X] + sums[i, FLANK_Y] * sums[i, FLANK_Y]
        )
        if sums[i, MASS] < half_slack * flank:
            continue
        y = place_of[i] // columns
        x = place_of[i] - y * columns
        v, u = min(y >> 1, last_row), min(x >> 1, last_column)
        around = np.float32(0.0)
        for row in range(v, v + 3):
            around = max(around, largest[row, u], largest[row, u + 1], largest[row, u + 2])
        if mass[i] > ratio * noises[v, u] * share_of[i] and mass[i] >= share * around:
            chosen[found] = i
            found += 1
    return found


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz"})
def _edgels(
    histograms: Field, sums: Field, place_of: Places, index: NDArray[np.int32], weights: Field, noises: Field,
    directions: Field, model: Field, mass: Field, share_of: Field, chosen: Places, out: Field,
) -> int:  # fmt: skip
    """The ridge among the candidates; ``chosen`` becomes their places. How many there are."""
    columns = index.shape[1]
    last_row, last_column = weights.shape[0] - 1, weights.shape[1] - 1
    half = np.float32(0.5)
    window, windows = np.empty(BINS, np.float32), np.ones((BINS, BATCH), np.float32)
    beside, room = np.empty_like(windows), np.empty((4, BATCH), np.float32)
    fitted = np.empty((3, BATCH), np.float32)
    batch = np.empty(BATCH, np.int64)
    found, waiting, last = 0, 0, len(chosen) - 1
    for number in range(len(chosen)):
        i = chosen[number]
        y = place_of[i] // columns
        x = place_of[i] - y * columns
        window[:] = np.float32(0.0)
        for v in range(y - 1, y + 2):
            for u in range(x - 1, x + 2):
                at = index[v, u]
                if at >= 0:
                    scale = share_of[at]
                    for k in range(BINS):
                        window[k] += scale * histograms[at, k]
        for k in range(BINS):
            windows[k, waiting] = window[k]
        batch[waiting] = i
        waiting += 1
        if waiting < BATCH and number < last:
            continue
        fit_mixtures(windows, directions, model, EM_ITERATIONS, beside, fitted, room)
        for j in range(waiting):
            i = batch[j]
            c = np.sqrt(max(half + half * fitted[1, j], np.float32(0.0)))
            s = np.sqrt(max(half - half * fitted[1, j], np.float32(0.0)))
            if fitted[2, j] < np.float32(0.0):
                c = -c
            odd = sums[i, FLANK_X] * c + sums[i, FLANK_Y] * s
            here, ahead, behind = (
                sums[i, MASS],
                half * (sums[i, FLANKS] + odd),
                half * (sums[i, FLANKS] - odd),
            )
            if here < ahead or here <= behind:
                continue
            fall_ahead, fall_behind = _log_ratio(here, ahead), _log_ratio(here, behind)
            curvature = (fall_ahead + fall_behind) * max(abs(c), abs(s))
            place = half * (fall_behind - fall_ahead) / max(curvature, np.float32(1e-6))
            at = place_of[i]
            chosen[found] = at
            out[0, found] = fitted[0, j] * mass[i]
            out[1, found] = mass[i]
            out[2, found] = axis_of(c, s)
            out[3, found] = min(max(place, np.float32(-MOST_OFFSET_PX)), np.float32(MOST_OFFSET_PX))
            v, u = at // columns, at % columns
            out[4, found] = noises[min(v >> 1, last_row), min(u >> 1, last_column)] * share_of[i]
            found += 1
        waiting = 0
    return found


def find_crests(
    histograms: Field,
    sums: Field,
    place_of: Places,
    index: NDArray[np.int32],
    weights: Field,
    noises: Field,
) -> tuple[Places, Field, Field, Field, Field, Field]:
    """Edgels of an image set.

    Parameters
    ----------
    histograms
        float32 (N, 16), for each pixel with a gradient in some channel: weight times contrast by axial
        orientation.
    sums
        float32 (N, 4), weight times contrast; the same of the contrasts to either side, their sum and their
        difference, a vector.
    place_of
        int32 (N,), flat indices of these pixels.
    index
        int32 (H, W), number of the pixel's state, -1 for none.
    weights, noises
        float32 (H // 2, W // 2), for 2 x 2 px: sum of weights, sum of weight times noise.

    Returns
    -------
    Places (ascending), strength, mass, axis, offset and floor of the edgels, as in `EdgeMap`.
    """
    count, columns = len(place_of), index.shape[1]
    mass, share_of = np.empty((2, count), np.float32)
    chosen = np.empty(count, np.int32)
    found = _candidates(sums, place_of, columns, weights, noises, mass, share_of, chosen)
    chosen, out = chosen[:found], np.empty((5, found), np.float32)
    found = _edgels(
        histograms, sums, place_of, index, weights, noises, bin_directions(), densities(), mass, share_of,
        chosen, out,
    )  # fmt: skip
    order = np.argsort(chosen[:found])
    strength, mass, axis, offset, floor = (row[order] for row in out[:, :found])
    return chosen[order], strength, mass, axis, offset, floor
