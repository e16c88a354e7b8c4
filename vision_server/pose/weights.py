"""Weights (C, N) of edge points, 1/px^2, before residuals are known: noise, strength, trust in their line."""

from __future__ import annotations

import math

import numpy as np

from numerics.arrays import Floats
from numerics.kernels import kernel
from vision_server.channels.noise import MAD_TO_SD
from vision_server.pose.observation import Observation

SYSTEMATIC_SD_PX = 0.12  # of one edge point: pixel grid, texture and shading beside the edge
# Where lines meet, each pulls at the other's edge: the scatter is 0.42 px at blurred corners, 0.2 px three
# and 0.08 px six pixels away.
END_SD_PX, END_REACH_PX = 0.45, 4.0
STRONG_STRENGTH_RANK = 0.7  # share of a channel's edge points that are weaker than its strong ones (by hand)
MOST_INSERTED = 48  # up to so many values are sorted by insertion for their median
FADED_EXPONENT = 25.0  # from here on the scatter at the end of a line is nothing beside the rest: e^-25
HALF_WEIGHT_PX = 0.5  # from a line's straight edge, at which an edge point counts half for it (by hand)
HALF_TRUST_SCATTER_PX = 0.35  # scatter about its own straight line at which a line counts half (by hand)


@kernel()
def line_trust(seen: Observation) -> Floats:
    """How straight and complete the edge points of each channel are along each line, 0..1, (C, L).

    share^2 / (1 + (scatter / HALF_TRUST_SCATTER_PX)^2). Texture beside a crease that has no contrast in
    one light, shadow edges and clutter give edge points that are few, or scatter about any straight line.
    """
    line, offset = seen.samples.line, seen.offset
    channels, count = offset.shape
    out = np.zeros(seen.sigma.shape)
    x, y, room = np.empty(count), np.empty(count), np.empty(count)
    start = 0
    while start < count:
        end = start
        while end < count and line[end] == line[start]:
            end += 1
        for c in range(channels):
            found = 0
            for i in range(start, end):
                if not np.isnan(offset[c, i]):
                    x[found], y[found] = seen.along[i], offset[c, i]
                    found += 1
            if found >= 3:
                share = found / (end - start)
                ratio = _scatter(x[:found], y[:found], room[:found]) / HALF_TRUST_SCATTER_PX
                out[c, line[start]] = share * share / (1.0 + ratio * ratio)
        start = end
    return out


@kernel()
def _median(values: Floats) -> float:
    """Median of values (N,), which are sorted in place."""
    count = len(values)
    if count > MOST_INSERTED:
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

    ``room`` (N,) to work in. A fit as `tracking.lines` and `courses` have, but of the scatter alone, which is
    asked for at each pose that is looked at: these take weights, and reweigh until the line stays.
    """
    count = len(x)
    mean_x, mean_y, slope = 0.0, 0.0, 0.0
    for iteration in range(2):
        total, sum_x, sum_y, spread, product = 0.0, 0.0, 0.0, 0.0, 0.0
        for i in range(count):
            weight = 1.0
            if iteration > 0:
                weight = 1.0 / (1.0 + ((y[i] - mean_y - slope * (x[i] - mean_x)) / HALF_WEIGHT_PX) ** 2)
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


@kernel()
def base_weights(seen: Observation, exact_ends: bool) -> Floats:
    """Weight of each edge point before its residual is known, (C, N), 1/px^2.

    Its length in the image times its strength and the trust in its line, over its variance: by noise, by what
    no noise explains, and by the other lines where lines meet. All are scaled so that a sample counts, beside
    the priors, as much as its best channel alone: what moves an edge in one image moves it in most, so that
    many images know no more of a tone curve or of a line's bias than one does.

    Parameters
    ----------
    exact_ends
        Whether edge points near the ends of lines count less. Far from the solution their pull is worth more
        than they are off.
    """
    samples, offset, trust = seen.samples, seen.offset, line_trust(seen)
    channels, count = offset.shape
    out, found = np.zeros(offset.shape), np.empty(count)
    for c in range(channels):
        number = 0
        for i in range(count):
            if np.isfinite(offset[c, i]):
                found[number] = abs(seen.strength[c, i])
                number += 1
        if number == 0:
            continue
        rank = int(STRONG_STRENGTH_RANK * (number - 1))
        strong = max(np.partition(found[:number], rank)[rank], 1e-12)
        for i in range(count):
            if not np.isfinite(offset[c, i]):
                continue
            own = seen.sigma[c, samples.line[i]]
            near_end = 0.0
            faded = (seen.from_end[i] / (END_REACH_PX * own)) ** 2
            if exact_ends and faded < FADED_EXPONENT:
                near_end = END_SD_PX * math.exp(-faded)
            variance = seen.sd[c, i] ** 2 + (SYSTEMATIC_SD_PX**2 + near_end**2) * own**2
            share = min(1.0, abs(seen.strength[c, i]) / strong)
            out[c, i] = samples.px[i] * share * trust[c, samples.line[i]] / variance
    return out * _share_of_best(out)


@kernel()
def _share_of_best(weight: Floats) -> float:
    """Sum over the samples of the largest weight of any channel, over the sum of all (C, N)."""
    best, total = 0.0, 0.0
    for i in range(weight.shape[1]):
        largest = 0.0
        for c in range(len(weight)):
            largest = max(largest, weight[c, i])
            total += weight[c, i]
        best += largest
    return best / total if total > 0.0 else 1.0
