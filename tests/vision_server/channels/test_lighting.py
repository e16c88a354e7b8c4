"""How lit a channel is: the formula, pixel by pixel."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import maximum_filter, minimum_filter

from vision_server.channels.lighting import (
    CLIPPED_STOPS,
    LIT_OFFSET_GREY,
    REACH,
    SHARPEST_PX,
    SHARPNESS_EXPONENT,
    WEIGHT_EXPONENT,
    lighting,
    smoothed,
)
from vision_server.channels.noise import SATURATED_GREY


@pytest.mark.parametrize("spread_px", [0.7, 2.0, 6.0])
@pytest.mark.parametrize("shape", [(1, 1), (5, 3), (40, 61)])
def test_weight_and_noise_are_their_formulas(spread_px: float, shape: tuple[int, int]) -> None:
    random = np.random.default_rng(1)
    half = random.integers(0, 256, shape).astype(np.uint8)
    linear_of, exposure = 255.0 * (np.arange(256) / 255.0) ** 2.2, 0.5
    noise_of = random.uniform(0.1, 3.0, 256).astype(np.float32)
    light = lighting(smoothed(half), linear_of, exposure, spread_px, noise_of)
    side = 2 * max(round(0.5 * REACH * spread_px), 1) + 1
    darkest, brightest = (extreme(light.level, side) for extreme in (minimum_filter, maximum_filter))
    stops = [np.log2((linear_of[grey] / exposure + LIT_OFFSET_GREY) / 128.0) for grey in (darkest, brightest)]
    clipped = brightest >= SATURATED_GREY
    log_weight = WEIGHT_EXPONENT * (np.mean(stops, axis=0) - CLIPPED_STOPS * clipped)
    log_weight += SHARPNESS_EXPONENT * np.log2(SHARPEST_PX / spread_px)
    np.testing.assert_allclose(np.log2(light.weight), log_weight, atol=1e-4)
    np.testing.assert_array_equal(light.brightest, brightest)
    np.testing.assert_array_equal(light.noise, noise_of[light.level])


def test_without_an_exponent_all_are_alike() -> None:
    half = np.random.default_rng(0).integers(0, 240, (20, 30)).astype(np.uint8)
    light = lighting(smoothed(half), np.arange(256.0), 1.0, SHARPEST_PX, np.ones(256, np.float32), 0.0)
    np.testing.assert_allclose(light.weight, 1.0, rtol=1e-6)
