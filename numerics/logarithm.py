"""Logarithms and exponentials in kernels: no library call, no branch: loops fill vector registers."""

from __future__ import annotations

import numpy as np

from numerics.kernels import kernel

MANTISSA_BITS = np.int32(23)  # of float32
ROOT_HALF = np.int32(0x3F3504F3)  # the bits of sqrt(1/2): mantissas are taken from there to its double
LOG_2 = np.float32(np.log(2.0))
ZERO, ONE, TWO = np.float32(0.0), np.float32(1.0), np.float32(2.0)
THIRD, FIFTH, SEVENTH = np.float32(1 / 3), np.float32(1 / 5), np.float32(1 / 7)
HALF, SIXTH = np.float32(1 / 2), np.float32(1 / 6)
PART = np.float32(1 / 256)  # exp(x) is exp(x / 256), squared eight times
MOST = np.float32(80.0)  # of an exponent: beyond, float32 holds nothing for long


@kernel(inline="always")
def log_of(x: np.float32) -> np.float32:
    """Natural logarithm of a float32 that is not negative, within 2e-6; of 0 it is -88.

    The exponent's part, and the series of atanh for the mantissa.
    """
    bits = np.float32(x).view(np.int32)
    exponent = np.int32((bits - ROOT_HALF) >> MANTISSA_BITS)
    mantissa = np.int32(bits - (exponent << MANTISSA_BITS)).view(np.float32)
    r = (mantissa - ONE) / (mantissa + ONE)
    z = r * r
    return np.float32(exponent) * LOG_2 + TWO * r * (ONE + z * (THIRD + z * (FIFTH + z * SEVENTH)))


@kernel(inline="always")
def exp_of(x: np.float32) -> np.float32:
    """Exponential of a float32 cut off at -80 and 80, within 0.1 % from -20 to 20."""
    y = min(max(x, -MOST), MOST) * PART
    power = ONE + y * (ONE + y * (HALF + y * SIXTH))
    for _ in range(8):
        power *= power
    return power


@kernel(inline="always")
def log_of_sum(first: np.float32, second: np.float32) -> np.float32:
    """Logarithm of the sum of what two logarithms are of: `np.logaddexp`."""
    return max(first, second) + log_of(ONE + exp_of(-abs(first - second)))
