"""The two-component mixture of orientations at each pixel, fitted by EM on a histogram."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

Field = NDArray[np.float32]

EM_ITERATIONS = 4
MAIN_SD_RAD = 0.25  # spread of the orientation along a true edge inside the window
BACKGROUND_SD_RAD = 1.0  # shadow edges and noise: nearly anything
MOST_SHARE = np.float32(0.999)  # a share of 1 would leave the background no way back
TABLE_STEPS = 1024  # of the Gaussian tables, over a difference of 0 to pi/2


def _gaussian_table(sd_rad: float) -> NDArray[np.float32]:
    """Density of a normal on the axial circle (its range is pi), at differences 0 .. pi/2."""
    difference = np.linspace(0.0, 0.5 * np.pi, TABLE_STEPS + 1)
    turns = np.arange(-2, 3)[:, None] * np.pi
    density = np.exp(-0.5 * ((difference + turns) / sd_rad) ** 2).sum(axis=0) / (
        np.sqrt(2.0 * np.pi) * sd_rad
    )
    return np.asarray(density, dtype=np.float32)


@njit(cache=True)
def _windows(
    bins: Field,
    weights: Field,
    mass: Field,
    least: Field,
    places: NDArray[np.int64],
    windows: Field,
    axes: Field,
) -> int:
    """Histogram of the 3 x 3 window and its mean axis where the mass is over ``least``; how many."""
    rows, columns, count = bins.shape
    cosine, sine = np.empty(count, np.float32), np.empty(count, np.float32)
    for k in range(count):
        cosine[k], sine[k] = np.cos(2.0 * k * np.pi / count), np.sin(2.0 * k * np.pi / count)
    found = 0
    for y in range(1, rows - 1):
        for x in range(1, columns - 1):
            if mass[y, x] <= least[y, x]:
                continue
            window = windows[found]
            window[:] = 0.0
            for v in range(y - 1, y + 2):
                for u in range(x - 1, x + 2):
                    if mass[v, u] > 0.0:
                        scale = np.float32(1.0) / weights[v, u]
                        for k in range(count):
                            window[k] += bins[v, u, k] * scale
            c, s = np.float32(0.0), np.float32(0.0)
            for k in range(count):
                c += window[k] * cosine[k]
                s += window[k] * sine[k]
            places[found] = y * columns + x
            axes[found] = np.float32(0.5) * np.arctan2(s, c)
            found += 1
    return found


@njit(cache=True)
def _fit(
    windows: Field, axes: Field, main_table: Field, background_table: Field, iterations: int, share_out: Field
) -> None:
    """EM on each histogram; ``axes`` goes in as the mean axis and comes out as that of the main component."""
    count = windows.shape[1]
    steps = len(main_table) - 1
    per_rad = np.float32(steps / (0.5 * np.pi))
    pi = np.float32(np.pi)
    cosine, sine = np.empty(count, np.float32), np.empty(count, np.float32)
    centre, background = np.empty(count, np.float32), np.empty(count, np.float32)
    held = np.empty(count, np.int64)
    for k in range(count):
        centre[k] = k * np.pi / count
        cosine[k], sine[k] = np.cos(2.0 * k * np.pi / count), np.sin(2.0 * k * np.pi / count)
    for i in range(len(windows)):
        window = windows[i]
        mean = axes[i]
        total, filled = np.float32(0.0), 0
        for k in range(count):
            if window[k] > 0.0:
                total += window[k]
                d = abs(centre[k] - mean)
                if d > pi:
                    d -= pi
                background[filled] = background_table[int(min(d, pi - d) * per_rad)]
                held[filled] = k
                filled += 1
        share = np.float32(0.5)
        for _ in range(iterations):
            main_mass, c, s = np.float32(0.0), np.float32(0.0), np.float32(0.0)
            for j in range(filled):
                k = held[j]
                d = abs(centre[k] - mean)
                if d > pi:
                    d -= pi
                p = share * main_table[int(min(d, pi - d) * per_rad)]
                r = p / (p + (np.float32(1.0) - share) * background[j]) * window[k]
                main_mass += r
                c += r * cosine[k]
                s += r * sine[k]
            if main_mass <= 0.0:
                break
            mean = np.float32(0.5) * np.arctan2(s, c)
            share = min(main_mass / total, MOST_SHARE)
        share_out[i] = share
        axis = mean + pi if mean < 0.0 else mean
        axes[i] = axis if axis < pi else np.float32(0.0)


def orientation_windows(
    bins: Field, weights: Field, mass: Field, least: Field
) -> tuple[NDArray[np.int64], Field, Field]:
    """The orientations around each pixel that may be on a ridge.

    Parameters
    ----------
    bins
        float32 (H, W, 16), histogram of axial orientation of weight times contrast, linear split.
    weights, mass
        float32 (H, W), sum of weights; weighted mean contrast.
    least
        float32 (H, W), the mass that a candidate must exceed.

    Returns
    -------
    places
        int64 (N,), flat indices of the candidates.
    windows
        float32 (N, 16), histograms of their 3 x 3 windows, each pixel over its weight.
    axes
        float32 (N,), mean axes, rad in [-pi/2, pi/2].
    """
    most = int(np.count_nonzero(mass > least))
    places, axes = np.empty(most, np.int64), np.empty(most, np.float32)
    windows = np.empty((most, bins.shape[2]), np.float32)
    found = _windows(bins, weights, mass, least, places, windows, axes)
    return places[:found], windows[:found], axes[:found]


def fit_mixtures(windows: Field, axes: Field) -> tuple[Field, Field]:
    """Main component of each histogram.

    Parameters
    ----------
    windows
        float32 (N, 16), histograms of axial orientation.
    axes
        float32 (N,), their mean axes: where EM starts, and the middle of the background.

    Returns
    -------
    share, orientation
        float32 (N,): the main component's share of the histogram, and its mean, rad in [0, pi).
    """
    share, orientation = np.empty(len(axes), np.float32), axes.copy()
    main, background = _gaussian_table(MAIN_SD_RAD), _gaussian_table(BACKGROUND_SD_RAD)
    _fit(windows, orientation, main, background, EM_ITERATIONS, share)
    return share, orientation
