"""Covariance of a refined pose, from the residuals of its edge points and how these hang together.

A sandwich estimator (Huber, White) that allows for residuals that are alike along a line (Newey and West).
Of a pose that has taken the last step the covariance is that of its lines as wholes: `settling`.
"""

from __future__ import annotations

import numpy as np

from geometry.pose import Pose, origin_jacobian
from geometry.rotation import cross_matrix, vector_of
from numerics.arrays import Floats, Ints
from vision_server.pose.refinement import LINE_BIAS_PX, Solution, line_biases, prior_precision
from vision_server.pose.solver import SAMPLES_TOGETHER

MOST_LAGS = 60  # chosen by hand: samples over which residuals of one line may hang together, 120 px and more
# Chosen by hand: samples that the pooled variance counts as, beside a line's own. More make all lines alike,
# fewer let a short line that fits by chance count for much.
POOLED_SAMPLES = 30.0
# Tukey's weights shrink the residuals that the variance is taken from, and cost the estimate a twentieth of
# its efficiency; for Gaussian residuals the variance so found is 0.79 of the one that the formula asks for.
TUKEY_VARIANCE_RATIO = 0.79
LEAST_SCATTER_PX2 = 0.02**2  # of edge points about their line: less is not believed (by hand)
POSE_DRAWS = 400  # of a pose from its covariance: shares are known to 2.5 % of the whole


def pose_covariance(solution: Solution) -> Floats:
    """Covariance (6, 6) of a small left-multiplied step (rotation rad, translation m) at the refined pose.

    The channels' edge points of one sample are combined to one residual (texture moves them together). With
    weights W, Jacobians J and the bias b that a whole line may have (`line_biases`), the estimate
    eliminates the biases: in its normal equations A = sum W J K' + prior, K is J less its part along the
    line's bias. With the residual variance v of each line and the correlation time L of the residuals along
    the lines (integral of their autocorrelation, in samples), its covariance is A^-1 (L sum W^2 v K K' +
    sum_lines g g') A^-1, where g = sum over a line of W b K.
    """
    return about_camera(unknowns_of(solution)[1][:6, :6], solution.observation.centre)


def about_camera(covariance: Floats, centre: Floats) -> Floats:
    """Covariance (6, 6) of left-multiplied steps, from that of steps that turn about ``centre``."""
    turn = np.eye(6)  # dt = v + centre x w
    turn[3:, :3] = cross_matrix(centre)
    covariance = turn @ covariance @ turn.T
    return np.asarray(0.5 * (covariance + covariance.T))


def unknowns_of(
    solution: Solution, more: Floats | None = None, more_sd: Floats | None = None
) -> tuple[Floats, Floats]:
    """Last step of all unknowns, (8 + K,), and their covariance as of `pose_covariance`.

    Parameters
    ----------
    more
        (N, K), px per unit of K unknowns beside the pose's and the nuisances', with standard deviations
        ``more_sd`` (K,) about 0.
    """
    seen = solution.observation
    weight = solution.weight.sum(axis=0)
    range_m = float(np.linalg.norm(solution.pose.translation))
    prior = np.diag(prior_precision(range_m, solution.tone_sd_px))
    if more is not None and more_sd is not None:
        prior = np.diag(np.r_[prior.diagonal(), more_sd**-2.0])
    used = weight > 0
    if not used.any():
        return np.zeros(len(prior)), np.asarray(np.linalg.inv(prior))
    shared = solution.weight / np.maximum(weight, 1e-300)
    nuisance = (shared[:, :, None] * seen.nuisance).sum(axis=0)
    bias = (shared * line_biases(seen)).sum(axis=0)[used]
    columns = [seen.jacobian, nuisance] if more is None else [seen.jacobian, nuisance, more]
    jacobian, weight = np.hstack(columns)[used], weight[used]
    line = seen.samples.line[used]
    offset = np.where(solution.weight > 0, seen.offset, 0.0)
    combined = (solution.weight * offset).sum(axis=0)[used] / weight
    rows, biased = _without_biases(jacobian, weight, bias, line)
    pull_of_prior = SAMPLES_TOGETHER * prior
    inverse = np.linalg.inv((jacobian * weight[:, None]).T @ rows + pull_of_prior)
    step = inverse @ (rows.T @ (weight * combined))
    residual = combined - jacobian @ step
    variance = _line_variances(residual, weight, line)
    together = _correlation_length(residual / np.sqrt(variance), line)
    middle = together * (rows * (weight**2 * variance)[:, None]).T @ rows + biased
    return step, np.asarray(inverse @ (middle + SAMPLES_TOGETHER * pull_of_prior) @ inverse)


