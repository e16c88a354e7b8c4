"""What an edge point counts before its residual is known: noise, strength, and trust in its line."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from numerics.kernels import kernel
from vision_server.channels.gradients import SCALES_PX
from vision_server.channels.noise import MAD_TO_SD
from vision_server.pose.observation import Measurement

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

SYSTEMATIC_SD_PX = 0.12  # of one edge point: pixel grid, texture and shading beside the edge
# Where lines meet, each pulls at the other's edge: the scatter is 0.42 px at blurred corners, 0.2 px three
# and 0.08 px six pixels away.
END_SD_PX, END_REACH_PX = 0.45, 4.0
STRONG_SHARE = 0.7  # of the edge points of a channel are weaker than its strong ones
FEW = 48  # values that are sorted one by one for their median
FADED = 25.0  # exponent from which on the scatter at the end of a line is nothing beside the rest
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
    x, y, room = np.empty(count), np.empty(count), np.empty(count)
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
                ratio = _scatter(x[:seen], y[:seen], room[:seen]) / scatter_px
                out[c, line[start]] = share * share / (1.0 + ratio * ratio)
        start = end


@kernel()
def _median(values: Floats) -> float:
    """Median of values (N,), which are sorted in place."""
    count = len(values)
    if count > FEW:
        return float(np.median(values))
    for i in range(1, count):
        value, k = values[i], i
        while k > 0 and values[k - 1] > value:
            values[k] = values[k - 1]
            k -= 1
        values[k] = value
    half = count // 2
    return float(values[half]) if count % 2 == 1 else float(0.5 * (values[half - 1] + values[half]))


@kernel()
def _scatter(x: Floats, y: Floats, room: Floats) -> float:
    """Robust scatter of y about its straight line over x, px: the median residual, once reweighted.

    ``room`` (N,) to work in.
    """
    count = len(x)
    mean_x, mean_y, slope = 0.0, 0.0, 0.0
    for iteration in range(2):
        total, sum_x, sum_y, spread, product = 0.0, 0.0, 0.0, 0.0, 0.0
        for i in range(count):
            weight = 1.0
            if iteration > 0:
                weight = 1.0 / (1.0 + ((y[i] - mean_y - slope * (x[i] - mean_x)) / 0.5) ** 2)
            room[i] = weight
            total += weight
            sum_x += weight * x[i]
            sum_y += weight * y[i]
        mean_x, mean_y = sum_x / total, sum_y / total
        for i in range(count):
            spread += room[i] * (x[i] - mean_x) ** 2
            product += room[i] * (x[i] - mean_x) * (y[i] - mean_y)
        slope = product / spread if spread > 1e-9 else 0.0
    for i in range(count):
        room[i] = abs(y[i] - mean_y - slope * (x[i] - mean_x))
    return float(MAD_TO_SD * _median(room))


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
            faded = (from_end[i] / (END_REACH_PX * own)) ** 2
            if end_sd_px > 0.0 and faded < FADED:
                near_end = end_sd_px * math.exp(-faded)
            variance = sd[c, i] ** 2 + (SYSTEMATIC_SD_PX**2 + near_end**2) * own**2
            out[c, i] = px[i] * min(1.0, abs(strength[c, i]) / strong) * trust[c, line[i]] / variance
