"""Densities of log-ratios that kinds of edges are told by, and the logarithms they are of.

A sum of logarithms over the channels is taken as the logarithm of a product: that says the same at a third of
the time.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vision_server.edges.sides import Sides

Floats = NDArray[np.float64] | NDArray[np.float32]

UNKNOWN_SD = 10.0  # of a log-ratio, where a side is clipped
FACTORS = 8  # so many values within what float32 holds have a product that float64 holds


def either(first: Floats | float, second: Floats) -> Floats:
    """Logarithm of the sum of what two logarithms are of: `np.logaddexp`, at many times its speed."""
    return np.asarray(np.maximum(first, second) + np.log(1.0 + np.exp(-np.abs(first - second))))


def any_of(values: Floats) -> Floats:
    """Logarithm (N,) of the mean over the rows (L, N) of what logarithms are of: each is as likely."""
    most = values.max(axis=0)
    return np.asarray(most + np.log(np.exp(values - most).sum(axis=0) * (1.0 / len(values))))


def sum_of_logs(values: Floats) -> NDArray[np.float32]:
    """Sum over the rows (C, N) of the logarithms of values within what float32 holds, float32 (N,)."""
    parts = range(0, len(values), FACTORS)
    products = [np.multiply.reduce(values[part : part + FACTORS], dtype=np.float64) for part in parts]
    return np.asarray(sum(np.log(product) for product in products), np.float32)


def log_normal(x: Floats, variance: Floats) -> Floats:
    """Logarithm of the density of a Gaussian of mean 0."""
    return np.asarray(-0.5 * (x * x / variance + np.log(2.0 * np.pi * variance)))


def normal(x: Floats, variance: Floats) -> Floats:
    """Density of a Gaussian of mean 0."""
    return np.asarray(np.exp(-0.5 * x * x / variance) / np.sqrt(2.0 * np.pi * variance))


class Scatter(NamedTuple):
    """What is needed of values (C, N) of known variances to say how likely they are; (N,) each.

    Attributes
    ----------
    alone
        Logarithm of their density as Gaussians of mean 0.
    precision, pull
        Sums of 1 / variance, and of value / variance.
    """

    alone: Floats
    precision: Floats
    pull: Floats

    @classmethod
    def of(cls, x: Floats, variance: Floats) -> Scatter:
        """Of values (C, N) and their variances."""
        precision = 1.0 / variance
        pull = x * precision
        alone = -0.5 * (np.sum(pull * x, axis=0) + sum_of_logs(2.0 * np.pi * variance))
        return cls(alone, precision.sum(axis=0), pull.sum(axis=0))

    def about_a_mean(self, sd: float) -> Floats:
        """Log-likelihood (N,) that they scatter about a mean for each column, which itself is N(0, sd^2)."""
        wider = 1.0 + sd**2 * self.precision
        return np.asarray(self.alone + 0.5 * (sd * self.pull) ** 2 / wider - 0.5 * np.log(wider))


def logarithms(sides: Sides) -> tuple[Floats, Floats]:
    """Logarithms of the intensities (C, 2, N), and the variance (C, N) of their difference from noise.

    Where both sides are dark or one is clipped the difference says nothing, and its variance is large.
    """
    near = np.maximum(sides.near, 0.0) + np.float32(sides.dark)
    noise = np.sum(np.square(sides.noise[:, None] / near), axis=1)
    unlit = np.square(np.square(np.float32(sides.dark) / near.max(axis=1)))
    return np.log(near), noise + unlit + np.where(sides.known, np.float32(0.0), np.float32(UNKNOWN_SD**2))
