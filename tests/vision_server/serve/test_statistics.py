import numpy as np
import pytest

from geometry.model import Model
from geometry.pose import Pose
from numerics.arrays import Grey
from tests.vision_server.synthetic import CAMERA, POSE, linear_picture, photographed
from vision_server.channels.channel import channel_statistics
from vision_server.serve.statistics import MARGIN_PX, frame_statistics, lit_region, target_region


def test_the_region_holds_the_model_and_little_else(model: Model) -> None:
    region = target_region(model, CAMERA, POSE)
    inside = CAMERA.project(POSE.apply(model.vertices)).round().astype(int)
    assert region[inside[:, 1], inside[:, 0]].all()
    assert 0.05 < region.mean() < 0.6


@pytest.mark.parametrize("z", [-0.4, 0.0])
def test_a_model_that_is_not_in_front_means_the_whole_frame(model: Model, z: float) -> None:
    assert target_region(model, CAMERA, Pose(POSE.rotation_vector, np.array([0.0, 0.0, z]))).all()


def test_exposure_is_told_for_the_target_and_for_the_frame(model: Model) -> None:
    linear = linear_picture(model, CAMERA, POSE, background=0.0)
    region = target_region(model, CAMERA, POSE)
    seen = {}
    for exposure in (0.02, 1.0, 6.0):
        pixels = photographed(linear, exposure)
        seen[exposure] = frame_statistics(channel_statistics(pixels, exposure), region)
    dark, good, bright = seen[0.02], seen[1.0], seen[6.0]
    assert dark["dark_fraction"] > 0.9 > good["dark_fraction"]
    assert bright["saturated_fraction"] > 0.3
    assert good["saturated_fraction"] == 0.0
    assert good["frame"]["dark_fraction"] > good["dark_fraction"]
    assert dark["p50"] < good["p50"] < bright["p50"] <= 1.0


def test_where_no_pose_is_known_what_any_frame_shows_is_the_region() -> None:
    dark = np.zeros((120, 160), np.uint8)
    left, right = dark.copy(), dark.copy()
    left[50:60, 20:30], right[50:60, 30:40] = 200, 90
    dark[10, 150] = 255  # a star
    region = lit_region([dark, left, right])
    assert region[50 - MARGIN_PX + 1 : 60 + MARGIN_PX - 1, 20 - MARGIN_PX + 1 : 40 + MARGIN_PX - 1].all()
    assert region.sum() <= (10 + 2 * MARGIN_PX) * (20 + 2 * MARGIN_PX)
    assert lit_region([dark]).all()


def test_a_small_target_that_is_overexposed_does_not_count_as_dark() -> None:
    pixels = np.zeros((480, 640), np.uint8)
    pixels[200:240, 300:360] = 255
    channel = channel_statistics(pixels)
    told = frame_statistics(channel, lit_region([channel.image]))
    assert told["frame"]["p95"] == 0.0
    assert told["p50"] == told["p95"] == 1.0


@pytest.mark.parametrize("gamma", [1.0, 2.2])
def test_light_is_told_on_a_linear_scale_whatever_the_tone_curve(model: Model, gamma: float) -> None:
    linear = linear_picture(model, CAMERA, POSE)
    region = target_region(model, CAMERA, POSE)
    told = []
    for exposure in (0.4 / linear.max(), 0.8 / linear.max()):
        pixels = photographed(linear, exposure, noise_sd_grey=0.0, gamma=gamma)
        told.append(frame_statistics(channel_statistics(pixels, exposure, gamma), region, gamma))
    for key in ("mean", "p50", "p95"):
        assert told[1][key] == pytest.approx(2.0 * told[0][key], rel=0.03)
    assert told[1]["p95"] == pytest.approx(0.8 * np.quantile(linear[region], 0.95) / linear.max(), rel=0.02)


def blur_told(model: Model, pixels: Grey) -> float | None:
    told: float | None = frame_statistics(channel_statistics(pixels), target_region(model, CAMERA, POSE))[
        "blur_px"
    ]
    return told


@pytest.mark.parametrize("blur", [2.0, 3.5])
def test_blur_is_told_in_pixels(model: Model, blur: float) -> None:
    pixels = photographed(linear_picture(model, CAMERA, POSE, blur_px=blur), noise_sd_grey=0.7)
    assert blur_told(model, pixels) == pytest.approx(blur, rel=0.3)


def test_a_sharp_frame_is_told_from_a_blurred_one(model: Model) -> None:
    pixels = photographed(linear_picture(model, CAMERA, POSE, blur_px=0.8), noise_sd_grey=0.7)
    found = blur_told(model, pixels)
    assert found is not None
    assert found < 1.5


def test_without_edges_blur_is_unknown(model: Model) -> None:
    assert blur_told(model, np.full((CAMERA.height, CAMERA.width), 90, np.uint8)) is None


def test_blur_is_unknown_where_much_is_saturated(model: Model) -> None:
    region = target_region(model, CAMERA, POSE)
    linear = linear_picture(model, CAMERA, POSE, blur_px=3.0)
    pixels = photographed(linear, 2.0 / float(np.median(linear[region])), noise_sd_grey=0.7)
    assert (pixels[region] >= 250).mean() > 0.5
    assert blur_told(model, pixels) is None
