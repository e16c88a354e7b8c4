"""Blur found on the image itself."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from numerics.arrays import Grey
from vision_server.channels.blur import SAMPLE_STEP, STRONGEST_SHARE, blur_sigma, halved, least_strong


def squares(blur_px: float, noise: float = 1.0) -> Grey:
    image = np.full((240, 320), 50.0)
    for row in range(3):
        for column in range(4):
            image[20 + 75 * row : 65 + 75 * row, 20 + 75 * column : 65 + 75 * column] = 190.0
    blurred = gaussian_filter(image, blur_px) if blur_px else image
    noisy = np.round(blurred + np.random.default_rng(0).normal(0, noise, image.shape))
    return np.asarray(np.clip(noisy, 0, 255), dtype=np.uint8)


@pytest.mark.parametrize("blur_px", [2.0, 3.0, 4.0, 5.0])
def test_blur_is_found(blur_px: float) -> None:
    assert blur_sigma(halved(squares(blur_px))) == pytest.approx(blur_px, rel=0.2)


@pytest.mark.parametrize("pitch_px", [12, 16])
@pytest.mark.parametrize("blur_px", [2.0, 4.0])
def test_lines_that_run_into_each_other_do_not_make_an_image_sharp(blur_px: float, pitch_px: int) -> None:
    image = np.where(np.arange(320) // (pitch_px // 2) % 2 == 0, 50.0, 190.0) * np.ones((240, 1))
    image[60:180, 100:220] = 90.0  # a plate before a wall of lines,
    image[90:150, 130:190] = 200.0  # and its inner edges, which stand alone
    noisy = gaussian_filter(image, blur_px) + np.random.default_rng(0).normal(0, 1.0, image.shape)
    assert blur_sigma(halved(np.asarray(np.round(noisy), np.uint8))) == pytest.approx(blur_px, rel=0.2)


def test_a_sharp_image_is_sharp() -> None:
    assert blur_sigma(halved(squares(0.0))) < 1.2
    assert blur_sigma(halved(squares(0.0, noise=6.0))) < 1.2


def test_without_edges_nothing_is_said() -> None:
    assert blur_sigma(halved(np.full((100, 100), 30, np.uint8))) == 0.0
    assert blur_sigma(halved(np.zeros((3, 3), np.uint8))) == 0.0


@pytest.mark.parametrize("shape", [(41, 33), (8, 64)])
def test_the_least_of_the_strong_slopes_is_that_of_the_sorted_ones(shape: tuple[int, int]) -> None:
    slope = np.random.default_rng(1).integers(0, 400, shape).astype(np.int16)
    ranked = np.sort(slope[::SAMPLE_STEP], axis=None)
    assert least_strong(slope, STRONGEST_SHARE) == ranked[-max(int(STRONGEST_SHARE * len(ranked)), 1)]
    assert least_strong(np.zeros(shape, np.int16), STRONGEST_SHARE) == 1
