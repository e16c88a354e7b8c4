"""Blur found on the image itself."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from numerics.arrays import Grey
from vision_server.channels.blur import (
    SAMPLE_STEP,
    STRONGEST_SHARE,
    blur_sigma,
    halved,
    least_strong,
    lone_edge_blur,
)


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


def test_a_sharp_image_is_sharp() -> None:
    assert blur_sigma(halved(squares(0.0))) < 1.2
    assert blur_sigma(halved(squares(0.0, noise=6.0))) < 1.2


def before_lines(grey: float, apart_px: int) -> Grey:
    """A bar of that grey beside lines so many px apart whose contrast grows to the right; 3 px of blur."""
    image = np.full((240, 320), 30.0)
    image[:, 120:] += np.linspace(0.0, 190.0, 200) * (np.arange(240) // apart_px % 2)[:, None]
    image[20:220, 20:60] = grey
    return np.asarray(np.round(gaussian_filter(image, 3.0)), np.uint8)


def test_lines_that_run_beside_each_other_tell_no_blur() -> None:
    """Blurred into each other they are as steep as if they were sharp; edges that stand alone are not."""
    weak, strong = halved(before_lines(110.0, 7)), halved(before_lines(150.0, 8))
    assert blur_sigma(weak) < 0.1
    assert lone_edge_blur(weak) is None
    assert lone_edge_blur(strong) == pytest.approx(3.0, rel=0.15)


@pytest.mark.parametrize("blur_px", [0.0, 2.0, 5.0])
def test_where_all_edges_stand_alone_they_tell_the_same(blur_px: float) -> None:
    half = halved(squares(blur_px))
    assert lone_edge_blur(half) == pytest.approx(blur_sigma(half), abs=0.2)


def test_without_edges_nothing_is_said() -> None:
    assert lone_edge_blur(halved(np.full((100, 100), 30, np.uint8))) is None
    assert lone_edge_blur(halved(np.zeros((3, 3), np.uint8))) is None
    assert blur_sigma(halved(np.full((100, 100), 30, np.uint8))) == 0.0
    assert blur_sigma(halved(np.zeros((3, 3), np.uint8))) == 0.0


@pytest.mark.parametrize("shape", [(41, 33), (8, 64)])
def test_the_least_of_the_strong_slopes_is_that_of_the_sorted_ones(shape: tuple[int, int]) -> None:
    slope = np.random.default_rng(1).integers(0, 400, shape).astype(np.int16)
    ranked = np.sort(slope[::SAMPLE_STEP], axis=None)
    assert least_strong(slope) == ranked[-max(int(STRONGEST_SHARE * len(ranked)), 1)]
    assert least_strong(np.zeros(shape, np.int16)) == 1
