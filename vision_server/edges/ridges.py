"""The merge itself: which pixels lie on a crest of the merged contrast, and what the mixture says of them.

The weights of the channels change from pixel to pixel, most of all across an edge whose sides different
lights reach, and would pull the crest of the merged mass to one side. So each pixel is judged by the
contrasts to either side that its own weights give; their sums are part of the state. The even part is a
number, the odd part a vector along the gradient, so that they add up whichever way an axis is read."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from numerics.axis import axis_of
from numerics.flags import set_places
from numerics.kernels import kernel
from numerics.two_cores import both
from vision_server.edges.mixture import BINS, EM_ITERATIONS, bin_directions, densities, fit_mixtures

Field = NDArray[np.float32]
Places = NDArray[np.int32]

FLOOR_RATIO = 3.0  # mass under so many standard deviations of its noise is none
CANDIDATE_RATIO = 0.55  # under this share of the largest mass in the 6 x 6 px around a pixel is no ridge
SLACK = 0.9  # so close to a crest a pixel still enters the mixture
BATCH = 32  # pixels whose mixtures are fitted side by side
MOST_OFFSET_PX = 0.7  # from a ridge pixel to the ridge: half a diagonal
MASS, FLANKS, FLANK_X, FLANK_Y = range(4)  # columns of the sums


@kernel(inline="always")
def _log_ratio(a: np.float32, b: np.float32) -> np.float32:
    """Logarithm of a / b by the series of atanh: within 1 % for ratios up to 3, b may be 0."""
    r = (a - b) / (a + b)
    z = r * r
    return np.float32(2.0) * r * (np.float32(1.0) + z * (np.float32(1.0 / 3.0) + np.float32(0.2) * z))


@kernel(nogil=True, error_model="numpy")
def _candidates(
    index: NDArray[np.int32], sums: Field, weights: Field, noises: Field, first: int, end: int
) -> tuple[Places, Places, Field, Field]:
    """Pixels of rows ``first`` (even) up to ``end`` that may be on a crest, in raster order.

    Their places, the numbers of their states, their masses; and one over the weight for each 2 x 2 px, as
    far as these and the pixels beside them need it.

    The flanks' difference is taken whole, whatever its direction: more than it is along the axis that the
    mixture will find, but hardly so near a crest.
    """
    rows, columns = index.shape
    rows_of, columns_of = weights.shape
    last_row, last_column = rows_of - 1, columns_of - 1
    lowest, highest = max((first >> 1) - 1, 0), min(((end - 1) >> 1) + 1, last_row)
    inverse = np.empty(weights.shape, np.float32)
    for v in range(lowest, highest + 1):
        for u in range(columns_of):
            inverse[v, u] = np.float32(1.0) / weights[v, u]
    shape = (highest - lowest + 3, columns_of + 2)  # of 2 x 2 px, with a border
    largest, beneath = np.zeros(shape, np.float32), np.empty(shape, np.float32)
    kept, chosen = np.zeros(-(-columns // 8) * 8, np.bool_), np.empty(columns + 8, np.int32)
    room = len(sums)
    places, states, masses = np.empty(room, np.int32), np.empty(room, np.int32), np.empty(room, np.float32)
    beside = np.zeros(rows + 1, np.int64)
    listed = 0
    stop = rows if highest == last_row else 2 * (highest + 1)
    for y in range(2 * lowest, stop):
        v = min(y >> 1, last_row)
        of = index[y]
        for x in range(columns):  # fills vector registers
            kept[x] = of[x] >= 0
        for j in range(set_places(kept, chosen)):
            x = chosen[j]
            i = of[x]
            u = min(x >> 1, last_column)
            m = sums[i, MASS] * inverse[v, u]
            largest[v - lowest + 1, u + 1] = max(largest[v - lowest + 1, u + 1], m)
            places[listed], states[listed], masses[listed] = x, i, m
            listed += 1
        beside[y + 1] = listed
    half_slack, ratio, share = np.float32(0.5 * SLACK), np.float32(FLOOR_RATIO), np.float32(CANDIDATE_RATIO)
    for v in range(1, shape[0] - 1):  # the largest of 3 x 3
        for u in range(shape[1]):
            beneath[v, u] = max(largest[v - 1, u], largest[v, u], largest[v + 1, u])
    for v in range(1, shape[0] - 1):
        for u in range(1, shape[1] - 1):
            largest[v, u] = max(beneath[v, u - 1], beneath[v, u], beneath[v, u + 1])
    found = 0
    for y in range(first, end):
        v = min(y >> 1, last_row)
        around = largest[v - lowest + 1]
        for j in range(beside[y], beside[y + 1]):
            x, i, m = places[j], states[j], masses[j]
            flank = sums[i, FLANKS] + np.sqrt(
                sums[i, FLANK_X] * sums[i, FLANK_X] + sums[i, FLANK_Y] * sums[i, FLANK_Y]
            )
            u = min(x >> 1, last_column)
            places[found], states[found], masses[found] = y * columns + x, i, m
            found += (
                (sums[i, MASS] >= half_slack * flank)
                & (m > ratio * noises[v, u] * inverse[v, u])
                & (m >= share * around[u + 1])
            )
    return places[:found], states[:found], masses[:found], inverse


@kernel(nogil=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz"})
def _edgels(
    index: NDArray[np.int32], histograms: Field, sums: Field, noises: Field, inverse: Field,
    directions: Field, model: Field, chosen: Places, states: Places, masses: Field, out: Field,
) -> int:  # fmt: skip
    """The ridge among the candidates; ``chosen`` becomes their places. How many there are."""
    columns = index.shape[1]
    last_row, last_column = noises.shape[0] - 1, noises.shape[1] - 1
    half = np.float32(0.5)
    window, windows = np.empty(BINS, np.float32), np.ones((BINS, BATCH), np.float32)
    beside, room = np.empty_like(windows), np.empty((4, BATCH), np.float32)
    fitted = np.empty((3, BATCH), np.float32)
    found, waiting, last = 0, 0, len(chosen) - 1
    for number in range(len(chosen)):
        y = chosen[number] // columns
        x = chosen[number] - y * columns
        window[:] = np.float32(0.0)
        for v in range(y - 1, y + 2):
            for u in range(x - 1, x + 2):
                at = index[v, u]
                if at >= 0:
                    scale = inverse[min(v >> 1, last_row), min(u >> 1, last_column)]
                    for k in range(BINS):
                        window[k] += scale * histograms[at, k]
        for k in range(BINS):
            windows[k, waiting] = window[k]
        waiting += 1
        if waiting < BATCH and number < last:
            continue
        fit_mixtures(windows, directions, model, EM_ITERATIONS, beside, fitted, room)
        for j in range(waiting):
            candidate = number + 1 - waiting + j
            i, at = states[candidate], chosen[candidate]
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
            v, u = at // columns, at % columns
            v, u = min(v >> 1, last_row), min(u >> 1, last_column)
            chosen[found] = at
            out[0, found] = fitted[0, j] * masses[candidate]
            out[1, found] = masses[candidate]
            out[2, found] = axis_of(c, s)
            out[3, found] = min(max(place, np.float32(-MOST_OFFSET_PX)), np.float32(MOST_OFFSET_PX))
            out[4, found] = noises[v, u] * inverse[v, u]
            found += 1
        waiting = 0
    return found


@cache
def _mixture() -> tuple[Field, Field]:
    """What `fit_mixtures` wants to know."""
    return bin_directions(), densities()


def find_crests(
    index: NDArray[np.int32], histograms: Field, sums: Field, weights: Field, noises: Field
) -> tuple[Places, Field, Field, Field, Field, Field]:
    """Edgels of an image set.

    Parameters
    ----------
    index
        int32 (H, W), number of the pixel's state, -1 for none, as for all of the outermost pixels.
    histograms
        float32 (N, 16), for each pixel with a gradient in some channel: weight times contrast by axial
        orientation.
    sums
        float32 (N, 4), weight times contrast; the same of the contrasts to either side, their sum and their
        difference, a vector.
    weights, noises
        float32 (H // 2, W // 2), for 2 x 2 px: sum of weights, sum of weight times noise.

    Returns
    -------
    Places (ascending), strength, mass, axis, offset and floor of the edgels, as in `EdgeMap`.
    """
    directions, model = _mixture()

    def crests(first: int, end: int) -> tuple[Places, Field]:
        chosen, states, masses, inverse = _candidates(index, sums, weights, noises, first, end)
        out = np.empty((5, len(chosen)), np.float32)
        found = _edgels(
            index, histograms, sums, noises, inverse, directions, model, chosen, states, masses, out
        )
        return chosen[:found], out[:, :found]

    middle = len(index) // 4 * 2
    halves = both(lambda: crests(middle, len(index)), lambda: crests(0, middle))[::-1]
    places = np.concatenate([half[0] for half in halves])
    strength, mass, axis, offset, floor = np.concatenate([half[1] for half in halves], axis=1)
    return places, strength, mass, axis, offset, floor
