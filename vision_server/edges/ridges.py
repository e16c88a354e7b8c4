"""Ridges of the merged contrast: non-maximum suppression with each pixel's own weights, and its mixture.

A pixel of the merged edge map is an edgel when its contrast is a maximum across the edge. The weights of the
channels change from pixel to pixel, most of all across an edge whose sides different lights reach, and would
pull the maximum to one side. So each pixel is compared with the contrasts to either side (its *flanks*) that
its own weights give; their sums are part of the set's state. The even part of the two is a number, the odd
part a vector along the gradient, so that they add up whichever way an axis is read. With one channel this is
`suppression.suppress_non_maxima`.
"""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from numerics.arrays import Field
from numerics.axis import axis_of
from numerics.kernels import kernel
from numerics.marks import list_marks, no_marks
from numerics.two_cores import both
from vision_server.edges.mixture import BINS, fit_mixtures

Places = NDArray[np.int32]

# Chosen by hand; `python -m benchmarks.edge_quality` shows what they do.
FLOOR_RATIO = 3.0  # mass under so many standard deviations of its noise is none
CANDIDATE_RATIO = np.float32(0.55)  # under this share of the largest mass within 6 x 6 px nothing is a ridge
SLACK = np.float32(0.9)  # of the mean of its flanks: a mass from there on enters the mixture
BATCH = 32  # pixels whose mixtures are fitted side by side: four vector registers of eight
MOST_OFFSET_PX = np.float32(0.7)  # from a ridge's pixel to the ridge: half a diagonal
MASS, FLANKS, FLANK_X, FLANK_Y = range(4)  # columns of the sums
STRENGTH, EDGEL_MASS, AXIS, OFFSET, FLOOR = range(5)  # rows of what is known of an edgel


class SetState(NamedTuple):
    """What a set of channels adds up to; kept only for the pixels where some channel has a gradient.

    Attributes
    ----------
    numbers
        int32 (H, W), number of the pixel's state, -1 for none, as for all of the outermost pixels.
    histograms
        float32 (N, 16), weight times contrast by axial orientation.
    sums
        float32 (N, 4), weight times contrast; the same of the flanks: their sum, and their difference, which
        is a vector.
    weights, noises
        float32 (H // 2, W // 2), for 2 x 2 px: sum of weights, sum of weight times noise.
    """

    numbers: NDArray[np.int32]
    histograms: Field
    sums: Field
    weights: Field
    noises: Field


class Pixels(NamedTuple):
    """Pixels in raster order: places, numbers of their states, masses; (M,) each."""

    places: Places
    states: Places
    masses: Field


@kernel(inline="always")
def _coarse(at: int, end: int) -> int:
    """Row or column of the 2 x 2 px that hold a pixel; the last of an odd size belongs to those before it."""
    return min(at >> 1, end - 1)


@kernel()
def _pixels(state: SetState, inverse: Field, first: int, end: int) -> Pixels:
    """The pixels of rows ``first`` up to ``end`` that have a state."""
    numbers, sums = state.numbers, state.sums
    rows, columns = inverse.shape
    places, states = np.empty(len(sums), np.int32), np.empty(len(sums), np.int32)
    masses = np.empty(len(sums), np.float32)
    found, width = 0, numbers.shape[1]
    marks = no_marks(width)
    for y in range(first, end):
        v, of_row = _coarse(y, rows), numbers[y]
        for x in range(width):
            marks.marked[x] = of_row[x] >= 0
        for x in marks.numbers[: list_marks(marks)]:
            i = of_row[x]
            places[found], states[found] = y * width + x, i
            masses[found] = sums[i, MASS] * inverse[v, _coarse(x, columns)]
            found += 1
    return Pixels(places[:found], states[:found], masses[:found])


