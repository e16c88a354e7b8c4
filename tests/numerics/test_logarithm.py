"""Logarithms and exponentials of kernels beside NumPy's."""

from __future__ import annotations

import numpy as np

from numerics.arrays import Field
from numerics.kernels import kernel
from numerics.logarithm import exp_of, log_of, log_of_sum


@kernel()
def _of_all(values: Field, logs: Field, exponentials: Field, sums: Field) -> None:
    for i in range(len(values)):
        logs[i], exponentials[i] = log_of(np.exp(values[i])), exp_of(values[i])
        sums[i] = log_of_sum(values[i], values[0])


def test_they_are_what_numpy_gives() -> None:
    values = np.linspace(-20.0, 20.0, 4001, dtype=np.float32)
    logs, exponentials, sums = np.empty((3, len(values)), np.float32)
    _of_all(values, logs, exponentials, sums)
    np.testing.assert_allclose(logs, values, atol=4e-6)
    np.testing.assert_allclose(exponentials, np.exp(values.astype(np.float64)), rtol=1e-3)
    np.testing.assert_allclose(sums, np.logaddexp(values.astype(np.float64), -20.0), atol=1e-4)


def test_nothing_overflows() -> None:
    values = np.array([-1e9, -500.0, 500.0], np.float32)
    logs, exponentials, sums = np.empty((3, 3), np.float32)
    _of_all(values, logs, exponentials, sums)
    assert (exponentials > 0.0).all() and np.isfinite(exponentials).all()
    np.testing.assert_allclose(sums, [-1e9, -500.0, 500.0])
    assert logs[0] < -80.0
