"""A blurred step fitted to the pixels beside one line."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from numerics.cholesky import solve_positive
from numerics.kernels import kernel

Floats = NDArray[np.float64]

ROUNDS = 6
SETTLED_PX = 1e-3  # a step of the fit that changes place and blur by less is the last one
LEVELS, FIT, SLOPES = 4, 7, 9  # unknowns: A and H; with u and b; with a slope across each side
SHARPEST_PX = 0.25


@kernel(error_model="numpy")
def profile_row(place: float, share: float, fit: Floats, out: Floats) -> float:
    """Derivatives of the profile by its unknowns, (9,), and its value.

    Unknowns: A at the line's middle and its change to the end, the same of H, the same of u, log b, and a
    slope across the side before and the one behind the edge.
    """
    height = fit[2] + share * fit[3]
    z = (place - fit[4] - share * fit[5]) / fit[6]
    step = 0.5 * math.erfc(-z / math.sqrt(2.0))
    bell = math.exp(-0.5 * z * z) / math.sqrt(2.0 * math.pi)
    out[0], out[1] = 1.0, share
    out[2], out[3] = step, share * step
    out[4] = -height * bell / fit[6]
    out[5] = share * out[4]
    out[6] = -height * bell * z
    out[7], out[8] = place * (1.0 - step), place * step
    return float(fit[0] + share * fit[1] + height * step)


@kernel(error_model="numpy")
def _add(row: Floats, size: int, left: float, variance: float, normal: Floats, pull: Floats) -> None:
    """Add one pixel to the normal equations of the first ``size`` unknowns, lower triangle."""
    for m in range(size):
        scaled = row[m] / variance
        pull[m] += scaled * left
        for n in range(m + 1):
            normal[m, n] += scaled * row[n]


@kernel(error_model="numpy")
def fit_step(
    place: Floats,
    share: Floats,
    value: Floats,
    variance: Floats,
    near: int,
    blur_px: float,
    fit: Floats,
    inverse: Floats,
) -> tuple[float, float, float]:
    """Fit a blurred step to pixels (M,) beside a line, by Gauss-Newton.

    Parameters
    ----------
    near
        The pixels from here on are far from the edge. They tell the levels alone.
    blur_px
        A first guess.
    fit
        (7,), output: see `_row`; the last is the blur b, px.
    inverse
        (7, 7), output: covariance of the fit, with log b.

    Returns
    -------
    Mean squared residual over the noise; by how much u at the middle moves once the sides may slope, px, and
    the standard deviation of that. Infinite where no step can be fitted.
    """
    row = np.empty(SLOPES)
    sums, counts = np.zeros(2), np.zeros(2)
    for k in range(len(place)):
        if abs(place[k]) > 1.5 * blur_px:
            side = 1 if place[k] > 0.0 else 0
            sums[side] += value[k]
            counts[side] += 1.0
    if counts.min() < 1.0:
        return np.inf, np.inf, 0.0
    fit[:] = 0.0
    fit[0], fit[2], fit[6] = sums[0] / counts[0], sums[1] / counts[1] - sums[0] / counts[0], blur_px
    normal, pull = np.zeros((SLOPES, SLOPES)), np.zeros(SLOPES)
    levels, level_pull = np.zeros((LEVELS, LEVELS)), np.zeros(LEVELS)
    for k in range(near, len(place)):
        step = 1.0 if place[k] > 0.0 else 0.0
        row[0], row[1], row[2], row[3] = 1.0, share[k], step, step * share[k]
        _add(row, LEVELS, value[k], variance[k], levels, level_pull)
    for m in range(LEVELS):
        for n in range(m):
            levels[n, m] = levels[m, n]
    for _ in range(ROUNDS):
        normal[:], pull[:] = 0.0, 0.0
        normal[:LEVELS, :LEVELS] = levels
        for m in range(LEVELS):
            pull[m] = level_pull[m]
            for n in range(LEVELS):
                pull[m] -= levels[m, n] * fit[n]
        for k in range(near):
            left = value[k] - profile_row(place[k], share[k], fit, row)
            _add(row, FIT, left, variance[k], normal, pull)
        change = solve_positive(normal[:FIT, :FIT], pull[:FIT], 0.0, 0.0)
        fit[:6] += change[:6]
        fit[6] *= math.exp(min(0.5, max(-0.5, change[6])))
        if not (abs(fit[4]) + abs(fit[5]) < 3.0 * blur_px and SHARPEST_PX <= fit[6] < 5.0 * blur_px):
            return np.inf, np.inf, 0.0
        if abs(change[4]) + abs(change[5]) + abs(change[6]) < SETTLED_PX:
            break
    normal[:], pull[:] = 0.0, 0.0
    misfit = 0.0
    for k in range(len(place)):
        left = value[k] - profile_row(place[k], share[k], fit, row)
        misfit += left * left / variance[k]
        _add(row, SLOPES, left, variance[k], normal, pull)
    for m in range(FIT):
        inverse[m] = solve_positive(normal[:FIT, :FIT], np.eye(FIT)[m], 0.0, 0.0)
    with_slopes = solve_positive(normal, np.eye(SLOPES)[4], 0.0, 0.0)
    if not (inverse[4, 4] > 0.0 and with_slopes[4] > 0.0):
        return np.inf, np.inf, 0.0
    shifted = 0.0
    for m in range(SLOPES):
        shifted += with_slopes[m] * pull[m]
    for m in range(FIT):
        shifted -= inverse[4, m] * pull[m]
    spread = max(with_slopes[4] - inverse[4, 4], 0.0)
    return misfit / max(1, len(place) - FIT), shifted, math.sqrt(spread)
