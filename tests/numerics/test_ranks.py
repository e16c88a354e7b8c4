"""Values by their rank are those that NumPy's quantiles of the nearest rank are."""

from __future__ import annotations

import numpy as np
import pytest

from numerics.ranks import at_share


@pytest.mark.parametrize("shape", [(1,), (7,), (20, 31)])
@pytest.mark.parametrize("share", [0.0, 0.02, 0.37, 0.97, 1.0])
def test_the_value_that_a_share_of_the_others_lie_under_is_the_quantile(
    shape: tuple[int, ...], share: float
) -> None:
    values = np.random.default_rng(0).normal(size=shape).astype(np.float32)
    before = values.copy()
    assert at_share(values, share) == np.quantile(values, share, method="nearest")
    np.testing.assert_array_equal(values, before)
