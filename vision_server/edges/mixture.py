"""The two-component mixture of orientations at one pixel, fitted by EM: its definition, then the quick form.

The paper explains the orientations that all channels show in a local window, weighted by their magnitudes, by
two Gaussians: the main one is the true edge, the background one is shadow edges and noise. Orientation is an
axis (contrast may reverse between two lights), so its doubled angle lives on the circle, and the Gaussian's
place there is taken by the von Mises density. `fit_mixture` states this sample by sample. `fit_mixtures` does
the same to histograms of 16 orientations, many pixels side by side, and is tested against it.
"""

from __future__ import annotations

import numpy as np

from numerics.arrays import Field, Floats
from numerics.kernels import kernel

MAIN_SD_RAD = 0.25  # of orientation along a true edge inside the window; chosen by hand
BACKGROUND_SD_RAD = 1.0  # of shadow edges and noise: nearly any orientation; chosen by hand
EM_ITERATIONS = 4  # more change the share by less than the histogram does (test_mixture.py)
MOST_SHARE = 0.999  # a share of 1 would leave the background no way back
BINS = 16  # of axial orientation over pi: 11 degrees each, within the main component's spread


def axial_difference(a: Floats | float, b: Floats | float) -> Floats:
    """Angle (N,) between axes (N,), rad, 0 .. pi/2."""
    difference = np.mod(np.abs(np.asarray(a) - b), np.pi)
    return np.asarray(np.minimum(difference, np.pi - difference))


def axial_mean(angles: Floats, weights: Floats) -> float:
    """Mean direction of weighted axes (N,), rad, by their doubled angles, rad."""
    sine, cosine = np.sum(weights * np.sin(2.0 * angles)), np.sum(weights * np.cos(2.0 * angles))
    return float(0.5 * np.arctan2(sine, cosine))


def concentration(sd_rad: float) -> float:
    """Kappa of the von Mises density of the doubled angle that is as narrow as a Gaussian of the angle."""
    return 1.0 / (2.0 * sd_rad) ** 2


def axial_density(difference: Floats | float, sd_rad: float) -> Floats:
    """Density of an axis so far from its mean, per rad: exp(kappa cos 2d) / (pi I0(kappa))."""
    kappa = concentration(sd_rad)
    return np.asarray(np.exp(kappa * np.cos(2.0 * np.asarray(difference))) / (np.pi * np.i0(kappa)))


def fit_mixture(angles: Floats, weights: Floats) -> tuple[float, float]:
    """The mixture of the orientations in one window: the definition.

    Fitted are the main component's mean and its share of all weight. Fixed are both spreads, and the mean of
    the background, which is that of all samples together.

    Parameters
    ----------
    angles
        float64 (N,), orientations as axes, rad.
    weights
        float64 (N,), > 0: the magnitude of each, times its channel's say.

    Returns
    -------
    The share of the main component, and its mean axis, rad in [0, pi).
    """
    mean, share = axial_mean(angles, weights), 0.5
    background = axial_density(axial_difference(angles, mean), BACKGROUND_SD_RAD)
    for _ in range(EM_ITERATIONS):
        # E-step: how likely each sample is the true edge's, and not shadow or noise
        main = share * axial_density(axial_difference(angles, mean), MAIN_SD_RAD)
        belongs = weights * main / (main + (1.0 - share) * background)
        # M-step: "merged orientation" and "the share of all magnitudes that belongs to the main component"
        mean = axial_mean(angles, belongs)
        share = min(float(belongs.sum() / weights.sum()), MOST_SHARE)
    return share, mean % np.pi


SQUARINGS = 8  # exp(t) is taken as (1 + t / 2^8)^(2^8): within 1 % where it counts, and no branch
COSINES, SINES = (wave(2.0 * np.pi * np.arange(BINS) / BINS).astype(np.float32) for wave in (np.cos, np.sin))
MAIN_RATE, BACKGROUND_RATE = (
    np.float32(concentration(sd) / 2**SQUARINGS) for sd in (MAIN_SD_RAD, BACKGROUND_SD_RAD)
)
MAIN_PEAK, BACKGROUND_PEAK = (np.float32(axial_density(0.0, sd)) for sd in (MAIN_SD_RAD, BACKGROUND_SD_RAD))
TINY = np.float32(1e-30)  # keeps a direction of nothing from dividing by zero
HIGHEST_SHARE = np.float32(MOST_SHARE)


@kernel(inline="always")
def _fall(cosine: np.float32, rate: np.float32) -> np.float32:
    """Density over its peak, from the cosine of the doubled angle to the mean."""
    power = np.float32(1.0) + rate * (cosine - np.float32(1.0))
    for _ in range(SQUARINGS):
        power *= power
    return power


@kernel(inline="always")
def fit_mixtures(histograms: Field, fitted: Field, background: Field, sums: Field) -> None:
    """`fit_mixture` of a batch of histograms of axial orientation.

    The pixels lie along the last axis and the mean is a unit vector of the doubled angle, so that a batch
    fills vector registers and needs no trigonometry. To be inlined where its arrays are made.

    Parameters
    ----------
    histograms
        float32 (16, B), each with some mass.
    fitted
        float32 (3, B), output: the main component's share of each histogram, and the unit vector of its
        doubled mean axis.
    background, sums
        float32 (16, B) and (4, B), room to work in.
    """
    one = np.float32(1.0)
    batch = histograms.shape[1]
    share, x, y = fitted[0], fitted[1], fitted[2]
    mass, c, s, total = sums[0], sums[1], sums[2], sums[3]
    for j in range(batch):
        c[j] = s[j] = total[j] = np.float32(0.0)
    for k in range(BINS):
        row = histograms[k]
        for j in range(batch):
            c[j] += row[j] * COSINES[k]
            s[j] += row[j] * SINES[k]
            total[j] += row[j]
    for j in range(batch):
        scale = one / max(np.sqrt(c[j] * c[j] + s[j] * s[j]), TINY)
        x[j], y[j] = c[j] * scale, s[j] * scale
        share[j] = np.float32(0.5)
    for k in range(BINS):
        row = background[k]
        for j in range(batch):
            row[j] = BACKGROUND_PEAK * _fall(COSINES[k] * x[j] + SINES[k] * y[j], BACKGROUND_RATE)
    for _ in range(EM_ITERATIONS):
        for j in range(batch):
            mass[j] = c[j] = s[j] = np.float32(0.0)
        for k in range(BINS):
            row, other = histograms[k], background[k]
            for j in range(batch):
                main = share[j] * MAIN_PEAK * _fall(COSINES[k] * x[j] + SINES[k] * y[j], MAIN_RATE)
                belongs = row[j] * main / (main + (one - share[j]) * other[j])
                mass[j] += belongs
                c[j] += belongs * COSINES[k]
                s[j] += belongs * SINES[k]
        for j in range(batch):
            scale = one / max(np.sqrt(c[j] * c[j] + s[j] * s[j]), TINY)
            x[j], y[j] = c[j] * scale, s[j] * scale
            share[j] = min(mass[j] / total[j], HIGHEST_SHARE)
