"""The two-component mixture of orientations at each pixel, fitted by EM on a histogram.

Orientation is an axis: its doubled angle lives on the circle, where the Gaussian's place is taken by the von
Mises density exp(kappa (cos 2d - 1)) / (pi I0(kappa) exp(-kappa)), kappa = 1 / (2 sd)^2.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.special import i0e

Field = NDArray[np.float32]

BINS = 16  # of axial orientation over pi; a constant of the kernels, so that they fill vector registers
EM_ITERATIONS = 4
MAIN_SD_RAD = 0.25  # spread of the orientation along a true edge inside the window
BACKGROUND_SD_RAD = 1.0  # shadow edges and noise: nearly anything
MOST_SHARE = np.float32(0.999)  # a share of 1 would leave the background no way back


@njit(cache=True, error_model="numpy")
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
    rows, columns = mass.shape
    cosine, sine = np.empty(BINS, np.float32), np.empty(BINS, np.float32)
    for k in range(BINS):
        cosine[k], sine[k] = np.cos(2.0 * k * np.pi / BINS), np.sin(2.0 * k * np.pi / BINS)
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
                        for k in range(BINS):
                            window[k] += bins[v, u, k] * scale
            c, s = np.float32(0.0), np.float32(0.0)
            for k in range(BINS):
                c += window[k] * cosine[k]
                s += window[k] * sine[k]
            places[found] = y * columns + x
            axes[found] = np.float32(0.5) * np.arctan2(s, c)
            found += 1
    return found


@njit(cache=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz"})
def _fit(
    windows: Field, axes: Field, main: tuple[float, float], background: tuple[float, float], iterations: int
) -> Field:
    """EM on each histogram; ``axes`` goes in as the mean axis and comes out as that of the main component.

    ``main`` and ``background`` are concentration and density at the mean. Directions are unit vectors of the
    doubled angle, and the exponential is (1 + t / 256)^256 (1 % for what counts here): no branch, no table
    and no trigonometry inside, so that the bins fill vector registers.
    """
    cosine, sine = np.empty(BINS, np.float32), np.empty(BINS, np.float32)
    beside = np.empty(BINS, np.float32)
    for k in range(BINS):
        cosine[k], sine[k] = np.cos(2.0 * k * np.pi / BINS), np.sin(2.0 * k * np.pi / BINS)
    one, root = np.float32(1.0), np.float32(1.0 / 256.0)
    main_scale, main_density = np.float32(main[0]) * root, np.float32(main[1])
    back_scale, back_density = np.float32(background[0]) * root, np.float32(background[1])
    shares = np.empty(len(windows), np.float32)
    for i in range(len(windows)):
        window = windows[i]
        x, y = np.float32(np.cos(2.0 * axes[i])), np.float32(np.sin(2.0 * axes[i]))
        total = np.float32(0.0)
        for k in range(BINS):
            total += window[k]
            e = one + back_scale * (cosine[k] * x + sine[k] * y - one)
            for _ in range(8):
                e *= e
            beside[k] = back_density * e
        share = np.float32(0.5)
        for _ in range(iterations):
            mass, c, s = np.float32(0.0), np.float32(0.0), np.float32(0.0)
            mine, other = share * main_density, one - share
            for k in range(BINS):
                e = one + main_scale * (cosine[k] * x + sine[k] * y - one)
                e *= e
                e *= e
                e *= e
                e *= e
                e *= e
                e *= e
                e *= e
                e *= e
                p = mine * e
                r = p / (p + other * beside[k]) * window[k]
                mass += r
                c += r * cosine[k]
                s += r * sine[k]
            length = np.sqrt(c * c + s * s)
            if length <= np.float32(0.0):
                break
            x, y = c / length, s / length
            share = min(mass / total, MOST_SHARE)
        shares[i] = share
        axis = np.float32(0.5 * np.arctan2(y, x))
        if axis < 0.0:
            axis += np.float32(np.pi)
        axes[i] = axis if axis < np.float32(np.pi) else np.float32(0.0)
    return shares


def concentration(sd_rad: float) -> tuple[float, float]:
    """Concentration of the von Mises density of a doubled angle, and its value at the mean, per rad."""
    kappa = 1.0 / (4.0 * sd_rad**2)
    return kappa, 1.0 / (np.pi * float(i0e(kappa)))


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
    orientation = axes.copy()
    main, background = concentration(MAIN_SD_RAD), concentration(BACKGROUND_SD_RAD)
    return _fit(windows, orientation, main, background, EM_ITERATIONS), orientation
