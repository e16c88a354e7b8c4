"""What two pictures under the same settings are said to differ by, in a scene of which all is known."""

from collections import Counter

import numpy as np

from benchmarks.planted_faults import opened
from benchmarks.repeated_pictures import FLICKERS, compared, flicker, settings_of


def test_settings_are_what_the_device_offers_and_the_lights_of_the_first_differ() -> None:
    describe = opened("nominal", 1)[0].describe()
    first, *others = settings_of(describe)
    assert len(set(first.lights)) == len(first.lights)
    for one in (first, *others):
        assert one.shutter_s in describe.shutters_s
        assert one.aperture in describe.apertures


def test_pairs_of_mild_light_are_told_apart() -> None:
    count: Counter[tuple[str, str]] = Counter()
    compared("nominal", np.random.default_rng(0), count)
    assert count["nothing", "neither"] == count["nothing", "pairs"] == 4
    assert all(count[flicker(share), "neither"] == 4 for share in FLICKERS)
    assert count["target_moved", "neither"] == 4
    assert count["in_the_way", "replaced"] >= 3
    assert count["light_dead", "relit"] == count["light_dead", "pairs"] == 3