@kernel()
def _largest_masses(pixels: Pixels, width: int, coarse: tuple[int, int], first: int, end: int) -> Field:
    """Largest mass in each 2 x 2 px of the coarse rows ``first`` up to ``end``, of which the pixels are.

    The image is ``width`` px wide and has ``coarse`` rows and columns of 2 x 2 px.
    """
    rows, columns = coarse
    largest = np.zeros((end - first, columns), np.float32)
    y = 2 * first
    for i in range(len(pixels.places)):
        while pixels.places[i] >= (y + 1) * width:
            y += 1
        v, u = _coarse(y, rows) - first, _coarse(pixels.places[i] - y * width, columns)
        largest[v, u] = max(largest[v, u], pixels.masses[i])
    return largest


@kernel()
def _candidates(
    pixels: Pixels, state: SetState, least: Field, largest: Field, above: int, first: int, end: int
) -> Pixels:
    """Those in the rows ``first`` up to ``end`` with enough mass, hardly less than the mean of their flanks.

    The flanks' difference is taken whole, whatever its direction: more than it is along the axis that the
    mixture will find, but hardly so near a ridge. ``least``: what is no mass, for 2 x 2 px; ``largest``: that
    within 6 x 6 px, for those from the row ``above`` on.
    """
    sums, width = state.sums, state.numbers.shape[1]
    rows, columns = least.shape
    half = np.float32(0.5)
    begin, stop = np.searchsorted(pixels.places, first * width), np.searchsorted(pixels.places, end * width)
    chosen = np.empty(stop - begin, np.int32)
    found, y = 0, first
    for k in range(begin, stop):
        while pixels.places[k] >= (y + 1) * width:
            y += 1
        i, mass = pixels.states[k], pixels.masses[k]
        odd = np.sqrt(sums[i, FLANK_X] * sums[i, FLANK_X] + sums[i, FLANK_Y] * sums[i, FLANK_Y])
        v, u = _coarse(y, rows), _coarse(pixels.places[k] - y * width, columns)
        enough = (mass >= CANDIDATE_RATIO * largest[v - above, u]) & (mass >= least[v, u])
        chosen[found] = k
        found += enough & (sums[i, MASS] >= half * SLACK * (sums[i, FLANKS] + odd))
    chosen = chosen[:found]
    return Pixels(pixels.places[chosen], pixels.states[chosen], pixels.masses[chosen])


@kernel(inline="always")
def _gather(state: SetState, inverse: Field, place: int, histogram: Field) -> None:
    """Orientations in the 3 x 3 px around a place, each pixel's normalised by its own weights."""
    rows, columns = inverse.shape
    y = place // state.numbers.shape[1]
    x = place - y * state.numbers.shape[1]
    histogram[:] = np.float32(0.0)
    for v in range(y - 1, y + 2):
        for u in range(x - 1, x + 2):
            at = state.numbers[v, u]
            if at >= 0:
                scale = inverse[_coarse(v, rows), _coarse(u, columns)]
                for k in range(BINS):
                    histogram[k] += scale * state.histograms[at, k]


@kernel(inline="always")
def _log_ratio(a: np.float32, b: np.float32) -> np.float32:
    """Logarithm of a / b by the series of atanh: within 1 % for ratios up to 3, b may be 0."""
    r = (a - b) / (a + b)
    z = r * r
    return np.float32(2.0) * r * (np.float32(1.0) + z * (np.float32(1.0 / 3.0) + np.float32(0.2) * z))


@kernel(inline="always")
def _across(sums: Field, c: np.float32, s: np.float32) -> tuple[bool, np.float32]:
    """Whether a pixel's mass is the maximum along a unit vector, and how far along it the ridge is, px.

    A parabola through the logarithms of the mass and its flanks: exact for a Gaussian ridge.
    """
    half = np.float32(0.5)
    odd = sums[FLANK_X] * c + sums[FLANK_Y] * s
    here, ahead, behind = sums[MASS], half * (sums[FLANKS] + odd), half * (sums[FLANKS] - odd)
    fall_ahead, fall_behind = _log_ratio(here, ahead), _log_ratio(here, behind)
    curvature = (fall_ahead + fall_behind) * max(abs(c), abs(s))
    offset = half * (fall_behind - fall_ahead) / max(curvature, np.float32(1e-6))
    return here >= ahead and here > behind, min(max(offset, -MOST_OFFSET_PX), MOST_OFFSET_PX)


