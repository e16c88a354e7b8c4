"""Images of more than eight bits keep all of them, from the file to the pose."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from bridge.errors import BadInput
from geometry.model import Model
from geometry.pose import disturbed
from tests.vision_server.synthetic import CAMERA, POSE, cuboid, linear_picture, one_image
from vision_server.channels.channel import channel_statistics
from vision_server.channels.depth import PER_GREY, Raw, in_grey, rounded, rounding_sd, stretched
from vision_server.channels.image_files import read_grey, read_image_set
from vision_server.channels.noise import grey_noise
from vision_server.pipeline import estimate_pose
from vision_server.tracking.tracker import Tracker
from vision_server.trust.judgement import Estimate

FACES = (0.3, 0.7, 0.2, 0.9, 0.5, 0.8)
TEN_BITS, SIXTEEN_BITS = 1023.0, 65535.0
NOISE = 4.0  # of TEN_BITS
HALF_A_COUNT = 0.51 / PER_GREY  # grey
TRACKED_WITHIN_MM = 0.2  # a first frame is fitted to whole lines: 0.12; cut to eight bits it is 1.6 off
WITHIN_MM = 0.06  # what this scene's noise allows: 0.02 in the median of 8 draws, 0.03 at most


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Model:
    return cuboid(tmp_path_factory.mktemp("depth"))


def ten_of_sixteen_bits(model: Model, above: float = 0.0) -> NDArray[np.uint16]:
    """A scene that fills 10 of 16 bits, from a share of full scale on."""
    noise = NOISE * np.random.default_rng(1).standard_normal((CAMERA.height, CAMERA.width))
    counts = above * SIXTEEN_BITS + TEN_BITS * linear_picture(model, CAMERA, POSE, FACES) + noise
    return np.clip(np.rint(counts), 0, SIXTEEN_BITS).astype(np.uint16)


def estimated(pixels: NDArray[np.generic], model: Model) -> Estimate:
    start = disturbed(POSE, np.random.default_rng(2), 10.0, 10.0, CAMERA.fx)
    return estimate_pose(one_image(pixels), ["i1"], model, CAMERA, start)


def error_mm(found: Estimate) -> float:
    assert found.pose is not None
    return 1e3 * float(np.linalg.norm(found.pose.translation - POSE.translation))


@pytest.mark.parametrize("above", [0.0, 0.5])
def test_ten_of_sixteen_bits_give_the_pose_that_their_noise_allows(model: Model, above: float) -> None:
    counts = ten_of_sixteen_bits(model, above)
    assert error_mm(estimated(Raw(16).grey(counts), model)) < WITHIN_MM
    assert error_mm(estimated(rounded(Raw(16).grey(counts)), model)) > 10.0 * WITHIN_MM


def test_tracking_sees_all_bits(model: Model) -> None:
    counts = ten_of_sixteen_bits(model)
    start = disturbed(POSE, np.random.default_rng(3), 2.0, 3.0, CAMERA.fx)
    told = Tracker(model, CAMERA, start).step(Raw(16).grey(counts))
    assert told.pose is not None
    assert 1e3 * float(np.linalg.norm(told.pose.translation - POSE.translation)) < TRACKED_WITHIN_MM


@pytest.mark.parametrize(("bits", "name"), [(10, "a.png"), (12, "a.tiff"), (14, "a.png"), (16, "a.tiff")])
def test_files_keep_the_depth_of_the_camera(tmp_path: Path, bits: int, name: str) -> None:
    counts = np.arange(20, dtype=np.uint16).reshape(4, 5) + 100
    counts[0, 0] = 2**bits - 1
    cv2.imwrite(str(tmp_path / name), counts)
    grey = read_grey(tmp_path / name)
    assert grey.dtype == np.uint16
    np.testing.assert_allclose(in_grey(grey), counts * (255.0 / (2**bits - 1)), atol=HALF_A_COUNT)
    np.testing.assert_array_equal(read_grey(tmp_path / name, Raw(16)), counts)
    if bits > 10:
        with pytest.raises(BadInput, match=r"more than 10 bits hold.*Correct bits"):
            read_grey(tmp_path / name, Raw(10))


def test_float_files_keep_their_fractions(tmp_path: Path) -> None:
    values = np.linspace(0.2, 0.2001, 25, dtype=np.float32).reshape(5, 5)
    cv2.imwrite(str(tmp_path / "a.tiff"), values)
    np.testing.assert_allclose(read_grey(tmp_path / "a.tiff"), 255.0 * values, rtol=1e-6)


@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
@pytest.mark.parametrize("order", [(0, 0), (0, 1), (1, 0), (1, 1)])
def test_a_mosaic_becomes_even_grey_whatever_its_order(
    tmp_path: Path, order: tuple[int, int], kind: type[np.unsignedinteger]
) -> None:
    red, green, blue = 120, 60, 200
    mosaic = np.tile(np.array([[red, green], [green, blue]], kind), (8, 8))
    mosaic = np.ascontiguousarray(np.roll(mosaic, order, axis=(0, 1)))
    cv2.imwrite(str(tmp_path / "raw.png"), mosaic)
    (grey,) = read_image_set([tmp_path / "raw.png"], Raw(8, bayer=True))
    np.testing.assert_allclose(in_grey(grey.pixels), (red + 2 * green + blue) / 4, atol=HALF_A_COUNT)


def test_noise_is_measured_below_a_step_of_eight_bits() -> None:
    rng = np.random.default_rng(4)
    counts = np.rint(20_000.0 + 12.0 * rng.standard_normal((200, 300))).astype(np.uint16)
    noise = grey_noise(Raw(16).grey(counts))
    assert noise[round(20_000 / 257)] == pytest.approx(12.0 / 257.0, rel=0.05)


@pytest.mark.parametrize(("bits", "shifted"), [(10, 0), (12, 0), (12, 4), (16, 0)])
def test_the_steps_of_an_image_are_found(bits: int, shifted: int) -> None:
    counts = np.random.default_rng(5).integers(0, 2**bits, (100, 100), np.uint16) << shifted
    grey = Raw(bits + shifted).grey(counts)
    assert rounding_sd(grey) == pytest.approx(0.3 * 255.0 / (2**bits - 1), rel=0.3 if bits == 16 else 0.01)


def test_eight_bits_are_as_they_were() -> None:
    image = np.random.default_rng(6).integers(0, 256, (50, 60), np.uint8)
    assert Raw().grey(image) is image
    assert stretched(image) is image
    one = channel_statistics(image, gamma=2.2)
    assert one.pixels is image
    assert one.image is image


def test_a_deep_image_of_whole_grey_gives_the_edges_of_eight_bits(model: Model) -> None:
    whole = np.rint(255.0 * linear_picture(model, CAMERA, POSE, FACES)).astype(np.uint8)
    eight, deep = channel_statistics(whole), channel_statistics(whole * np.uint16(PER_GREY))
    np.testing.assert_allclose(deep.linear, eight.linear, rtol=1e-6)
    strong = eight.contrast > 20.0
    np.testing.assert_allclose(deep.contrast[strong], eight.contrast[strong], rtol=0.02)
