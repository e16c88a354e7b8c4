"""What a large image's gradient shows is found band by band, and is what the whole gradient shows."""

import numpy as np
import pytest

from vision_server.channels import bands
from vision_server.channels.bands import BAND_PIXELS, GradientRows
from vision_server.channels.channel import channel_statistics
from vision_server.channels.depth import Pixels, linear_image, linear_table
from vision_server.channels.gaussian import Kernels, contrast_kernels
from vision_server.channels.gradient_pixels import Gradient, gradient, pixels_of_rows
from vision_server.channels.narrow_gradient import narrow_pixels_of_rows, narrowed

HEIGHT, WIDTH = 1301, 1200  # of more than one band, and an odd last row


def image(deep: bool) -> Pixels:
    grey = np.random.default_rng(2).integers(20, 220, (HEIGHT, WIDTH)).astype(np.float32)
    return grey + np.float32(0.25) if deep else grey.astype(np.uint8)


@pytest.mark.parametrize("deep", [False, True])
@pytest.mark.parametrize(("gamma", "sigma_px"), [(1.0, 0.7), (2.2, 0.7), (2.2, 2.0)])
def test_bands_list_the_pixels_of_the_whole(deep: bool, gamma: float, sigma_px: float) -> None:
    grey, kernels = image(deep), contrast_kernels(sigma_px)
    level = np.random.default_rng(3).integers(0, 256, (HEIGHT // 2, WIDTH // 2)).astype(np.uint8)
    floor_of = np.linspace(20.0, 60.0, 256).astype(np.float32)
    linear = linear_image(grey, gamma, linear_table(gamma).astype(np.float32))
    whole = pixels_of_rows(gradient(linear, narrowed(kernels) or kernels), level, floor_of, 0, HEIGHT)
    assert grey.size > BAND_PIXELS
    made, cuts = GradientRows(grey, gamma, kernels), ((0, 845), (845, HEIGHT))
    parts = [made.pixels(level, floor_of, *rows) for rows in cuts]
    np.testing.assert_array_equal(np.concatenate([part.places for part in parts]), whole.places)
    for name in ("magnitude", "axis", "flank_sum"):
        found = np.concatenate([getattr(part, name) for part in parts])
        np.testing.assert_allclose(found, getattr(whole, name), rtol=1e-4, atol=1e-4)


def test_no_gradient_of_more_than_a_band_is_ever_made(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[int] = []

    def noted(linear: Pixels, kernels: Kernels) -> Gradient:
        made.append(linear.size)
        return gradient(linear, kernels)

    monkeypatch.setattr(bands, "gradient", noted)
    channel_statistics(image(False))
    assert 0 < max(made) <= 1.05 * BAND_PIXELS


def test_rows_that_are_sampled_are_those_of_the_whole() -> None:
    grey, kernels = image(False), contrast_kernels(0.7)
    magnitude, there = GradientRows(grey, 1.0, kernels).sampled()
    rows = [int(np.flatnonzero((grey == row).all(axis=1))[0]) for row in there]
    assert len(rows) >= 40
    narrow = narrowed(kernels)
    assert narrow is not None
    np.testing.assert_allclose(magnitude, gradient(grey, narrow).magnitude[rows], rtol=1e-4)


@pytest.mark.parametrize("shape", [(3, 3), (4, 9), (37, 50)])
def test_of_narrow_kernels_the_rows_tell_what_the_whole_gradient_does(shape: tuple[int, int]) -> None:
    random, kernels = np.random.default_rng(5), narrowed(contrast_kernels(0.7))
    assert kernels is not None
    grey = random.integers(0, 256, shape).astype(np.uint8)
    level = random.integers(0, 256, (shape[0] // 2, shape[1] // 2)).astype(np.uint8)
    floor_of = np.linspace(5.0, 20.0, 256).astype(np.float32)  # so low that the list has to grow
    whole = pixels_of_rows(gradient(grey, kernels), level, floor_of, 0, shape[0])
    rows = narrow_pixels_of_rows(grey, kernels, level, floor_of, 0, shape[0])
    assert len(whole.places) >= (shape[0] - 2) * (shape[1] - 2) // 3
    np.testing.assert_array_equal(rows.places, whole.places)
    for found, expected in zip(rows[1:], whole[1:], strict=True):
        np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-3)
