"""Blooming: no pixel above its well, charge that is not lost twice, and the plain statement of the rule."""

import numpy as np
import pytest

from stack.blooming import bloomed

pytestmark = pytest.mark.slow


def plain(charge: np.ndarray, well: float, share: float) -> np.ndarray:
    """The same rule, one column and one pixel at a time."""
    out = np.minimum(charge, well).astype(float)
    for x in range(charge.shape[1]):
        for order in (range(charge.shape[0]), reversed(range(charge.shape[0]))):
            carried = 0.0
            for y in order:
                taken = min(carried, well - out[y, x])
                out[y, x] += taken
                carried += share / 2 * max(charge[y, x] - well, 0.0) - taken
    return out


def test_the_kernel_is_the_rule() -> None:
    charge = np.random.default_rng(2).exponential(0.6, (40, 30)).astype(np.float32)
    assert bloomed(charge, 1.0, 0.7) == pytest.approx(plain(charge, 1.0, 0.7), abs=1e-5)


def test_spilled_charge_stays_in_its_column_and_is_kept() -> None:
    charge = np.zeros((101, 5), np.float32)
    charge[50, 2] = 21.0
    out = bloomed(charge, 1.0, 1.0)
    assert out.max() <= 1.0
    assert out[:, [0, 1, 3, 4]].max() == 0
    assert out.sum() == pytest.approx(21.0, rel=1e-5)
    assert out[40:61, 2] == pytest.approx(1.0)


def test_a_good_drain_keeps_neighbours_as_they_are() -> None:
    charge = np.zeros((11, 3), np.float32)
    charge[5, 1] = 9.0
    assert np.array_equal(bloomed(charge, 1.0, 0.0), np.minimum(charge, 1.0))
