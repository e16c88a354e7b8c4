"""Noise and scale found on the image itself."""

from __future__ import annotations

import numpy as np
import pytest

from numerics.arrays import Floats, Grey
from vision_server.channels.depth import ROUNDING_SD
from vision_server.channels.noise import (
    COARSEST_SCALE_PX,
    FINEST_SCALE_PX,
    SATURATED_GREY,
    clipping_grey,
    gradient_scale,
    grey_noise,
    sampled_greys,
)


def ramp_with_noise(read: float, shot: float, seed: int = 0) -> Grey:
    grey = np.tile(np.linspace(20, 235, 400), (300, 1))
    sd = np.sqrt(read**2 + shot * grey)
    return np.clip(np.round(grey + np.random.default_rng(seed).normal(0, 1, grey.shape) * sd), 0, 255).astype(
        np.uint8
    )


@pytest.mark.parametrize(("read", "shot"), [(2.0, 0.0), (6.0, 0.0), (1.0, 0.1), (0.0, 0.3)])
def test_noise_is_found_at_each_grey(read: float, shot: float) -> None:
    found = grey_noise(ramp_with_noise(read, shot))
    for grey in (50, 120, 200):
        true = np.sqrt(read**2 + shot * grey + ROUNDING_SD**2)
        assert found[grey] == pytest.approx(true, rel=0.15)


def test_edges_are_not_noise() -> None:
    image = np.full((200, 200), 60, np.uint8)
    image[50:150, 50:150] = 200
    assert grey_noise(image).max() == pytest.approx(ROUNDING_SD)


@pytest.mark.parametrize("shape", [(3, 3), (5, 5), (3, 400), (400, 3), (7, 9)])
def test_small_images_have_quantisation_noise(shape: tuple[int, int]) -> None:
    assert grey_noise(np.full(shape, 90, np.uint8)) == pytest.approx(np.full(256, ROUNDING_SD))


def test_scale_grows_with_noise_over_contrast() -> None:
    clean, noisy, drowned = (ramp_with_noise(read, 0.0) for read in (0.5, 12.0, 60.0))
    scales = [
        gradient_scale(image, grey_noise(image), sampled_greys(image)) for image in (clean, noisy, drowned)
    ]
    assert scales[0] == FINEST_SCALE_PX
    assert scales[0] < scales[1] < scales[2] <= COARSEST_SCALE_PX


@pytest.mark.parametrize("deep", [False, True])
def test_an_image_that_was_scaled_clips_below_white(deep: bool) -> None:
    random = np.random.default_rng(0)
    faces = np.repeat([60.0, 150.0, 240.0, 300.0], 80)
    noisy = np.clip(np.tile(faces, (200, 1)) + random.normal(0.0, 1.5, (200, 320)), 0.0, 255.0)

    def found(image: Floats) -> int:
        pixels = np.round(257.0 * image).astype(np.uint16) if deep else np.round(image).astype(np.uint8)
        return clipping_grey(sampled_greys(pixels), grey_noise(pixels))

    assert found(noisy) == SATURATED_GREY
    assert found(0.8 * noisy) == 204 - (255 - SATURATED_GREY)
    # neither where nothing is clipped, nor where there is no noise to show it
    assert found(0.8 * noisy[:, :240]) == SATURATED_GREY
    assert found(0.8 * np.tile(np.minimum(faces, 255.0), (200, 1))) == SATURATED_GREY


def test_a_rough_image_has_the_noise_of_its_median_however_large_that_is() -> None:
    rough = np.random.default_rng(0).choice(np.array([40, 200], np.uint8), (200, 320))
    smooth = np.random.default_rng(0).choice(np.array([100, 104], np.uint8), (200, 320))
    largest, usual = grey_noise(rough)[120], grey_noise(smooth)[102]
    assert largest == pytest.approx(40.0 * usual, rel=0.02)
