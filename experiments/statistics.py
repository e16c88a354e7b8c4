"""Intervals of strategies that were tried on the same scenes with the same seeds.

A strategy's outcomes are a matrix, scenes by seeds, with gaps where a cell has no row. Scenes differ, and so
do seeds: one seed draws the same numbers in every scene. Both are resampled, each on its own (the pigeonhole
bootstrap of Owen, "The pigeonhole bootstrap", Annals of Applied Statistics 1(2), 2007, whose variance is
slightly too large rather than too small). Where the seed draws the scene, scenes alone are.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import bdtr, betaincinv, ndtri  # loads in a quarter of the time of scipy.stats

from numerics.arrays import Floats

LEVEL = 0.95  # of all intervals, by custom
SEED = 0  # of the resampling
REPLICATES = 4000  # the ends of a 95 % interval are then known to a twentieth of its width
LEAST_SCENES = 6  # fewer cannot differ in sign by chance in less than 5 % of cases (2 / 2^n)
MOST_RESAMPLED = 2000  # outcomes; of more, the same variance is computed in closed form
POWER = 0.8  # by custom
POINTS = 0.05  # the difference that a plan should see


@dataclass(frozen=True)
class IntervalEstimate:
    """A mean and its interval, of `n` cells in `scenes` scenes.

    The interval is NaN where there are too few scenes to say anything.
    """

    value: float
    low: float
    high: float
    n: int
    scenes: int
    standard_error: float = math.nan

    @property
    def differs_from_zero(self) -> bool:
        """Whether the interval excludes zero."""
        return self.low > 0.0 or self.high < 0.0


def exact_interval(successes: int, n: int) -> tuple[float, float]:
    """Interval of a proportion after Clopper and Pearson (Biometrika 26, 1934), of independent cells."""
    if n == 0:
        return math.nan, math.nan
    tail = (1.0 - LEVEL) / 2.0
    low = 0.0 if successes == 0 else float(betaincinv(successes, n - successes + 1, tail))
    high = 1.0 if successes == n else float(betaincinv(successes + 1, n - successes, 1.0 - tail))
    return low, high


def resampled(outcomes: Floats) -> IntervalEstimate:
    """Mean of a matrix of outcomes and the interval that scenes and seeds leave it.

    Parameters
    ----------
    outcomes
        (scenes, seeds), NaN where there is none.

    Returns
    -------
    IntervalEstimate
        With a percentile interval, or the normal one of the same variance where there are very many
        outcomes; NaN where fewer than LEAST_SCENES scenes have one.
    """
    there = np.isfinite(outcomes)
    outcomes, there = outcomes[there.any(axis=1)], there[there.any(axis=1)]
    n, scenes = int(there.sum()), len(outcomes)
    if n == 0:
        return IntervalEstimate(math.nan, math.nan, math.nan, 0, 0)
    values = np.where(there, outcomes, 0.0)
    mean = float(values.sum() / n)
    if scenes < LEAST_SCENES:
        return IntervalEstimate(mean, math.nan, math.nan, n, scenes)
    if (there.sum(axis=1) <= 1).all():  # each scene has the seed that drew it
        values, there = values.sum(axis=1, keepdims=True), there.sum(axis=1, keepdims=True) > 0
    if values.size > MOST_RESAMPLED:
        error = _standard_error(values - mean * there, values.shape[1] > 1) / n
        reach = error * float(ndtri((1.0 + LEVEL) / 2.0))
        return IntervalEstimate(mean, mean - reach, mean + reach, n, scenes, error)
    rng = np.random.default_rng(SEED)
    rows = rng.multinomial(scenes, np.full(scenes, 1.0 / scenes), REPLICATES).astype(np.float64)
    seeds = values.shape[1]
    columns = rng.multinomial(seeds, np.full(seeds, 1.0 / seeds), REPLICATES).astype(np.float64)
    weight = ((rows @ there.astype(np.float64)) * columns).sum(axis=1)
    total = ((rows @ values) * columns).sum(axis=1)
    means = total[weight > 0] / weight[weight > 0]
    low, high = np.quantile(means, [(1.0 - LEVEL) / 2.0, (1.0 + LEVEL) / 2.0])
    return IntervalEstimate(mean, float(low), float(high), n, scenes, float(means.std(ddof=1)))


def _standard_error(residuals: Floats, with_seeds: bool) -> float:
    """Of the sum of residuals (scenes, seeds) when rows, and columns if wanted, get weights of variance 1.

    Var(sum W_s V_k e_sk) = sum_s e_s.^2 + sum_k e_.k^2 + sum_sk e_sk^2.
    """
    variance = float((residuals.sum(axis=1) ** 2).sum())
    if with_seeds:
        variance += float((residuals.sum(axis=0) ** 2).sum() + (residuals**2).sum())
    return math.sqrt(variance)


def paired(ours: Floats, theirs: Floats) -> IntervalEstimate:
    """Mean difference over the cells that both have; the interval as of `resampled`."""
    return resampled(ours - theirs)


def mcnemar(ours: Floats, theirs: Floats) -> tuple[int, int, float]:
    """Pairs that only one of two strategies gets right, and the exact two-sided probability of such a split.

    Of cells as if they were independent (McNemar, Psychometrika 12, 1947): beside the interval, not instead.
    """
    both = np.isfinite(ours) & np.isfinite(theirs)
    won = int((both & (ours > theirs)).sum())
    lost = int((both & (ours < theirs)).sum())
    return won, lost, min(1.0, 2.0 * float(bdtr(min(won, lost), won + lost, 0.5)))


def cells_needed(difference: IntervalEstimate, points: float = POINTS) -> int | None:
    """Pairs of cells, as those of `difference` are spread over scenes and seeds, that would show `points`.

    With POWER at the 5 % level; the standard error falls with the root of the number of scenes.
    None where it is not known.
    """
    if not difference.standard_error > 0.0:
        return None
    wanted = points / float(ndtri((1.0 + LEVEL) / 2.0) + ndtri(POWER))
    return math.ceil(difference.n * (difference.standard_error / wanted) ** 2)
