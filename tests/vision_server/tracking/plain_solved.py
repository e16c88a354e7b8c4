"""A fit to whole lines, as NumPy says it."""

from __future__ import annotations

import numpy as np

from numerics.arrays import Floats, Ints
from vision_server.tracking import fitting
from vision_server.tracking.fitting import (
    COMMON_SHARE,
    FIT_ITERATIONS,
    LEAST_FREE,
    TAIL,
    WIDER_BY,
    Habits,
    rounded_odds,
)
from vision_server.tracking.lines import LineFits


def plainly_solved(
    lines: LineFits, prior: Floats, habits: Habits, row: Ints
) -> tuple[Floats, Floats, float, tuple[float, float]]:
    """See `fitting.solved`."""
    known = lines.variance.ravel() < np.inf
    value, scatter = lines.value.ravel()[known], lines.variance.ravel()[known]
    slack = np.repeat(lines.slack, 2)[known] ** 2 / 3.0
    radius_m2 = habits.radius_m**2  # expected square of the radius
    rows = lines.rows.reshape(-1, 9)[known]
    member = np.stack([row, np.zeros_like(row)], axis=1).ravel()[known]
    together = np.sign(member)[:, None] * np.sign(member) * (np.abs(member)[:, None] == np.abs(member))
    pulled = np.zeros(9)
    pulled[8] = prior[8] * habits.radius_m
    off_px2, factor, own, left = habits.off_px2, np.ones(len(value)), 0.0, 0.0
    step: Floats = np.zeros(9)
    covariance: Floats = np.eye(9)
    told = (0.0, 0.0)
    for _ in range(FIT_ITERATIONS):
        noise = scatter + slack * radius_m2
        variance = noise + off_px2
        alone = variance - COMMON_SHARE * off_px2 * (member != 0)
        common = COMMON_SHARE * off_px2 * together  # covariance of what lines of a row share
        precision = np.linalg.inv(np.diag(alone / factor) + common)
        weighted = precision @ rows
        covariance = np.asarray(np.linalg.inv(weighted.T @ rows + np.diag(prior)))
        step = covariance @ (weighted.T @ value + pulled)
        told = (1.0 / covariance[8, 8] - prior[8], step[8] / covariance[8, 8] - pulled[8])
        step, covariance = fitting.none_or_rounded(
            step, covariance, habits.at_first_m, rounded_odds(own, left)
        )
        radius_m2 = float(step[8]) ** 2 + float(covariance[8, 8])
        residual = value - rows @ step
        free = 1.0 - ((rows @ covariance) * rows).sum(axis=1) * factor / alone
        left = max(float(free.sum()), 0.0)
        free = np.maximum(free, LEAST_FREE)
        apart = residual - common @ precision @ residual
        factor = (TAIL + 1.0) / (TAIL + apart**2 / alone)
        share = off_px2 / variance
        squares = float((share * np.maximum(factor * residual**2 / free - noise, 0.0)).sum())
        own = squares / max(float(share.sum()), 1e-9)
        off_px2 = (habits.seen * habits.off_px2 + squares) / (habits.seen + float(share.sum()))
    covariance[:6, :6] *= 1.0 + WIDER_BY / (2.0 * habits.seen + left)
    return step, covariance, own, told
