"""What an edge point counts before its residual is known: noise, strength, and trust in its line."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vision_server.gradients import SCALES_PX
from vision_server.measurement import Measurement

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

SYSTEMATIC_SD_PX = 0.12  # of one edge point: pixel grid, texture and shading beside the edge
# Where lines meet, each pulls at the other's edge: the scatter is 0.42 px at blurred corners, 0.2 px three
# and 0.08 px six pixels away.
END_SD_PX, END_REACH_PX = 0.45, 4.0
STRONG_SHARE = 0.7  # of the edge points of a channel are weaker than its strong ones
SCATTER_PX = 0.35  # scatter about its own straight line at which a line counts half


def line_trust(measurement: Measurement, lines: int) -> Floats:
    """How straight and complete the edge points of each channel are along each line, 0..1, (C, L).

    Texture beside a crease that has no contrast in one light, shadow edges and clutter give edge points that
    are few, or that scatter about any straight line.
    """
    out = np.zeros((len(measurement.offset), lines))
    _trust(measurement.samples.line, measurement.along, measurement.offset, SCATTER_PX, out)
    return out


@njit(cache=True)
def _trust(line: Ints, along: Floats, offset: Floats, scatter_px: float, out: Floats) -> None:
    """share^2 / (1 + (scatter / scatter_px)^2) for each channel and line; ``line`` is ascending."""
    channels, count = offset.shape
    x, y = np.empty(count), np.empty(count)
    start = 0
    while start < count:
        end = start
        while end < count and line[end] == line[start]:
            end += 1
        for c in range(channels):
            seen = 0
            for i in range(start, end):
                if not np.isnan(offset[c, i]):
                    x[seen], y[seen] = along[i], offset[c, i]
                    seen += 1
            if seen >= 3:
                share = seen / (end - start)
                ratio = _scatter(x[:seen], y[:seen]) / scatter_px
                out[c, line[start]] = share * share / (1.0 + ratio * ratio)
        start = end


@njit(cache=True)
def _scatter(x: Floats, y: Floats) -> float:
    """Robust scatter of y about its straight line over x, px: twice reweighted, median absolute residual."""
    residual = y - np.median(y)
    weight = np.ones(len(x))
    for _ in range(2):
        total = weight.sum()
        mean_x, mean_y = (weight * x).sum() / total, (weight * y).sum() / total
        spread = (weight * (x - mean_x) ** 2).sum()
        slope = (weight * (x - mean_x) * (y - mean_y)).sum() / spread if spread > 1e-9 else 0.0
        residual = y - mean_y - slope * (x - mean_x)
        weight = 1.0 / (1.0 + (residual / 0.5) ** 2)
    return float(1.4826 * np.median(np.abs(residual)))


def base_weights(measurement: Measurement, lines: int, exact_ends: bool = True) -> Floats:
    """Weight of each edge point before its residual is known, (C, N), 1/px^2.

    Parameters
    ----------
    exact_ends
        Whether edge points near the ends of lines count less. Far from the solution their pull is worth more
        than they are off.
    """
    trust = line_trust(measurement, lines)
    sigma = np.array(SCALES_PX)[measurement.scale]
    end_sd_px = END_SD_PX if exact_ends else 0.0
    out = np.zeros_like(measurement.offset)
    for c in range(len(out)):
        strength = np.abs(measurement.strength[c])
        seen = strength[np.isfinite(measurement.offset[c])]
        if len(seen):
            rank = int(STRONG_SHARE * (len(seen) - 1))
            strong = max(float(np.partition(seen, rank)[rank]), 1e-12)
            of_sample = measurement.samples.line
            own = sigma[c, of_sample]
            near_end = end_sd_px * np.exp(-((measurement.from_end / (END_REACH_PX * own)) ** 2))
            variance = measurement.sd[c] ** 2 + (SYSTEMATIC_SD_PX**2 + near_end**2) * own**2
            out[c] = np.minimum(1.0, strength / strong) * trust[c, of_sample] / variance
    return out * measurement.samples.px
