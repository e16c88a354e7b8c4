"""What is marked in a row is listed, whatever its length."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from numerics.arrays import Flags
from numerics.kernels import kernel
from numerics.marks import list_marks, no_marks


@kernel()
def listed(flags: Flags) -> NDArray[np.int32]:
    marks = no_marks(len(flags))
    marks.marked[: len(flags)] = flags
    return marks.numbers[: list_marks(marks)].copy()


@pytest.mark.parametrize("count", [1, 7, 8, 9, 640])
@pytest.mark.parametrize("share", [0.0, 0.05, 0.5, 1.0])
def test_numbers_of_what_is_marked_are_listed(count: int, share: float) -> None:
    flags = np.random.default_rng(count).random(count) < share
    np.testing.assert_array_equal(listed(flags), np.flatnonzero(flags))
