"""Gradients of a part of the image are those of the whole image."""

import numpy as np
import pytest
from numpy.typing import NDArray

from vision_server.channels.channel import channel_statistics
from vision_server.channels.gaussian import contrast_kernels, noise_gain
from vision_server.channels.gradients import (
    MARGIN_PX,
    SCALES_PX,
    GradientChannel,
    Region,
    WholeFrame,
    gradient_channel,
)

WIDTH, HEIGHT = 320, 240


def channel() -> GradientChannel:
    rng = np.random.default_rng(4)
    linear = rng.uniform(0.0, 255.0, (HEIGHT, WIDTH)).astype(np.float32)
    return GradientChannel("i1", WholeFrame(linear, np.ones_like(linear), (linear > 254.0).astype(np.uint8)))


def parts_of(made: GradientChannel, region: Region) -> list[NDArray[np.float32] | NDArray[np.uint8]]:
    left, top, right, bottom = region
    there = np.s_[top:bottom, left:right]
    scales = range(len(SCALES_PX))
    return [
        made.smooth[there],
        *(made.gradient[index][there] for index in scales),
        *(made.near_clipped[index][there] for index in scales),
    ]


@pytest.mark.parametrize(
    "needed", [(100, 80, 180, 130), (3, 5, 40, 60), (250, 190, 400, 300), (-50, -50, 9, 9)]
)
def test_a_part_holds_what_the_whole_image_holds(needed: Region) -> None:
    whole, part = channel(), channel()
    whole.prepare(len(SCALES_PX))
    part.prepare(len(SCALES_PX), needed)
    left, top, right, bottom = needed
    seen = (max(left, 0), max(top, 0), min(right, WIDTH), min(bottom, HEIGHT))
    for found, true in zip(parts_of(part, seen), parts_of(whole, seen), strict=True):
        assert (found == true).all()


@pytest.mark.parametrize("deep", [False, True])
def test_a_part_of_a_frame_is_that_of_its_statistics(deep: bool) -> None:
    image = np.random.default_rng(5).integers(0, 256, (HEIGHT - 1, WIDTH - 1), np.uint8)
    known = channel_statistics(image + np.float32(0.0) if deep else image, 0.5, 2.2)
    left, top, right, bottom = region = (33, 20, WIDTH - 1, HEIGHT - 1)
    there = np.s_[top:bottom, left:right]
    linear, noise, clipped = gradient_channel("i1", known).frame.within(region)
    white = noise_gain(contrast_kernels(known.sigma_px, 0.5)) * known.noise_factor
    np.testing.assert_array_equal(linear, known.linear[there])
    np.testing.assert_allclose(noise, known.noise[there] / white, rtol=1e-6)
    np.testing.assert_array_equal(clipped, image[there] >= 250)


def test_what_was_filled_stays_when_more_is_asked_for() -> None:
    whole, part = channel(), channel()
    whole.prepare(1)
    part.prepare(1, (40, 40, 80, 80))
    part.prepare(1, (200, 150, 260, 200))
    for found, true in ((part.gradient, whole.gradient), (part.near_clipped, whole.near_clipped)):
        assert (found[0, 40:200, 40:260] == true[0, 40:200, 40:260]).all()


def test_a_move_within_the_margin_computes_nothing() -> None:
    made = channel()
    made.prepare(1, (100, 100, 150, 150))
    made.gradient[0] = np.nan
    made.prepare(1, (100 - MARGIN_PX, 100, 150, 150 + MARGIN_PX))
    assert np.isnan(made.gradient[0]).all()


def test_nothing_in_the_image_asks_for_nothing() -> None:
    made = channel()
    made.gradient[0] = np.nan
    made.prepare(1, (WIDTH + 5, 0, WIDTH + 50, 20))
    assert np.isnan(made.gradient[0]).all()
