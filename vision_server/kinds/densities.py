"""Densities of log-ratios that kinds of edges are told by, and the logarithms they are of.

A sum of logarithms over the channels is taken as the logarithm of a product: that says the same at a third of
the time.
"""

from __future__ import annotations

import numpy as np

from numerics.arrays import Field, Reals
from numerics.kernels import kernel
from numerics.logarithm import HALF, ONE, ZERO, log_of
from vision_server.kinds.sides import Sides

TAU = np.float32(2.0 * np.pi)
UNKNOWN_SD = 10.0  # of a log-ratio, where a side is clipped
FACTORS = 8  # so many values within what float32 holds have a product that float64 holds


def either(first: Reals | float, second: Reals) -> Reals:
    """Logarithm of the sum of what two logarithms (...) are of: `np.logaddexp`, at many times its speed."""
    return np.asarray(np.maximum(first, second) + np.log(1.0 + np.exp(-np.abs(first - second))))


def any_of(values: Reals) -> Reals:
    """Logarithm (N,) of the mean over the rows (L, N) of what logarithms are of: each is as likely."""
    most = values.max(axis=0)
    return np.asarray(most + np.log(np.exp(values - most).sum(axis=0) * (1.0 / len(values))))


def sum_of_logs(values: Reals) -> Field:
    """Sum over the rows (C, N) of the logarithms of values within what float32 holds, float32 (N,)."""
    parts = range(0, len(values), FACTORS)
    products = [np.multiply.reduce(values[part : part + FACTORS], dtype=np.float64) for part in parts]
    return np.asarray(sum(np.log(product) for product in products), np.float32)


def normal(x: Reals, variance: Reals) -> Reals:
    """Density of a Gaussian of mean 0."""
    return np.asarray(np.exp(-0.5 * x * x / variance) / np.sqrt(2.0 * np.pi * variance))


def logarithms(sides: Sides) -> tuple[Reals, Reals]:
    """Logarithms of the intensities (C, 2, N), and the variance (C, N) of their difference from noise.

    Where both sides are dark or one is clipped the difference says nothing, and its variance is large.
    """
    near = np.maximum(sides.near, 0.0) + np.float32(sides.dark)
    noise = np.sum(np.square(sides.noise[:, None] / near), axis=1)
    unlit = np.square(np.square(np.float32(sides.dark) / near.max(axis=1)))
    return np.log(near), noise + unlit + np.where(sides.known, np.float32(0.0), np.float32(UNKNOWN_SD**2))


@kernel(inline="always")
def log_normal(x: np.float32, variance: np.float32) -> np.float32:
    """Logarithm of the density of a Gaussian of mean 0, in kernels."""
    return -HALF * (x * x / variance + log_of(TAU * variance))


@kernel(inline="always")
def of_a_mean(precision: np.float32, pull: np.float32, variance: np.float32) -> np.float32:
    """How much likelier Gaussian values are if they have a mean that is N(0, variance), in kernels.

    A logarithm, beside their density about 0; from the sums of 1 / variance and of value / variance.
    """
    wider = ONE + variance * precision
    return HALF * (variance * pull * pull / wider - log_of(wider))


@kernel(inline="always")
def ratio_of(
    first: np.float32, second: np.float32, noise: np.float32, dark: np.float32
) -> tuple[np.float32, np.float32]:
    """Log-ratio of two intensities, and its variance from noise: `logarithms` where neither is clipped."""
    a, b = max(first, ZERO) + dark, max(second, ZERO) + dark
    unlit = dark / max(a, b)
    unlit *= unlit
    return log_of(a / b), noise * noise * (ONE / (a * a) + ONE / (b * b)) + unlit * unlit
