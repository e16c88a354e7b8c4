"""Statistics of one image."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import convolve1d, gaussian_filter, maximum_filter, minimum_filter

from bridge.errors import BadInput
from numerics.arrays import Grey
from tests.vision_server.edge_scenes import step
from vision_server.channels.channel import FLOOR_NOISE_RATIO, channel_statistics
from vision_server.channels.gaussian import gaussian_kernels
from vision_server.channels.gradient_pixels import FLANK_RATIO
from vision_server.channels.lighting import CLIPPED_STOPS, LIT_OFFSET_GREY, WEIGHT_EXPONENT
from vision_server.channels.noise import SATURATED_GREY


def textured(seed: int = 0) -> Grey:
    values = gaussian_filter(np.random.default_rng(seed).normal(0, 1, (60, 80)), 2.0)
    return np.asarray(np.clip(120 + 300 * values, 0, 255), dtype=np.uint8)


def test_contrast_is_the_height_of_a_step_whatever_its_direction() -> None:
    for angle in np.linspace(0.0, np.pi, 7)[:-1]:
        channel = channel_statistics(step(angle, 0.0, 60, 140), sigma_px=2.0)
        peak = channel.contrast[20:-20, 20:-20].max()
        assert peak == pytest.approx(80.0, rel=0.04)
        y, x = np.unravel_index(np.argmax(channel.contrast), channel.shape)
        difference = abs(channel.orientation[y, x] - angle) % np.pi
        assert min(difference, np.pi - difference) < 0.02


@pytest.mark.parametrize(("gamma", "sigma"), [(2.2, 1.0), (1.0, 1.6), (2.2, 0.8), (1.0, 0.7)])
def test_statistics_are_their_equations(gamma: float, sigma: float) -> None:
    image, exposure = textured(), 0.5
    channel = channel_statistics(image, exposure, gamma, sigma_px=sigma)
    linear = 255.0 * (image / 255.0) ** gamma
    smooth, derivative = (kernel.astype(np.float64) for kernel in gaussian_kernels(sigma))
    if sigma < 0.85:  # the outermost taps are too small to count
        smooth, derivative = smooth[1:-1], derivative[1:-1]
    height = np.sqrt(2 * np.pi) * sigma / exposure
    # correlate, as image filters do: scipy's convolve1d turns the kernel round
    gx = height * convolve1d(
        convolve1d(linear, derivative[::-1], axis=1, mode="nearest"), smooth, axis=0, mode="nearest"
    )
    gy = height * convolve1d(
        convolve1d(linear, derivative[::-1], axis=0, mode="nearest"), smooth, axis=1, mode="nearest"
    )
    magnitude = np.hypot(gx, gy)
    kept = channel.contrast > 0
    np.testing.assert_allclose(channel.linear, linear, rtol=1e-5)
    np.testing.assert_allclose(channel.contrast[kept], magnitude[kept], rtol=1e-3, atol=0.05)
    inner = np.zeros(image.shape, np.bool_)
    inner[1:-1, 1:-1] = True
    above = inner & (magnitude > FLOOR_NOISE_RATIO * channel.noise * 1.01)
    beside = np.maximum(maximum_filter(magnitude, 3), 1e-9)
    assert kept[above & (magnitude > FLANK_RATIO * beside)].all()
    assert not kept[~above & (magnitude < FLOOR_NOISE_RATIO * channel.noise * 0.99)].any()
    difference = np.abs(channel.orientation - np.arctan2(gy, gx)) % np.pi
    assert np.minimum(difference, np.pi - difference)[kept].max() < 0.01


def test_weight_follows_the_darkest_and_brightest_within_reach() -> None:
    image = np.full((40, 60), 40, np.uint8)
    image[:, 30:] = 160
    channel = channel_statistics(image, sigma_px=0.7)
    stops = [np.log2((grey + LIT_OFFSET_GREY) / 128.0) for grey in (40, 160)]
    assert channel.weight[20, 5] == pytest.approx(2 ** (WEIGHT_EXPONENT * stops[0]), rel=1e-3)
    assert channel.weight[20, 55] == pytest.approx(2 ** (WEIGHT_EXPONENT * stops[1]), rel=1e-3)
    beside = np.log2(channel.weight[20, 29:31]) / WEIGHT_EXPONENT
    np.testing.assert_allclose(beside, np.mean(stops), atol=0.25)


def test_weight_is_constant_across_a_blurred_edge() -> None:
    image = step(0.3, 0.0, 40, 180, blur_px=4.0)
    channel = channel_statistics(image)
    assert channel.blur_px == pytest.approx(4.0, abs=1.0)
    y, x = 48, 64
    across = np.log2(channel.weight[y, x - 3 : x + 4])
    assert np.ptp(across) < 1.0  # a window of the sharp size gives several times that


def test_exposure_and_gamma_cancel_out() -> None:
    bright = step(0.4, 0.0, 80, 200)
    half = np.round(bright / 2).astype(np.uint8)
    a, b = channel_statistics(bright, 1.0, sigma_px=1.0), channel_statistics(half, 0.5, sigma_px=1.0)
    edge = a.contrast > 50
    np.testing.assert_allclose(b.contrast[edge], a.contrast[edge], rtol=0.05)
    encoded = np.round(255 * (bright / 255.0) ** (1 / 2.2)).astype(np.uint8)
    c = channel_statistics(encoded, 1.0, 2.2, sigma_px=1.0)
    listed = c.contrast > 0
    assert np.mean(listed[edge]) > 0.95  # at the foot of an edge rounding decides
    edge &= listed
    np.testing.assert_allclose(c.contrast[edge], a.contrast[edge], rtol=0.06)


def test_noise_of_the_gradient_is_the_measured_one() -> None:
    image = np.clip(np.random.default_rng(3).normal(120, 5, (200, 300)), 0, 255).round().astype(np.uint8)
    channel = channel_statistics(image, 2.0, sigma_px=1.0)
    smooth, derivative = gaussian_kernels(1.0)
    gx = convolve1d(convolve1d(image / 2.0, derivative[::-1], axis=1), smooth, axis=0) * np.sqrt(2 * np.pi)
    assert np.median(channel.noise) == pytest.approx(gx[10:-10, 10:-10].std(), rel=0.1)
    assert np.mean(channel.contrast > 0) < 0.03  # 3 sd of a Rayleigh: 1.1 %


def test_clipped_pixels_are_marked_and_count_less() -> None:
    image = np.full((40, 60), 150, np.uint8)
    image[10:20, 10:20] = 255
    channel = channel_statistics(image, sigma_px=0.7)
    assert channel.light.brightest[7, 7] >= SATURATED_GREY
    assert channel.light.brightest[7, 20] < SATURATED_GREY
    low, high = minimum_filter(image, 5)[15, 15], maximum_filter(image, 5)[15, 15]
    assert low == high >= SATURATED_GREY
    stops = np.log2((255 + LIT_OFFSET_GREY) / 128.0) - CLIPPED_STOPS
    assert channel.weight[15, 15] == pytest.approx(2 ** (WEIGHT_EXPONENT * stops), rel=5e-2)


@pytest.mark.parametrize("value", [0, 255, 77])
def test_an_image_of_one_grey_has_no_contrast(value: int) -> None:
    channel = channel_statistics(np.full((30, 40), value, np.uint8))
    assert not channel.contrast.any()
    assert np.isfinite(channel.weight).all()


@pytest.mark.parametrize(
    ("image", "exposure", "gamma"),
    [
        (np.zeros((20, 20), np.float64), 1.0, 1.0),
        (np.zeros((20, 20, 3), np.uint8), 1.0, 1.0),
        (np.zeros((20, 1), np.uint8), 1.0, 1.0),
        (np.zeros((20, 20), np.uint8), 0.0, 1.0),
        (np.zeros((20, 20), np.uint8), float("nan"), 1.0),
        (np.zeros((20, 20), np.uint8), 1.0, -1.0),
    ],
)
def test_bad_input_is_refused(image: Grey, exposure: float, gamma: float) -> None:
    with pytest.raises(BadInput):
        channel_statistics(image, exposure, gamma)


def test_a_blurred_channel_has_less_say() -> None:
    sharp, blurred = (channel_statistics(step(0.3, 0.0, 40, 180, blur_px=blur)) for blur in (0.0, 4.0))
    assert blurred.weight[48, 120] < 0.05 * sharp.weight[48, 120]


def test_noise_that_was_smoothed_is_still_noise() -> None:
    raw = np.random.default_rng(5).normal(120, 9, (200, 300))
    smoothed = np.clip(gaussian_filter(raw, 0.45), 0, 255).round().astype(np.uint8)
    assert np.mean(channel_statistics(smoothed).contrast > 0) < 0.15
    assert np.mean(channel_statistics(np.clip(raw, 0, 255).astype(np.uint8)).contrast > 0) < 0.03


def test_a_blurred_image_gets_a_coarser_gradient() -> None:
    sharp, blurred = (channel_statistics(step(0.3, 0.0, 40, 180, blur_px=blur)) for blur in (0.0, 5.0))
    assert blurred.sigma_px > sharp.sigma_px
