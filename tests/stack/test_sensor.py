"""The sensor obeys the numbers it is given: exposure, photon transfer, blur, clip and curve."""

import numpy as np
import pytest

from stack.exposure import relative_exposure
from stack.format import CameraTable
from stack.sensor import blurred, exposed, line_kernel, mixed
from tests.stack.cameras import camera

SIZE = (200, 200)


def flat(value: float) -> np.ndarray:
    return np.full(SIZE, value, np.float32)


def test_the_reference_exposure_is_one_and_stops_are_factors_of_two() -> None:
    assert relative_exposure(1 / 60, 4.0) == pytest.approx(1.0)
    assert relative_exposure(1 / 30, 4.0) == pytest.approx(2.0)
    assert relative_exposure(1 / 60, 2.0) == pytest.approx(4.0)


def test_without_noise_the_frame_is_the_formula() -> None:
    radiance = np.linspace(0, 1.2, 601, dtype=np.float32)[None]
    sensor = camera(gain=1.5, gamma=2.2)
    frame = exposed(radiance, sensor, 1 / 120, 2.8, None)
    signal = radiance.astype(float) * 1.5 * (1 / 120 / 2.8**2) / (1 / 60 / 16)
    plain = 255 * np.clip(signal, 0, 1) ** (1 / 2.2)
    assert np.abs(frame - plain).max() <= 0.51


@pytest.mark.parametrize("gain", [1.0, 2.0, 8.0])
def test_photon_transfer_curve_has_the_slope_and_foot_of_the_parameters(gain: float) -> None:
    sensor = camera(gain=gain, read_noise_e=20.0, full_well_e=5000.0)
    means, variances = [], []
    for number, signal in enumerate(np.linspace(0.15, 0.8, 8)):
        frame = exposed(flat(signal / gain), sensor, 1 / 60, 4.0, (7, number)).astype(float) / 255
        means.append(frame.mean())
        variances.append(frame.var() - 1 / 12 / 255**2)
    slope, foot = np.polyfit(means, variances, 1)
    assert slope == pytest.approx(gain / 5000, rel=0.05)
    assert foot == pytest.approx((20 * gain / 5000) ** 2, abs=0.02 * gain / 5000)


def test_the_seed_and_the_number_of_the_capture_draw_the_noise() -> None:
    first, again = (exposed(flat(0.4), camera(), 1 / 60, 4.0, (3, 1)) for _ in range(2))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, exposed(flat(0.4), camera(), 1 / 60, 4.0, (3, 2)))
    assert not np.array_equal(first, exposed(flat(0.4), camera(), 1 / 60, 4.0, (4, 1)))


def spread_of_a_point(sensor: CameraTable, shutter_s: float, aperture: float) -> np.ndarray:
    """Centroid offset and second moments (x, y) of a blurred point, px and px²."""
    point = np.zeros((101, 101), np.float32)
    point[50, 50] = 1
    image = blurred(point, sensor, shutter_s, aperture).astype(float)
    assert image.sum() == pytest.approx(1, abs=1e-3)
    y, x = np.mgrid[:101, :101] - 50
    moments = [(image * z).sum() for z in (x, y)] + [(image * z**2).sum() for z in (x, y)]
    return np.array(moments)


def test_defocus_falls_as_the_aperture_closes() -> None:
    sensor = camera(defocus_sigma_px=4.0)
    assert spread_of_a_point(sensor, 1 / 60, 2.8) == pytest.approx([0, 0, 16, 16], abs=0.2)
    assert spread_of_a_point(sensor, 1 / 60, 5.6) == pytest.approx([0, 0, 4, 4], abs=0.1)


def test_motion_is_a_centred_line_as_long_as_the_shutter_is_open() -> None:
    sensor = camera(motion_px_per_s=(360.0, -120.0))
    found = spread_of_a_point(sensor, 1 / 15, 4.0)
    # a uniform line of length L has variance L²/12; splatting to pixels adds at most 1/4 px²
    assert found[:2] == pytest.approx([0, 0], abs=1e-4)
    assert 24**2 / 12 <= found[2] <= 24**2 / 12 + 0.26
    assert 8**2 / 12 <= found[3] <= 8**2 / 12 + 0.26


@pytest.mark.parametrize("step", [(0.3, 0.0), (24.0, 0.0), (-7.3, 2.9), (0.0, 5.0)])
def test_a_motion_kernel_adds_up_to_one_and_has_a_middle(step: tuple[float, float]) -> None:
    kernel = line_kernel(*step)
    assert kernel.sum() == pytest.approx(1, abs=1e-5)
    assert all(size % 2 == 1 for size in kernel.shape)
    assert kernel == pytest.approx(kernel[::-1, ::-1], abs=1e-6)


def test_light_adds_up() -> None:
    rng = np.random.default_rng(0)
    images = [rng.random(SIZE, np.float32) for _ in range(3)]
    assert mixed(images, [0.5, 0.0, 2.0]) == pytest.approx(0.5 * images[0] + 2 * images[2], abs=1e-5)


def test_fixed_patterns_have_the_strength_that_the_parameters_say() -> None:
    """EMVA 1288: averaged frames leave the fixed pattern; at two levels its two parts can be told apart."""
    sensor = camera(prnu=0.02, dsnu_e=60.0, read_noise_e=5.0, full_well_e=10000.0)
    spatial = []
    for signal in (0.1, 0.7):
        frames = [exposed(flat(signal), sensor, 1 / 60, 4.0, (1, n)).astype(float) / 255 for n in range(40)]
        temporal = np.var(frames, axis=0, ddof=1).mean() / len(frames)
        spatial.append(np.mean(frames, axis=0).var() - temporal)
    prnu = np.sqrt((spatial[1] - spatial[0]) / (0.7**2 - 0.1**2))
    dsnu_e = np.sqrt(spatial[0] - (0.1 * prnu) ** 2) * 10000
    assert prnu == pytest.approx(0.02, rel=0.05)
    assert dsnu_e == pytest.approx(60.0, rel=0.06)


def test_the_pattern_belongs_to_the_sensor_not_to_the_session() -> None:
    sensor = camera(prnu=0.1, read_noise_e=0.0, full_well_e=1e6)
    first, second = (exposed(flat(0.5), sensor, 1 / 60, 4.0, (seed, 1)).astype(int) for seed in (1, 2))
    assert np.abs(first - second).max() <= 2
    other = exposed(flat(0.5), camera(prnu=0.1, pattern_seed=1), 1 / 60, 4.0, None).astype(int)
    assert np.abs(first - other).max() > 20


def test_the_answer_is_linear_up_to_the_clip() -> None:
    """Mean signal against exposure over the camera's own shutters: no point off the line by 0.2 % of full."""
    sensor = camera(read_noise_e=5.0, full_well_e=20000.0)
    times = np.array([1 / 240, 1 / 120, 1 / 80, 1 / 60, 1 / 48])
    means = [exposed(flat(0.7), sensor, t, 4.0, (1, n)).mean() / 255 for n, t in enumerate(times)]
    slope, foot = np.polyfit(times, means, 1)
    assert np.abs(means - (slope * times + foot)).max() < 0.002
    assert slope == pytest.approx(0.7 * 60, rel=0.003)
    assert foot == pytest.approx(0.0, abs=0.002)
    assert exposed(flat(0.7), sensor, 1 / 30, 4.0, (1, 9)).min() == 255
