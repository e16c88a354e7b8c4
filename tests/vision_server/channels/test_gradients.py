"""Gradients of tiles are those of the whole image, and tiles are there where normals run."""

import threading
import time

import cv2
import numpy as np
import pytest

from tests.vision_server.whole_tiles import deep_channel, everywhere, whole
from vision_server.channels.channel import channel_statistics
from vision_server.channels.depth import Pixels
from vision_server.channels.gaussian import contrast_kernels, gaussian_gradient, gaussian_kernels, noise_gain
from vision_server.channels.gradients import (
    SCALES_PX,
    SIDE_PX,
    TILE_PX,
    GradientChannel,
    Normals,
    Numbers,
    clip_reach,
    gradient_channel,
    noise_at,
)

WIDTH, HEIGHT = 323, 241


def channel() -> GradientChannel:
    rng = np.random.default_rng(4)
    linear = rng.uniform(0.0, 255.0, (HEIGHT, WIDTH)).astype(np.float32)
    return deep_channel(np.where(linear > 254.0, linear, 0.97 * linear).astype(np.float32), 1.0)


def at(*places: tuple[float, float, float, float]) -> Normals:
    """Normals at places x, y with directions, 5 px to either side."""
    rows = np.array(places)
    return Normals(rows[:, :2].copy(), rows[:, 2:].copy(), np.full(len(rows), 5.0))


def test_tiles_hold_what_filters_of_the_whole_image_give() -> None:
    made = channel()
    everywhere(made)
    found, linear = whole(made), made.picture.pixels
    for index, scale in enumerate(SCALES_PX):
        expected = np.stack(gaussian_gradient(linear, gaussian_kernels(scale)), axis=-1)
        np.testing.assert_allclose(found.gradient[index], expected, atol=1e-3)
        side = 2 * clip_reach(index) + 1
        clipped = (linear > 254.0).astype(np.uint8)
        np.testing.assert_array_equal(
            found.near_clipped[index], cv2.dilate(clipped, np.ones((side, side), np.uint8))
        )
    smooth = gaussian_kernels(SCALES_PX[0])[0]
    blurred = cv2.sepFilter2D(linear, cv2.CV_32F, smooth, smooth, borderType=cv2.BORDER_REPLICATE)
    np.testing.assert_allclose(found.smooth, blurred, atol=1e-3)


def test_tiles_overlap_by_a_row_and_a_column() -> None:
    made = channel()
    everywhere(made)
    tiles = made.tiles
    one, right, below = (tiles.gradient[0, tiles.number[0, v, u]] for v, u in ((0, 0), (0, 1), (1, 0)))
    one, right, below = (tile.reshape(SIDE_PX, SIDE_PX, 2) for tile in (one, right, below))
    np.testing.assert_array_equal(one[:, -1], right[:, 0])
    np.testing.assert_array_equal(one[-1], below[0])


def test_a_tile_is_there_where_a_normal_runs_and_nowhere_else() -> None:
    made = channel()
    made.prepare(np.array([0, 1]), at((1.5 * TILE_PX, 20.0, 0.0, 1.0), (TILE_PX - 3.0, 150.0, 1.0, 0.0)), 1.0)
    sharp, soft, *others = (
        set(map(tuple, np.argwhere(number >= 0).tolist())) for number in made.tiles.number
    )
    assert soft == {(150 // TILE_PX, 0), (150 // TILE_PX, 1)}
    assert sharp == soft | {(0, 1)}  # the first scale tells how bright it is there
    assert others == [set(), set()]
    assert made.count.tolist() == [3, 2, 0, 0]


def test_what_is_there_is_not_computed_again() -> None:
    made = channel()
    normals = at((100.0, 100.0, 0.0, 1.0))
    made.prepare(np.array([0]), normals, 1.0)
    made.tiles.gradient[:] = np.nan
    made.prepare(np.array([0]), normals, 1.0)
    assert np.isnan(made.tiles.gradient).all()
    made.prepare(np.zeros(2, np.int64), at((100.0, 100.0, 0.0, 1.0), (300.0, 200.0, 0.0, 1.0)), 1.0)
    assert np.isfinite(whole(made).gradient[0, 200, 300]).all()
    assert np.isnan(whole(made).gradient[0, 100, 100]).all()


def test_two_threads_that_need_one_tile_both_find_it_filled(monkeypatch: pytest.MonkeyPatch) -> None:
    made, began, fill = channel(), threading.Event(), GradientChannel._fill
    normals = at((100.0, 100.0, 0.0, 1.0))

    def slowly(self: GradientChannel, index: int, first: int, block: Numbers) -> None:
        began.set()
        time.sleep(0.2)
        fill(self, index, first, block)

    monkeypatch.setattr(GradientChannel, "_fill", slowly)
    made.tiles.gradient[:] = np.nan
    other = threading.Thread(target=made.prepare, args=(np.array([0]), normals, 1.0))
    other.start()
    assert began.wait(60.0)
    made.prepare(np.array([0]), normals, 1.0)
    found = whole(made).gradient[0, 100, 100]
    other.join(60.0)
    assert np.isfinite(found).all()


def test_nothing_in_the_image_asks_for_nothing() -> None:
    made = channel()
    made.prepare(np.zeros(2, np.int64), at((WIDTH + 20.0, 50.0, 1.0, 0.0), (50.0, -40.0, 0.0, 1.0)), 4.0)
    assert made.count.tolist() == [0, 0, 0, 0]


@pytest.mark.parametrize("deep", [False, True])
def test_a_frame_has_the_intensity_and_the_noise_of_its_statistics(deep: bool) -> None:
    image = np.random.default_rng(5).integers(0, 255, (HEIGHT, WIDTH), np.uint8)
    pixels: Pixels = np.uint16(257) * image + np.uint16(77) if deep else image
    known = channel_statistics(pixels, 0.5, 2.2)
    made = gradient_channel("i1", known)
    everywhere(made)
    expected = np.stack(gaussian_gradient(known.linear, gaussian_kernels(1.0)), axis=-1)
    np.testing.assert_allclose(whole(made).gradient[0], expected, atol=1e-3)
    white = noise_gain(contrast_kernels(known.sigma_px, 0.5)) * known.noise_factor
    for row, column in ((0, 0), (33, 20), (HEIGHT - 1, WIDTH - 1)):
        assert noise_at(made.frame, row, column) == pytest.approx(known.noise[row, column] / white, rel=1e-5)


def test_tiles_do_not_depend_on_the_order_in_which_they_are_asked_for() -> None:
    at_once, by_and_by, rng = channel(), channel(), np.random.default_rng(0)
    everywhere(at_once)
    for _ in range(200):
        x, y = rng.uniform(0.0, WIDTH), rng.uniform(0.0, HEIGHT)
        by_and_by.prepare(rng.integers(0, len(SCALES_PX), 1), at((x, y, 1.0, 0.0)), 4.0)
    expected, found = whole(at_once), whole(by_and_by)
    known = np.isfinite(found.gradient)
    assert 0.3 < known.mean() < 1.0
    np.testing.assert_array_equal(found.gradient[known], expected.gradient[known])
    known = np.isfinite(found.smooth)
    assert known.any()
    np.testing.assert_array_equal(found.smooth[known], expected.smooth[known])
    known = found.near_clipped < 255
    np.testing.assert_array_equal(found.near_clipped[known], expected.near_clipped[known])
