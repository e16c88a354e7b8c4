"""The two-component mixture of orientations at one pixel, fitted by EM on a histogram.

Orientation is an axis: its doubled angle lives on the circle, where the Gaussian's place is taken by the von
Mises density exp(kappa (cos 2d - 1)) / (pi I0(kappa) exp(-kappa)), kappa = 1 / (2 sd)^2.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from numerics.kernels import kernel

Field = NDArray[np.float32]

BINS = 16  # of axial orientation over pi; a constant of the kernels, so that they fill vector registers
EM_ITERATIONS = 4
MAIN_SD_RAD = 0.25  # spread of the orientation along a true edge inside the window
BACKGROUND_SD_RAD = 1.0  # shadow edges and noise: nearly anything
TINY = np.float32(1e-30)  # keeps a direction of nothing from dividing by zero
MOST_SHARE = np.float32(0.999)  # a share of 1 would leave the background no way back


def concentration(sd_rad: float) -> tuple[float, float]:
    """Concentration of the von Mises density of a doubled angle, and its value at the mean, per rad."""
    kappa = 1.0 / (4.0 * sd_rad**2)
    return kappa, 1.0 / (np.pi * float(np.i0(kappa) * np.exp(-kappa)))


def bin_directions() -> Field:
    """Cosine and sine of the doubled angle of each bin, float32 (2, 16)."""
    doubled = 2.0 * np.pi * np.arange(BINS) / BINS
    return np.stack([np.cos(doubled), np.sin(doubled)]).astype(np.float32)


def densities() -> Field:
    """Concentration / 256 and density at the mean, of the main and of the background component, (4,)."""
    (main, main_density), (back, back_density) = concentration(MAIN_SD_RAD), concentration(BACKGROUND_SD_RAD)
    return np.array([main / 256.0, main_density, back / 256.0, back_density], np.float32)


@kernel(inline="always")
def fit_mixtures(
    histograms: Field,
    directions: Field,
    model: Field,
    iterations: int,
    beside: Field,
    out: Field,
    sums: Field,
) -> None:
    """EM on a batch of histograms of axial orientation, from the mean axis and equal shares on.

    Directions are unit vectors of the doubled angle, and the exponential is (1 + t / 256)^256 (1 % for what
    counts here): no branch, no table and no trigonometry. Pixels lie along the last axis, so that a batch
    fills vector registers. To be inlined where its arrays are made.

    Parameters
    ----------
    histograms
        float32 (16, B), each with some mass.
    directions, model
        From `bin_directions` and `densities`.
    iterations
        Of EM.
    beside
        float32 (16, B), room to work in.
    out
        float32 (3, B), output: the main component's share of each histogram, and the unit vector of its
        doubled mean axis.
    sums
        float32 (4, B), room to work in.
    """
    one = np.float32(1.0)
    batch = histograms.shape[1]
    share, x, y = out[0], out[1], out[2]
    mass, c, s, total = sums[0], sums[1], sums[2], sums[3]
    for j in range(batch):
        x[j] = y[j] = total[j] = np.float32(0.0)
    for k in range(BINS):
        row = histograms[k]
        for j in range(batch):
            x[j] += row[j] * directions[0, k]
            y[j] += row[j] * directions[1, k]
            total[j] += row[j]
    for j in range(batch):
        scale = one / max(np.sqrt(x[j] * x[j] + y[j] * y[j]), TINY)
        x[j] *= scale
        y[j] *= scale
        share[j] = np.float32(0.5)
    for k in range(BINS):
        row = beside[k]
        for j in range(batch):
            e = one + model[2] * (directions[0, k] * x[j] + directions[1, k] * y[j] - one)
            e *= e
            e *= e
            e *= e
            e *= e
            e *= e
            e *= e
            e *= e
            e *= e
            row[j] = model[3] * e
    for _ in range(iterations):
        for j in range(batch):
            mass[j] = c[j] = s[j] = np.float32(0.0)
        for k in range(BINS):
            row, other = histograms[k], beside[k]
            for j in range(batch):
                e = one + model[0] * (directions[0, k] * x[j] + directions[1, k] * y[j] - one)
                e *= e
                e *= e
                e *= e
                e *= e
                e *= e
                e *= e
                e *= e
                e *= e
                p = share[j] * model[1] * e
                r = p / (p + (one - share[j]) * other[j]) * row[j]
                mass[j] += r
                c[j] += r * directions[0, k]
                s[j] += r * directions[1, k]
        for j in range(batch):
            scale = one / max(np.sqrt(c[j] * c[j] + s[j] * s[j]), TINY)
            x[j], y[j] = c[j] * scale, s[j] * scale
            share[j] = min(mass[j] / total[j], MOST_SHARE)
