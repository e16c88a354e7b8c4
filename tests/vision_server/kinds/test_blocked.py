"""Lights of known levels that are blocked: what runs is what is defined."""

from __future__ import annotations

import numpy as np
import pytest

from tests.vision_server.level_samples import edgels_of
from vision_server.kinds.blocked import DEPTH_SD, one_blocked, shadow_of_one
from vision_server.kinds.densities import any_of, logarithms


@pytest.mark.parametrize("channels", [2, 4, 12])
def test_the_likelihood_of_each_light_is_the_defined_one(channels: int) -> None:
    random = np.random.default_rng(channels)
    near = (150.0 * random.random((channels, 2, 500)) ** 3).astype(np.float32)
    noise = (0.2 + random.random((channels, 500))).astype(np.float32)
    sides = edgels_of(near, 1.0)._replace(noise=noise, known=random.random((channels, 500)) < 0.9)
    lights = np.column_stack([random.random((channels, 3)), np.ones(channels)])
    logs, variance = logarithms(sides)
    for some in (lights, lights[:, :1]):
        defined = [one_blocked(sides, logs, variance, light, DEPTH_SD) for light in some.T.copy()]
        found = shadow_of_one(sides, logs, variance, some, DEPTH_SD)
        np.testing.assert_allclose(found, any_of(np.asarray(defined)), rtol=1e-5, atol=1e-3)
