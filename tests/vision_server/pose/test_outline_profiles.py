"""Outlines of curved surfaces lie where their profiles say, whatever the shading beside them adds."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from benchmarks.machined_parts import ROUND, surface_of
from benchmarks.synthetic_parts import random_view, rendered
from geometry.camera import Camera
from geometry.model import Model
from numerics.arrays import Floats
from tests.vision_server.synthetic import one_image
from vision_server.pose.courses import BLUR, courses_of
from vision_server.pose.line_scales import with_line_scales
from vision_server.pose.observation import PoseProblem, observe
from vision_server.pose.outline_profiles import REACH_STEPS, Optics, Outlines, outlines_of
from vision_server.pose.sampling import spacing_for

FINE = 40  # samples of a step
FILTER_PX, BLUR_PX = 1.0, 0.8
CAMERA = Camera(640, 480, 768.0, 768.0, 319.5, 239.5)


def profile(root: float, slope: float, place: float = 0.0) -> Floats:
    """The derivative across a step of height 1 at a place, beside which shading rises by these amounts."""
    x = np.arange(-12 * FINE, 12 * FINE + 1) / FINE - place
    inside = np.maximum(x, 0.0)
    picture = (x > 0.0) + 0.5 * (x == 0.0) + root * np.sqrt(inside) + slope * inside
    across = np.gradient(gaussian_filter1d(picture, FINE * np.hypot(FILTER_PX, BLUR_PX)), 1.0 / FINE)
    return np.asarray(across[12 * FINE + FINE * np.arange(-REACH_STEPS, REACH_STEPS + 1)])


def told(profiles: list[Floats]) -> Outlines:
    count = len(profiles)
    optics = Optics(np.zeros(count, np.int64), np.full(count, FILTER_PX), np.ones(count))
    return outlines_of(np.stack(profiles), optics, np.ones(count))


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(("root", "slope"), [(0.3, 0.0), (0.8, 0.0), (0.5, 0.2), (0.0, 0.3), (-0.2, 0.1)])
def test_an_outline_is_where_the_surface_ends(
    root: float, slope: float, sign: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("vision_server.pose.outline_profiles.SEEMING_BLUR_RATIO", 1.0)
    fine = np.linspace(-1.0, 1.0, 201)
    steepest = fine[np.argmax([profile(root, slope, -u)[REACH_STEPS] for u in fine])]
    for place in (-0.4, 0.0, 0.37):
        seen = [sign * one for one in (profile(root, slope, place), profile(0.0, 0.0), profile(0.0, 0.0))]
        assert abs(float(told(seen).place[0]) - place) < max(0.08, 0.3 * abs(steepest))


def test_all_outlines_of_an_image_tell_its_blur() -> None:
    """And what is shaded tells it worse."""
    even, shaded = told([profile(0.05 * k, 0.0) for k in range(5)]), told([profile(0.8, 0.5)] * 5)
    assert np.abs(even.place).max() < 0.1
    assert (even.shared > 0.0).all()
    assert np.median(even.shared) < 0.5 * np.median(shaded.shared)


def test_an_outline_beside_something_else_is_unsure() -> None:
    beside = profile(0.2, 0.0) + 0.4 * np.roll(profile(0.0, 0.0), -2)
    seen = told([profile(0.2, 0.0), profile(0.0, 0.0), beside])
    assert seen.sd[2] > 3.0 * seen.sd[0]


def test_of_a_body_outlines_are_off_by_what_is_said() -> None:
    off: list[Floats] = []
    for number in range(3):
        rng = np.random.default_rng((74, 64, number))
        model = Model.of_surface("body", surface_of(ROUND["body"](64)))
        true = random_view(rng, model, CAMERA)
        channels = one_image(rendered(model, CAMERA, true, rng)).gradients(["i1"])
        problem = with_line_scales(PoseProblem.at_scale(channels, model, CAMERA), true)
        seen = observe(problem, true, 3.0, spacing_for(model, CAMERA, true))
        courses = courses_of(problem, seen, np.zeros((len(seen.along), 2)))
        shared = courses.motion[:, 0, BLUR]
        assert (shared * seen.inside[np.searchsorted(seen.samples.line, courses.line)] >= 0.0).all()
        sd = np.sqrt(courses.spread**2 + courses.noise[:, 0, 0] + shared**2)
        off.append(np.stack([courses.place[:, 0], sd]))
    place, sd = np.concatenate(off, axis=1)
    assert np.median(np.abs(place)) < 0.06  # px
    assert np.mean(np.abs(place) > 3.0 * sd) < 0.05
