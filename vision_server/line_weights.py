"""What an edge point counts before its residual is known: noise, strength, and trust in its line."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from geometry.kernels import kernel
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


@kernel()
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


@kernel()
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
    out = np.zeros_like(measurement.offset)
    _weights(
        measurement.samples.line,
        measurement.samples.px,
        measurement.from_end,
        measurement.offset,
        measurement.sd,
        measurement.strength,
        line_trust(measurement, lines),
        np.array(SCALES_PX)[measurement.scale],
        END_SD_PX if exact_ends else 0.0,
        out,
    )
    return out


@kernel(error_model="numpy")
def _weights(
    line: Ints,
    px: Floats,
    from_end: Floats,
    offset: Floats,
    sd: Floats,
    strength: Floats,
    trust: Floats,
    sigma: Floats,
    end_sd_px: float,
    out: Floats,
) -> None:
    """See `base_weights`; trust and sigma (C, L), out (C, N)."""
    channels, count = offset.shape
    seen = np.empty(count)
    for c in range(channels):
        found = 0
        for i in range(count):
            if np.isfinite(offset[c, i]):
                seen[found] = abs(strength[c, i])
                found += 1
        if found == 0:
            continue
        rank = int(STRONG_SHARE * (found - 1))
        strong = max(np.partition(seen[:found], rank)[rank], 1e-12)
        for i in range(count):
            if not np.isfinite(offset[c, i]):
                continue
            own = sigma[c, line[i]]
            near_end = 0.0
            if end_sd_px > 0.0:
                near_end = end_sd_px * math.exp(-((from_end[i] / (END_REACH_PX * own)) ** 2))
            variance = sd[c, i] ** 2 + (SYSTEMATIC_SD_PX**2 + near_end**2) * own**2
            out[c, i] = px[i] * min(1.0, abs(strength[c, i]) / strong) * trust[c, line[i]] / variance
