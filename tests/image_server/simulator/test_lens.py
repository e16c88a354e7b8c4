"""The lens: discs as wide as the thin lens makes them, vignetting, and scattered light that is not lost."""

import numpy as np
import pytest

from geometry.camera import Camera
from image_server.simulator.lens import disc_diameters, disc_kernel, focused, glared, vignette

FX = 800.0
WIDTH_M = 8e-3 / 2.8


def spread(image: np.ndarray) -> float:
    """Variance of an image of a point along x, px²."""
    x = np.arange(image.shape[1])
    column = image.sum(axis=0) / image.sum()
    return float((column * x**2).sum() - (column * x).sum() ** 2)


@pytest.mark.parametrize(("depth", "focus"), [(0.5, 0.75), (1.0, 0.4), (0.6, 0.3)])
def test_a_point_becomes_the_disc_of_a_thin_lens(depth: float, focus: float) -> None:
    # the textbook form: f/N · f · |d - s| / (d (s - f)), with the image at f s / (s - f)
    focal, image_distance = 8e-3, 8e-3 * focus / (focus - 8e-3)
    pixel = image_distance / FX
    textbook = WIDTH_M * focal * abs(depth - focus) / (depth * (focus - focal)) / pixel
    assert disc_diameters(np.float32([[1 / depth]]), FX, WIDTH_M, focus)[0, 0] == pytest.approx(textbook)
    point = np.zeros((61, 61), np.float32)
    point[30, 30] = 1.0
    image = focused(point, np.full(point.shape, 1 / depth, np.float32), FX, WIDTH_M, focus)
    assert image.sum() == pytest.approx(1.0, abs=1e-4)
    assert spread(image) == pytest.approx(textbook**2 / 16, rel=0.1)


@pytest.mark.parametrize("diameter", [0.3, 1.0, 2.5, 7.2, 20.0])
def test_a_disc_has_a_middle_and_its_own_variance(diameter: float) -> None:
    kernel = disc_kernel(diameter)
    assert kernel.sum() == pytest.approx(1.0, abs=1e-5)
    assert kernel == pytest.approx(kernel[::-1, ::-1], abs=1e-6)
    assert spread(kernel) == pytest.approx(diameter**2 / 16, rel=0.06)


def test_what_is_in_focus_stays_as_it_is() -> None:
    rng = np.random.default_rng(1)
    picture = rng.random((80, 90), np.float32)
    assert np.array_equal(
        focused(picture, np.full(picture.shape, 2.0, np.float32), FX, WIDTH_M, 0.5), picture
    )


def test_an_outline_spreads_over_what_is_behind_it() -> None:
    # a bright half plane at 0.5 m before black sky, the lens focused at infinity: its edge becomes a ramp
    picture = np.zeros((60, 120), np.float32)
    picture[:, :60] = 1.0
    near = np.where(picture > 0, np.float32(2.0), np.float32(0.0))
    image = focused(picture, near, FX, WIDTH_M, 1e6)
    diameter = FX * WIDTH_M * 2.0
    row = image[30].astype(float)
    assert row[: int(59 - diameter / 2 - 1)] == pytest.approx(1.0, abs=1e-4)
    assert row[int(60 + diameter / 2 + 2) :] == pytest.approx(0.0, abs=1e-4)
    assert row.sum() == pytest.approx(60.0, abs=0.05)
    assert row[59] == pytest.approx(
        0.5 + 2 / np.pi / diameter, abs=0.03
    )  # a disc's edge spread half a pixel in


def test_a_disc_is_no_wider_than_the_frame() -> None:
    """A lens focused at a millimetre has discs of thousands of pixels, for which there is no memory."""
    picture = np.zeros((48, 64), np.float32)
    picture[:, :32] = 1.0
    image = focused(picture, np.ones(picture.shape, np.float32), FX, WIDTH_M, 1e-3)
    assert 0.1 < image[:, 40].min() < image[:, 24].max() < 0.9


def test_nearer_and_farther_parts_blur_each_in_their_own_way() -> None:
    lines = np.zeros((64, 400), np.float32)
    lines[:, [100, 300]] = 1.0
    depth = np.where(np.arange(400) < 200, 0.5, 1.0).astype(np.float32)
    image = focused(lines, np.broadcast_to(1 / depth, lines.shape).astype(np.float32), FX, WIDTH_M, 0.5)
    assert spread(image[:, 80:120]) == pytest.approx(0.0, abs=0.05)
    wide = FX * WIDTH_M * (1 / 0.5 - 1 / 1.0)
    assert spread(image[:, 280:320]) == pytest.approx(wide**2 / 16, rel=0.1)


def test_corners_darken_as_the_cosine_to_the_fourth() -> None:
    camera = Camera(640, 480, 800.0, 800.0, 319.5, 239.5)
    factor = vignette(camera, 4.0)
    assert factor[239:241, 319:321] == pytest.approx(1.0, abs=1e-5)
    angle = np.arctan(np.hypot(319.5, 239.5) / 800)
    assert factor[0, 0] == pytest.approx(np.cos(angle) ** 4, rel=1e-5)


def test_scattered_light_is_not_lost_and_falls_away_from_its_source() -> None:
    picture = np.zeros((240, 320), np.float32)
    picture[120, 160] = 1000.0
    image = glared(picture, 0.1)
    assert 0.85 < image.sum() / picture.sum() <= 1.001  # what leaves the frame is gone
    assert image[120, 160] == pytest.approx(900.0, rel=0.02)
    ring = [float(image[120, 160 + r]) for r in (20, 40, 80)]
    assert ring[0] / ring[1] == pytest.approx(4.0, rel=0.15)
    assert ring[1] / ring[2] == pytest.approx(4.0, rel=0.15)
