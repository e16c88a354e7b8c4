"""Exposures fused, and exposure driven by gradients."""

import numpy as np
import pytest

from vision_server.baselines.exposures import exposure_fusion, gradient_information, richest_gamma

STEPS = np.repeat(np.linspace(0.02, 1.0, 16), 8)[None].repeat(64, axis=0)  # linear brightness of stripes


def photograph(exposure: float) -> np.ndarray:
    return np.asarray(np.clip(255.0 * STEPS * exposure, 0, 255), dtype=np.uint8)


def test_a_fused_image_shows_what_dark_and_glaring_ones_hide() -> None:
    dark, bright = photograph(0.15), photograph(5.0)
    fused = exposure_fusion([dark, bright])

    def steps_seen(image: np.ndarray) -> int:
        return int((np.abs(np.diff(image[32].astype(int))) >= 2).sum())

    assert fused.dtype == np.uint8
    assert steps_seen(bright) < 5
    assert steps_seen(fused) > steps_seen(bright)


def test_one_image_is_its_own_fusion() -> None:
    image = photograph(0.7)
    assert np.abs(exposure_fusion([image]).astype(int) - image).max() <= 2


@pytest.mark.parametrize(("exposure", "wants"), [(0.08, "more"), (3.0, "less")])
def test_a_dark_image_wants_light_and_a_glaring_one_less(exposure: float, wants: str) -> None:
    gamma = richest_gamma(photograph(exposure))
    assert (gamma < 0.9) if wants == "more" else (gamma > 1.0)


def test_where_there_is_no_gradient_brightness_decides() -> None:
    dark, bright = (np.full((40, 40), grey, dtype=np.uint8) for grey in (3, 255))
    assert richest_gamma(dark) < 1.0 < richest_gamma(bright)


def test_weak_gradients_count_nothing() -> None:
    ramp = np.linspace(0.0, 0.5, 200, dtype=np.float32)[None].repeat(20, axis=0)
    assert gradient_information(ramp) == 0.0
    assert gradient_information(STEPS.astype(np.float32)) > 0.0
