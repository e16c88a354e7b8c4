"""The two-component mixture of orientations at each pixel, fitted by EM on a histogram."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vision_server.crests import across

Field = NDArray[np.float32]

EM_ITERATIONS = 4
MAIN_SD_RAD = 0.25  # spread of the orientation along a true edge inside the window
BACKGROUND_SD_RAD = 1.0  # shadow edges and noise: nearly anything
SLACK = 0.9  # on the first, mean orientation a pixel this close to a crest of the mass still is a candidate
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
def _mixture(
    bins: Field,
    weights: Field,
    mass: Field,
    largest: Field,
    floor: Field,
    ratio: float,
    slack: float,
    main_table: Field,
    background_table: Field,
    iterations: int,
    magnitude: Field,
    orientation: Field,
) -> None:
    """EM on the histogram of the 3 x 3 window of each pixel that may be on a ridge."""
    rows, columns, count = bins.shape
    steps = len(main_table) - 1
    per_rad = np.float32(steps / (0.5 * np.pi))
    pi = np.float32(np.pi)
    window = np.zeros(count, np.float32)
    cosine, sine = np.empty(count, np.float32), np.empty(count, np.float32)
    centre, background = np.empty(count, np.float32), np.empty(count, np.float32)
    held = np.empty(count, np.int64)
    for k in range(count):
        centre[k] = k * np.pi / count
        cosine[k], sine[k] = np.cos(2.0 * k * np.pi / count), np.sin(2.0 * k * np.pi / count)
    for y in range(1, rows - 1):
        for x in range(1, columns - 1):
            here = mass[y, x]
            if here <= floor[y, x] or here < ratio * largest[y, x]:
                continue
            window[:] = 0.0
            for v in range(y - 1, y + 2):
                for u in range(x - 1, x + 2):
                    if mass[v, u] > 0.0:
                        scale = np.float32(1.0) / weights[v, u]
                        for k in range(count):
                            window[k] += bins[v, u, k] * scale
            total, c, s = np.float32(0.0), np.float32(0.0), np.float32(0.0)
            filled = 0
            for k in range(count):
                if window[k] > 0.0:
                    total += window[k]
                    c += window[k] * cosine[k]
                    s += window[k] * sine[k]
                    held[filled] = k
                    filled += 1
            mean = np.float32(0.5) * np.arctan2(s, c)
            ahead, behind = across(mass, y, x, np.cos(mean), np.sin(mean))
            if here < slack * ahead or here < slack * behind:
                continue
            for j in range(filled):
                d = abs(centre[held[j]] - mean)
                if d > pi:
                    d -= pi
                background[j] = background_table[int(min(d, pi - d) * per_rad)]
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
                share = min(main_mass / total, np.float32(0.999))
            magnitude[y, x] = share * here
            axis = mean + pi if mean < 0.0 else mean
            orientation[y, x] = axis if axis < pi else np.float32(0.0)


def fit_mixtures(
    bins: Field, weights: Field, mass: Field, largest: Field, floor: Field, candidate_ratio: float
) -> tuple[Field, Field]:
    """Merged magnitude and orientation where a ridge may be.

    Parameters
    ----------
    bins
        float32 (H, W, 16), histogram of axial orientation of weight times contrast, linear split.
    weights, mass, floor
        float32 (H, W), sum of weights; weighted mean contrast; its standard deviation from noise.
    largest
        float32 (H, W), largest mass around each pixel.
    candidate_ratio
        A pixel with a smaller share of ``largest`` cannot be a ridge.

    Returns
    -------
    magnitude, orientation
        float32 (H, W): share of the main component times mass, and its mean, rad in [0, pi); 0 elsewhere.
    """
    magnitude, orientation = np.zeros_like(mass), np.zeros_like(mass)
    main, background = _gaussian_table(MAIN_SD_RAD), _gaussian_table(BACKGROUND_SD_RAD)
    _mixture(
        bins,
        weights,
        mass,
        largest,
        floor,
        candidate_ratio,
        SLACK,
        main,
        background,
        EM_ITERATIONS,
        magnitude,
        orientation,
    )
    return magnitude, orientation
