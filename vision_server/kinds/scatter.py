"""How log-ratios scatter from channel to channel: tells outline, crease and print before any light is known.

In each kind the values of C channels are Gaussians of known variances about a mean of their own, which is one
itself. Of a print, and of what is no edge, the log-ratio varies by noise only, or by what is uneven; of a
crease by more. Of an outline what varies is the darker side beside the background.
"""

from __future__ import annotations

import math

import numpy as np

from numerics.arrays import Field
from numerics.kernels import kernel
from numerics.logarithm import HALF, ONE, ZERO, log_of, log_of_sum
from vision_server.kinds.blocked import FLAT_SD
from vision_server.kinds.densities import UNKNOWN_SD, log_normal, of_a_mean, ratio_of
from vision_server.kinds.sides import Sides

# Of log-ratios; chosen by hand on renders and photographs: `python -m benchmarks.edge_kinds`.
SURFACE_SD = 0.2  # of two places 4 px apart on one surface, from light to light: it is curved
UNEVEN_SD = 0.1  # of both where there is no edge
FAINT_SD = 0.04  # of prints that are none
PRINT_SD = 0.7  # of prints, and of creases in their mean light
DEEPEST_PRINT = 1.4  # deeper ones are rather ends of shadows
SHORTER = 0.5  # times by how much the grey that is added to both sides shortens a print's, its sd
CREASE_SD = 0.25  # of a crease from light to light
BACKGROUND_SD = 0.4  # of the background from place to place
EVEN_SD = 0.05  # of the background from light to light, where it is one that hardly changes
# Of a scatter: the logarithm of its density about 0, sums of 1 / variance and of value / variance.
ALONE, PRECISION, PULL = range(3)


def scatter(sides: Sides, background: float) -> Field:
    """Log-likelihoods of an outline, a crease, a print and of no edge: float32 (4, N).

    Parameters
    ----------
    sides
        Of N edgels in C channels.
    background
        Grey of the background at reference exposure.
    """
    found = np.empty((4, sides.noise.shape[1]), np.float32)
    _scatter(sides, np.float32(sides.dark), np.float32(background + sides.dark), found)
    return found


@kernel(fastmath={"reassoc", "contract", "nsz"})
def _sums(values: Field, noise: Field, more: float) -> Field:
    """ALONE, PRECISION and PULL (3, N) of values (C, N) whose variances are ``noise`` and so much more."""
    channels, count = values.shape
    sums, extra = np.zeros((3, count), np.float32), np.float32(more)
    for channel in range(channels):
        for i in range(count):
            value, variance = values[channel, i], noise[channel, i] + extra
            sums[ALONE, i] += log_normal(value, variance)
            sums[PRECISION, i] += ONE / variance
            sums[PULL, i] += value / variance
    return sums


@kernel(fastmath={"reassoc", "contract", "nsz"})
def _about_a_mean(sums: Field, sd: float, found: Field) -> None:
    """Log-likelihood (N,), an output, that values scatter about a mean that is N(0, sd^2), by their sums."""
    alone, precision, pull = sums[ALONE], sums[PRECISION], sums[PULL]
    variance = np.float32(sd * sd)
    for i in range(len(found)):
        found[i] = alone[i] + of_a_mean(precision[i], pull[i], variance)


@kernel(fastmath={"reassoc", "contract", "nsz"})
def _scatter(of: Sides, dark: np.float32, background: np.float32, found: Field) -> None:
    """As `scatter`; ``background`` has what is dark added to it, ``found`` is an output."""
    channels, count = of.noise.shape
    least, of_shorter = np.float32(math.exp(-DEEPEST_PRINT)), np.float32(SHORTER**2)
    lit, darkness = np.zeros((2, count), np.float32), np.empty((channels, count), np.float32)
    room = np.empty((3, channels, count), np.float32)
    ratios, noise, unsure = room[0], room[1], room[2]  # unpacked, each would have strides of any length
    for channel in range(channels):
        for i in range(count):
            lit[0, i] = max(lit[0, i], of.brightest[channel, 0, i])
            lit[1, i] = max(lit[1, i], of.brightest[channel, 1, i])
    for channel in range(channels):
        for i in range(count):
            back, ahead = of.brightest[channel, 0, i], of.brightest[channel, 1, i]
            darker = max(back if lit[0, i] < lit[1, i] else ahead, ZERO)
            darkness[channel, i] = log_of((darker + dark) / background)
        for i in range(count):
            ratios[channel, i], of_noise = ratio_of(
                of.near[channel, 0, i], of.near[channel, 1, i], of.noise[channel, i], dark
            )
            noise[channel, i] = of_noise + (ZERO if of.known[channel, i] else np.float32(UNKNOWN_SD**2))
        for i in range(count):
            # by so much what is added shortens the ratio of a print, the more the dimmer the light
            back, ahead = of.near[channel, 0, i], of.near[channel, 1, i]
            brighter = max(back, ahead, ZERO)
            dim = max(min(back, ahead), least * brighter)
            shorter = dark * (brighter - dim) / ((dim + dark) * (brighter + dark))
            unsure[channel, i] = noise[channel, i] + of_shorter * shorter * shorter
    surface = SURFACE_SD**2
    behind, crease = _sums(darkness, noise, surface), _sums(ratios, noise, surface + CREASE_SD**2)
    even_behind = _sums(darkness, noise, EVEN_SD**2)
    flat, uneven = _sums(ratios, unsure, FLAT_SD**2), _sums(ratios, noise, UNEVEN_SD**2)
    _about_a_mean(behind, BACKGROUND_SD, found[0])
    _about_a_mean(crease, PRINT_SD, found[1])
    _about_a_mean(flat, PRINT_SD, found[2])
    _about_a_mean(flat, FAINT_SD, found[3])
    outline, none = found[0], found[3]
    even, not_even = np.empty(count, np.float32), np.empty(count, np.float32)
    _about_a_mean(even_behind, BACKGROUND_SD, even)
    _about_a_mean(uneven, UNEVEN_SD, not_even)
    for i in range(count):
        outline[i] = log_of_sum(outline[i], even[i]) + log_of(HALF)
        none[i] = log_of_sum(none[i], not_even[i]) + log_of(HALF)
