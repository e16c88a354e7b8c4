"""Places of set flags, against NumPy."""

import numpy as np
import pytest

from numerics.flags import set_places


@pytest.mark.parametrize("share", [0.0, 0.02, 0.6, 1.0])
def test_places_are_those_of_numpy(share: float) -> None:
    flags = np.random.default_rng(1).random(640) < share
    for kind in (np.int32, np.int64):
        places = np.empty(len(flags), kind)
        count = set_places(flags, places)
        assert places[:count].tolist() == np.flatnonzero(flags).tolist()
