"""Blur found on the image itself."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from vision_server.channels.blur import blur_sigma, halved


def squares(blur_px: float, noise: float = 1.0) -> NDArray[np.uint8]:
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


def test_without_edges_nothing_is_said() -> None:
    assert blur_sigma(halved(np.full((100, 100), 30, np.uint8))) == 0.0
    assert blur_sigma(halved(np.zeros((3, 3), np.uint8))) == 0.0
