"""What is said of more images: the mean ratio of the errors, where both poses are right."""

import numpy as np
import pytest

from benchmarks.more_images import ratio


def test_the_ratio_is_of_pairs_that_are_right() -> None:
    before = np.array([[0.1, 0.2], [0.4, 2.0]])
    after = np.array([[0.2, 0.1], [0.4, 0.1]])
    mean, interval = ratio(before, after)
    assert mean == pytest.approx(1.0)
    assert interval == [1.0, 1.0]


def test_the_interval_holds_what_stacks_differ_in() -> None:
    before = np.full((20, 1), 0.1)
    after = before * np.geomspace(0.5, 2.0, 20)[:, None]
    mean, (low, high) = ratio(before, after)
    assert mean == pytest.approx(1.0, abs=1e-3)
    assert 0.7 < low < 1.0 < high < 1.4
