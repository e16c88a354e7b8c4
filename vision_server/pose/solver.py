"""The step of a pose that brings its lines onto their edge points: robust least squares with line biases.

An edge point lies d px from its model line, along the line's normal. A step x of the pose, with two factors
of what moves edges but not the pose, moves the line by a·x (a: a row of the Jacobian). Whatever else a line
as a whole is off moves all its edge points together, by b y, where y is an unknown of that line, of variance
1:

    d = a·x + b y + noise

x and every y are found by iteratively reweighted least squares with Tukey's weights; the y are eliminated
from the normal equations (their Schur complement). `solve_plainly` is this in NumPy, the definition;
`solve_reweighted` is the same compiled, and tests hold the one against the other.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from numerics.arrays import Floats, Ints
from numerics.cholesky import solve_positive
from numerics.kernels import kernel
from vision_server.channels.noise import MAD_TO_SD

SOLVER_ITERATIONS = 5  # of reweighting; more change a pose by less than its noise (chosen by hand)
TUKEY = 4.685  # 95 % efficient on Gaussian residuals (Holland & Welsch 1977)
FIRST_CUT_PX = 3.0  # of the first one, least: one farther off a line is not its own if most are on theirs
LEAST_SCALE_PX = 0.12  # of the residuals: what one edge point is off by at best, see SYSTEMATIC_SD_PX
SAMPLES_TOGETHER = 10.0  # neighbouring edge points that are worth one, when weighed against a prior
MEDIAN_BIN_PX, MEDIAN_BINS = 0.01, 2000  # of the histogram that medians are taken from
UNKNOWNS = 8  # rotation, translation, two nuisances


class Equations(NamedTuple):
    """C channels, N samples of lines; see the head of this file.

    Attributes
    ----------
    jacobian
        (N, 6), px per step of the pose (rad, m); the same for all channels.
    nuisance
        (C, N, 2), px per unit of the two other unknowns.
    offset
        (C, N), d, px; NaN where there is no edge point.
    bias
        (C, N), b, px.
    line
        (N,), the line of each sample, ascending.
    base
        (C, N), weights before residuals are known, 1/px^2; 0 where there is no edge point.
    prior
        (8,), precision of each unknown about 0: of noise, of which SAMPLES_TOGETHER samples are worth one.
    """

    jacobian: Floats
    nuisance: Floats
    offset: Floats
    bias: Floats
    line: Ints
    base: Floats
    prior: Floats


def solve_plainly(equations: Equations) -> tuple[Floats, Floats]:
    """The definition: step (8,) and final weights (C, N)."""
    channels, count = equations.base.shape
    pose_rows = np.broadcast_to(equations.jacobian, (channels, count, 6))
    rows = np.concatenate([pose_rows, equations.nuisance], axis=2)
    offset, bias = np.nan_to_num(equations.offset), equations.bias
    step: Floats = np.zeros(UNKNOWNS)
    weight = equations.base
    for iteration in range(SOLVER_ITERATIONS):
        residual = np.abs(offset - rows @ step)
        sigma = max(LEAST_SCALE_PX, MAD_TO_SD * weighted_median(residual, equations.base))
        cut = max(TUKEY * sigma, FIRST_CUT_PX if iteration == 0 else 0.0)
        weight = equations.base * np.maximum(0.0, 1.0 - (residual / cut) ** 2) ** 2
        normal = np.diag(SAMPLES_TOGETHER * equations.prior)
        pull = np.zeros(UNKNOWNS)
        for line in np.unique(equations.line):
            a, d = rows[:, equations.line == line], offset[:, equations.line == line]
            w, b = weight[:, equations.line == line], bias[:, equations.line == line]
            normal += np.einsum("ci,cij,cik->jk", w, a, a)
            pull += np.einsum("ci,ci,cij->j", w, d, a)
            coupling = np.einsum("ci,ci,cij->j", w, b, a)  # of the line's own unknown with the others
            own = SAMPLES_TOGETHER + np.sum(w * b * b)
            normal -= np.outer(coupling, coupling) / own
            pull -= coupling * np.sum(w * b * d) / own
        step = np.asarray(np.linalg.solve(normal, pull))
    return step, weight


@kernel()
def solve_reweighted(equations: Equations) -> tuple[Floats, Floats]:
    """`solve_plainly`, compiled."""
    weight = equations.base.copy()
    residual = np.empty(weight.shape)
    step = np.zeros(UNKNOWNS)
    for iteration in range(SOLVER_ITERATIONS):
        _residuals(equations, step, residual)
        sigma = max(LEAST_SCALE_PX, MAD_TO_SD * weighted_median(residual, equations.base))
        cut = max(TUKEY * sigma, FIRST_CUT_PX if iteration == 0 else 0.0)
        for c in range(len(weight)):
            for i in range(weight.shape[1]):
                if equations.base[c, i] > 0.0:
                    share = max(0.0, 1.0 - (residual[c, i] / cut) ** 2)
                    weight[c, i] = equations.base[c, i] * share * share
        normal, pull = _normal_equations(equations, weight)
        step = solve_positive(normal, pull, 0.0, 0.0)
    return step, weight


@kernel()
def _residuals(equations: Equations, step: Floats, out: Floats) -> None:
    """Distance (C, N) of edge points from their lines after a step, px; where there is one."""
    jacobian, nuisance, offset = equations.jacobian, equations.nuisance, equations.offset
    for c in range(len(out)):
        for i in range(out.shape[1]):
            if equations.base[c, i] > 0.0:
                expected = nuisance[c, i, 0] * step[6] + nuisance[c, i, 1] * step[7]
                for k in range(6):
                    expected += jacobian[i, k] * step[k]
                out[c, i] = abs(offset[c, i] - expected)


@kernel()
def _normal_equations(equations: Equations, weight: Floats) -> tuple[Floats, Floats]:
    """Matrix (8, 8), its lower triangle, and right-hand side (8,), with the lines' biases eliminated.

    The channels see the same motion of a sample: their weights are added up before it is squared.
    """
    channels, count = weight.shape
    jacobian, nuisance, line = equations.jacobian, equations.nuisance, equations.line
    normal, pull = np.diag(SAMPLES_TOGETHER * equations.prior), np.zeros(UNKNOWNS)
    coupling, own, product = np.zeros(UNKNOWNS), SAMPLES_TOGETHER, 0.0
    for i in range(count):
        total, pulled, biased, tone, clip = 0.0, 0.0, 0.0, 0.0, 0.0
        for c in range(channels):
            w = weight[c, i]
            if not w > 0.0:
                continue
            first, second = nuisance[c, i, 0], nuisance[c, i, 1]
            shift, bias = w * equations.offset[c, i], w * equations.bias[c, i]
            total += w
            pulled += shift
            biased += bias
            tone += w * first
            clip += w * second
            own += bias * equations.bias[c, i]
            product += bias * equations.offset[c, i]
            coupling[6] += bias * first
            coupling[7] += bias * second
            pull[6] += shift * first
            pull[7] += shift * second
            normal[6, 6] += w * first * first
            normal[7, 6] += w * first * second
            normal[7, 7] += w * second * second
        for k in range(6 if total > 0.0 else 0):
            value = jacobian[i, k]
            coupling[k] += biased * value
            pull[k] += pulled * value
            normal[6, k] += tone * value
            normal[7, k] += clip * value
            for m in range(k + 1):
                normal[k, m] += total * value * jacobian[i, m]
        if i + 1 == count or line[i + 1] != line[i]:
            for k in range(UNKNOWNS):
                pull[k] -= coupling[k] / own * product
                for m in range(k + 1):
                    normal[k, m] -= coupling[k] / own * coupling[m]
            coupling[:] = 0.0
            own, product = SAMPLES_TOGETHER, 0.0
    return normal, pull


@kernel()
def weighted_median(values: Floats, weights: Floats) -> float:
    """Median of values (C, N) >= 0 px with weights (C, N), 0: not counted.

    From a histogram of MEDIAN_BINS; values beyond count as its end.
    """
    histogram = np.zeros(MEDIAN_BINS)
    total = 0.0
    for c in range(len(values)):
        for i in range(values.shape[1]):
            if weights[c, i] > 0.0:
                histogram[min(MEDIAN_BINS - 1, int(values[c, i] / MEDIAN_BIN_PX))] += weights[c, i]
                total += weights[c, i]
    below = 0.0
    for k in range(MEDIAN_BINS):
        if total > 0.0 and below + histogram[k] >= 0.5 * total:
            return float(k + (0.5 * total - below) / histogram[k]) * MEDIAN_BIN_PX
        below += histogram[k]
    return 0.0