@kernel(fastmath={"reassoc", "contract", "nsz"})
def _edgels(state: SetState, inverse: Field, floor: Field, candidates: Pixels) -> tuple[Places, Field]:
    """The candidates that are maxima across the axis of their mixture: places, and what is known of them."""
    places, states, masses = candidates
    rows, columns = inverse.shape
    kept, edgels = np.empty_like(places), np.empty((5, len(places)), np.float32)
    half, zero = np.float32(0.5), np.float32(0.0)
    window, windows = np.empty(BINS, np.float32), np.ones((BINS, BATCH), np.float32)
    fitted, background = np.empty((3, BATCH), np.float32), np.empty_like(windows)
    room = np.empty((4, BATCH), np.float32)
    found = 0
    for begin in range(0, len(places), BATCH):
        end = min(begin + BATCH, len(places))
        for j in range(end - begin):
            _gather(state, inverse, places[begin + j], window)
            for k in range(BINS):
                windows[k, j] = window[k]
        fit_mixtures(windows, fitted, background, room)
        for j in range(end - begin):
            c = np.sqrt(max(half + half * fitted[1, j], zero))  # half the doubled angle
            s = np.sqrt(max(half - half * fitted[1, j], zero))
            c = -c if fitted[2, j] < zero else c
            is_ridge, offset = _across(state.sums[states[begin + j]], c, s)
            if is_ridge:
                place, mass = places[begin + j], masses[begin + j]
                y = place // state.numbers.shape[1]
                x = place - y * state.numbers.shape[1]
                kept[found] = place
                edgels[STRENGTH, found] = fitted[0, j] * mass
                edgels[EDGEL_MASS, found] = mass
                edgels[AXIS, found] = axis_of(c, s)
                edgels[OFFSET, found] = offset
                edgels[FLOOR, found] = floor[_coarse(y, rows), _coarse(x, columns)]
                found += 1
    return kept[:found], edgels[:, :found]


def find_ridges(state: SetState, floor_ratio: float = FLOOR_RATIO) -> tuple[Places, Field]:
    """Edgels of an image set.

    Parameters
    ----------
    state
        Of the set.
    floor_ratio
        Mass under so many standard deviations of its noise is none.

    Returns
    -------
    Their places, int32 (M,), ascending; and float32 (5, M): strength, mass, axis, offset and floor, as in
    `EdgeMap`.
    """
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):  # no weight where nothing is
        inverse = np.float32(1.0) / state.weights
        floor = state.noises * inverse
        least = np.float32(floor_ratio) * floor
    rows, coarse_rows = len(state.numbers), len(inverse)

    def of_rows(first: int, end: int) -> tuple[Places, Field]:
        """The first one is even; the end too, unless it is that of the image."""
        top, bottom = first >> 1, coarse_rows if end == rows else end >> 1
        above, below = max(top - 1, 0), min(bottom + 1, coarse_rows)
        pixels = _pixels(state, inverse, 2 * above, rows if below == coarse_rows else 2 * below)
        largest = _largest_masses(pixels, state.numbers.shape[1], inverse.shape, above, below)
        largest = np.asarray(cv2.dilate(largest, np.ones((3, 3), np.uint8)), np.float32)
        candidates = _candidates(pixels, state, least, largest, above, first, end)
        return _edgels(state, inverse, floor, candidates)

    middle = rows // 4 * 2
    lower, upper = both(lambda: of_rows(middle, rows), lambda: of_rows(0, middle))
    return np.concatenate([upper[0], lower[0]]), np.concatenate([upper[1], lower[1]], axis=1)
