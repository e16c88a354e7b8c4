"""Where each visible line of the model lies beside its edge points, and what rounded edges do to that.

In goes an observation; out come two numbers a line and channel, offset and turn, with their variances and
how a pose's step moves them: what `fitting` solves for the pose.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from geometry.pose import Pose
from numerics.arrays import Floats, Ints
from numerics.kernels import kernel
from vision_server.pose.observation import Observation, PoseProblem
from vision_server.pose.roundings import roundings
from vision_server.pose.solver import SAMPLES_TOGETHER
from vision_server.pose.weights import HALF_TRUST_SCATTER_PX, HALF_WEIGHT_PX

LINE_UNKNOWNS, RADIUS = 9, 8  # pose, two nuisances, and the last, the radius of rounded edges

FEWEST_LINE_POINTS = 4  # edge points of a line that tell its place, its turn and what they scatter
LINE_ITERATIONS = 5  # times that a straight line is fitted to them, reweighted (by hand)
# The turn is seen where the variance of the edge points' places on the line, from -1 to 1, is at least this;
# of evenly spread ones it is 1/3.
LEAST_PLACE_VARIANCE = 0.05
TURN_SHARE = 0.15  # of its half width, what an edge on a rounding is turned by, one sd
LEAST_LINE_VARIANCE_PX2 = 1e-6  # of a line in one channel, so that its precision is finite


class LineFits(NamedTuple):
    """Two numbers for each of M lines that a channel sees: its offset and its turn, px at its ends.

    Attributes
    ----------
    value, variance : (M, 2), and the variance by what scatters along the line, px^2.
    rows : (M, 2, LINE_UNKNOWNS), what a step of the pose (see `Observation`), the two nuisances and a metre
        of edge radius change.
    slack : (M,), px per metre of radius, to either side, within which a rounded edge may be seen.
    line : (M,), of the model.
    """

    value: Floats
    variance: Floats
    rows: Floats
    slack: Floats
    line: Ints


class StraightFit(NamedTuple):
    """A straight line through edge points: px across the model's line, by the place along it."""

    middle: float  # place along the line
    offset: float  # px there
    turn: float  # px more at the line's end
    spread: float  # weighted variance of the places along the line
    scatter: float  # weighted variance across it, px^2
    total: float  # sum of the weights
    squares: float  # and of their squares


@kernel()
def _straight(along: Floats, place: Floats, base: Floats, weight: Floats) -> StraightFit:
    """A robust fit, by reweighting, to places along and across a line; all (K,), ``weight`` is written to."""
    known = base > 0.0
    x, y, first = along[known], place[known], base[known]
    own, off, middle, offset, turn, spread, total = first, y, 0.0, 0.0, 0.0, 0.0, 0.0
    for fit in range(LINE_ITERATIONS):
        if fit > 0:
            own = first / (1.0 + (off / HALF_WEIGHT_PX) * (off / HALF_WEIGHT_PX))
        total = own.sum()
        middle, offset = (own * x).sum() / total, (own * y).sum() / total
        across = x - middle
        spread = (own * (across * across) / total).sum()
        turn = (own * across * y / total).sum() / spread if spread > LEAST_PLACE_VARIANCE else 0.0
        off = y - offset - turn * across
    weight[:] = 0.0
    weight[known] = own
    scatter = (own * (off * off) / total).sum()
    return StraightFit(middle, offset, turn, spread, scatter, total, (own * own).sum())


@kernel()
def line_fits(seen: Observation, base: Floats, rounding: Floats, slack: Floats) -> LineFits:
    """Robust straight fits to the edge points along each line, in each channel.

    Parameters
    ----------
    base : (C, N), weights of the edge points, 1/px^2.
    rounding, slack : (N,), see `rounding_shifts`.
    """
    line, count = seen.samples.line, base.shape[1]
    most = len(base) * seen.sigma.shape[1]
    value, variance, rows = np.zeros((most, 2)), np.zeros((most, 2)), np.zeros((most, 2, LINE_UNKNOWNS))
    weight, loose, found = np.zeros(count), np.zeros(most), 0
    number = np.zeros(most, dtype=np.int64)
    change = np.empty((count, LINE_UNKNOWNS))
    change[:, :6], change[:, RADIUS] = seen.jacobian, rounding
    for c in range(len(base)):
        change[:, 6:RADIUS] = seen.nuisance[c]
        start = 0
        while start < count:
            end, points = start, 0
            while end < count and line[end] == line[start]:
                points += base[c, end] > 0.0
                end += 1
            if points >= FEWEST_LINE_POINTS:
                along = seen.along[start:end]
                fit = _straight(along, seen.offset[c, start:end], base[c, start:end], weight[start:end])
                share, turned = points / (end - start), fit.spread > LEAST_PLACE_VARIANCE
                doubt = (1.0 + fit.scatter / HALF_TRUST_SCATTER_PX**2) / (share * share)
                noise = doubt * fit.scatter * SAMPLES_TOGETHER * fit.squares / fit.total**2
                value[found, 0], value[found, 1] = fit.offset, fit.turn
                variance[found, 0] = noise
                variance[found, 1] = noise / fit.spread if turned else math.inf
                number[found] = line[start]
                for i in range(start, end):
                    own = weight[i] / fit.total
                    across = own * (seen.along[i] - fit.middle) / fit.spread if turned else 0.0
                    loose[found] += own * slack[i]
                    for k in range(LINE_UNKNOWNS):
                        rows[found, 0, k] += own * change[i, k]
                        rows[found, 1, k] += across * change[i, k]
                found += 1
            start = end
    return LineFits(value[:found], variance[:found], rows[:found], loose[:found], number[:found])


def united(lines: LineFits) -> LineFits:
    """One of each line, whatever channels see it: what it is off, it is off in all of them."""
    _, first, number = np.unique(lines.line, return_index=True, return_inverse=True)
    count, precision = len(first), 1.0 / np.maximum(lines.variance, LEAST_LINE_VARIANCE_PX2)
    total = np.stack([np.bincount(number, precision[:, k], count) for k in range(2)], axis=1)
    share = precision / np.where(total > 0.0, total, 1.0)[number]
    value, rows, slack = np.zeros((count, 2)), np.zeros((count, 2, LINE_UNKNOWNS)), np.zeros(count)
    np.add.at(value, number, share * lines.value)
    np.add.at(rows, number, share[:, :, None] * lines.rows)
    np.add.at(slack, number, share[:, 0] * lines.slack)
    variance = np.where(total > 0.0, 1.0 / np.where(total > 0.0, total, 1.0), np.inf)
    return LineFits(value, variance, rows, slack, lines.line[first])


def rounding_shifts(problem: PoseProblem, pose: Pose, seen: Observation) -> tuple[Floats, Floats]:
    """Shift and slack of each sample, (N,), px per metre of radius, see `pose.roundings`."""
    shift, slack = roundings(problem.model, problem.camera, pose, seen.samples)
    return shift, slack


def on_roundings(lines: LineFits, seen: Observation) -> LineFits:
    """With what is not known of edges on roundings of a known radius, which are moved by what is."""
    line, count = seen.samples.line, seen.sigma.shape[1]
    samples = np.maximum(np.bincount(line, minlength=count), 1)
    place, turn = (
        (np.bincount(line, px, count) / samples)[lines.line] ** 2
        for px in (seen.tolerance, TURN_SHARE * seen.slack)
    )
    more = np.stack([place, turn], axis=1)
    return lines._replace(variance=lines.variance + more, slack=np.zeros(len(lines.slack)))