def _without_biases(jacobian: Floats, weight: Floats, bias: Floats, line: Ints) -> tuple[Floats, Floats]:
    """Rows (N, 8) once each line's bias is eliminated, and what the biases leave in the estimate, (8, 8)."""
    first, number = _groups(line)
    pull = np.add.reduceat((weight * bias)[:, None] * jacobian, first)
    precision = SAMPLES_TOGETHER + np.add.reduceat(weight * bias**2, first)
    rows = jacobian - bias[:, None] * (pull / precision[:, None])[number]
    pull *= (SAMPLES_TOGETHER / precision)[:, None]
    together = np.add.reduceat((LINE_BIAS_PX * weight)[:, None] * rows, first)
    return rows, pull.T @ pull + together.T @ together


def _groups(line: Ints) -> tuple[Ints, Ints]:
    """First sample of each line, and how many lines came before each sample's; ``line`` (N,) ascending."""
    starts = np.r_[True, line[1:] != line[:-1]]
    return np.flatnonzero(starts), np.cumsum(starts) - 1


def _line_variances(residual: Floats, weight: Floats, line: Ints) -> Floats:
    """Residual variance of each sample's line, px^2, shrunk towards that of all lines, (N,)."""
    degrees = TUKEY_VARIANCE_RATIO * max(0.2, 1.0 - 6.0 / len(residual))
    pooled = float(weight @ residual**2 / weight.sum()) / degrees
    first, number = _groups(line)
    own = np.add.reduceat(weight * residual**2, first) / np.add.reduceat(weight, first) / degrees
    count = np.bincount(number)
    out = ((count * own + POOLED_SAMPLES * pooled) / (count + POOLED_SAMPLES))[number]
    return np.asarray(np.maximum(out, LEAST_SCATTER_PX2))


def _correlation_length(residual: Floats, line: Ints) -> float:
    """Number of neighbouring samples that are worth one independent one, from the pooled autocorrelation."""
    same = float(residual @ residual)
    length = 1.0
    for lag in range(1, min(MOST_LAGS, len(residual) - 1)):
        pairs = line[lag:] == line[:-lag]
        if pairs.sum() < 20:
            break
        value = float(residual[lag:][pairs] @ residual[:-lag][pairs]) / pairs.sum() / (same / len(residual))
        if value < 0.05:
            break
        length += 2.0 * value
    return length


def uncertainty(covariance: Floats, translation: Floats) -> float:
    """Largest standard deviation of the pose, as a share: 0.01 stands for 1 % of the range or for 1 degree.

    The larger of the largest axis of the target origin's position over its range, and the largest axis of the
    rotation in degrees over 100; of a pose's covariance (6, 6), and translation (3,), m.
    """
    origin = origin_jacobian(translation)
    position = np.linalg.eigvalsh(origin @ covariance @ origin.T)[-1]
    rotation = np.linalg.eigvalsh(covariance[:3, :3])[-1]
    range_m = float(np.linalg.norm(translation))
    return float(max(np.sqrt(max(position, 0.0)) / range_m, np.degrees(np.sqrt(max(rotation, 0.0))) / 100.0))


def share_within(
    limits: tuple[float, float], one: Pose, covariance: Floats, given: Pose | None = None
) -> float:
    """Share of the poses that one may stand for by its covariance (6, 6), that a given one is right for.

    Parameters
    ----------
    limits
        Degrees and share of the range, within which it is right.
    given
        Without it, the one itself.
    """
    given = one if given is None else given
    rng = np.random.default_rng(0)
    steps = rng.multivariate_normal(np.zeros(6), covariance, POSE_DRAWS, method="eigh")
    turn, shift, angle = steps[:, :3], steps[:, 3:], np.linalg.norm(steps[:, :3], axis=1)[:, None]
    across = np.cross(turn, one.translation)  # Rodrigues' formula
    moved = one.translation + np.sinc(angle / np.pi) * across
    moved += 0.5 * np.sinc(0.5 * angle / np.pi) ** 2 * np.cross(turn, across) + shift
    between = vector_of(given.matrix @ one.matrix.T)  # of small turns; larger ones are not within limits
    degrees = np.degrees(np.linalg.norm(between - turn, axis=1))
    apart = np.linalg.norm(given.translation - moved, axis=1) / np.linalg.norm(moved, axis=1)
    near = int(((degrees < limits[0]) & (apart < limits[1])).sum())
    return (near + 0.5) / (POSE_DRAWS + 1)
