"""The kernel against a plain statement of its equations, and against edges whose place is known."""

import math

import cv2
import numpy as np
import pytest

from numerics.arrays import Floats
from tests.vision_server.synthetic import one_image
from tests.vision_server.whole_tiles import deep_channel, everywhere, whole
from vision_server.channels.gradients import GradientChannel, Normals
from vision_server.pose.edge_points import CURVATURE_NOISE, DERIVATIVE_NOISE, search


def step_image(place: float, angle: float, blur: float, size: int = 81) -> Floats:
    """Blurred step of height 100 across a line through the middle shifted by ``place`` along its normal."""
    half = size // 2
    y, x = np.mgrid[-half : half + 1, -half : half + 1].astype(float)
    across = x * math.cos(angle) + y * math.sin(angle) - place
    return 50.0 + 100.0 * 0.5 * (1.0 + np.vectorize(math.erf)(across / (math.sqrt(2.0) * blur)))


def channel(linear: Floats, noise: float) -> GradientChannel:
    return deep_channel(linear.astype(np.float32), noise)


def points_on(made: GradientChannel, angle: float, count: int = 21, scale: int = 0) -> list[Floats]:
    """Offset, SNR, standard deviation and strength (count, PEAKS) on an edge through the middle."""
    half = made.frame.shape[0] // 2
    along = np.linspace(-15, 15, count)
    image = half + np.stack([-along * math.sin(angle), along * math.cos(angle)], axis=1)
    normal = np.tile([math.cos(angle), math.sin(angle)], (count, 1))
    chosen = np.full((1, count), scale, dtype=np.int64)
    return [field[0] for field in search([made], chosen, Normals(image, normal, np.full(count, 5.0)))]


@pytest.mark.parametrize("angle", [0.0, 0.3, 0.9, math.pi / 2])
@pytest.mark.parametrize("place", [-2.3, -0.4, 0.0, 0.25, 1.5])
@pytest.mark.parametrize("scale", [0, 1])
def test_a_step_is_found_to_a_thirtieth_of_a_pixel_on_average(angle: float, place: float, scale: int) -> None:
    offset, snr, _, strength = points_on(channel(step_image(place, angle, 0.8), 1.0), angle, scale=scale)
    best = np.take_along_axis(offset, snr.argmax(axis=1)[:, None], axis=1)[:, 0]
    assert best == pytest.approx(np.full(len(best), place), abs=0.08)
    assert float(best.mean()) == pytest.approx(place, abs=0.03)
    assert (strength[:, 0] > 0).all()


def test_the_kernel_agrees_with_its_equations() -> None:
    rng = np.random.default_rng(1)
    linear = step_image(0.3, 0.5, 1.0) + rng.normal(0, 1.0, (81, 81))
    made = channel(linear, 1.0)
    everywhere(made)
    fields_of = whole(made).gradient[0]
    offset, snr, sd, strength = points_on(made, 0.5, count=9)
    along = np.linspace(-15, 15, 9)
    nx, ny = math.cos(0.5), math.sin(0.5)

    def derivatives(i: int, u: Floats) -> Floats:
        x = (40 - along[i] * ny + u * nx).astype(np.float32)[None]
        y = (40 + along[i] * nx + u * ny).astype(np.float32)[None]
        fields = [cv2.remap(field, x, y, cv2.INTER_LINEAR) for field in cv2.split(fields_of)]
        return np.asarray(nx * fields[0] + ny * fields[1], dtype=float)[0]

    def parabola(three: Floats) -> tuple[float, float]:
        before, here, after = np.log(np.abs(three))
        return 0.5 * (after - before) / (2 * here - before - after), 2 * here - before - after

    for i in range(9):
        u = np.arange(-6.0, 7.0)
        profile = derivatives(i, u)
        k = int(np.argmax(np.abs(profile[1:-1]))) + 1
        place = u[k] + parabola(profile[k - 1 : k + 2])[0]
        around = derivatives(i, place + np.array([-1.0, 0.0, 1.0]))
        shift, bend = parabola(around)
        j = int(np.argmax(snr[i]))
        assert offset[i, j] == pytest.approx(place + shift, abs=0.01)  # cv2.remap rounds places to 1/32 px
        assert strength[i, j] == pytest.approx(around[1], rel=0.01)
        assert snr[i, j] == pytest.approx(abs(around[1]) / DERIVATIVE_NOISE, rel=0.01)
        assert sd[i, j] == pytest.approx(CURVATURE_NOISE / abs(around[1] * bend), rel=0.05)


def test_the_predicted_noise_is_the_noise_that_is_seen() -> None:
    rng = np.random.default_rng(0)
    seen, predicted = [], []
    clean = step_image(0.2, 0.4, 0.8)
    for _ in range(60):
        offset, _, sd, _ = points_on(channel(clean + rng.normal(0, 3.0, clean.shape), 3.0), 0.4, count=5)
        seen.extend(offset[:, 0] - 0.2)
        predicted.extend(sd[:, 0])
    assert float(np.nanstd(seen)) == pytest.approx(float(np.median(predicted)), rel=0.25)


def test_noise_alone_has_few_edges() -> None:
    rng = np.random.default_rng(0)
    offset, *_ = points_on(channel(100 + rng.normal(0, 2.0, (81, 81)), 2.0), 0.3)
    assert np.isfinite(offset).any(axis=1).mean() < 0.1


def test_edges_beside_saturated_pixels_are_less_certain() -> None:
    pixels = np.clip(np.round(2.0 * step_image(0.0, 0.0, 0.8)), 0, 255).astype(np.uint8)
    made = one_image(pixels).gradients(["i1"])[0]
    _, snr, sd, _ = points_on(made, 0.0)
    best = np.take_along_axis(sd, snr.argmax(axis=1)[:, None], axis=1)
    assert (best > 0.4).all()
