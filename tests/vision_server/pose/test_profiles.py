"""What a line's profile tells: how much of it is no edge, and how far that has moved the edge."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from geometry.model import Model
from numerics.arrays import Floats
from tests.vision_server.refined_poses import channels_of
from tests.vision_server.synthetic import CAMERA, POSE, linear_picture, photographed
from vision_server.channels.gradients import SCALES_PX
from vision_server.pose.observation import PoseProblem, observe
from vision_server.pose.profiles import (
    MOST_MOVED_PX,
    MOST_STEP_PX,
    PROFILE_STEPS,
    SHARP_WIDTH,
    Place,
    profiles_of,
    told_by,
)

Bumps = tuple[tuple[float, float], ...]
SHARP = np.array([True])


def profile(bumps: Bumps, width: float = SHARP_WIDTH) -> tuple[Floats, float]:
    """Of edges at places and of heights, about the maximum near 0, which is at the second."""

    def at(u: Floats | float) -> Floats:
        return np.asarray(sum(h * np.exp(-0.5 * ((u - place) / width) ** 2) for place, h in bumps))

    maximum = float(minimize_scalar(lambda u: -abs(at(u)), bounds=(-1.0, 1.0), method="bounded").x)
    return at(maximum + np.arange(-PROFILE_STEPS, PROFILE_STEPS + 1))[None], maximum


@pytest.mark.parametrize("width", [0.9, 1.12, 1.6, 2.2])
def test_a_blurred_step_is_an_edge_and_nothing_else(width: float) -> None:
    told = told_by(profile(((0.0, -3.0),), width)[0], SHARP)
    assert told.rest < 0.002
    assert abs(told.moved) < 1e-9


@pytest.mark.parametrize("sign", [-1.0, 1.0])
@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize("beside", [(1.6, -0.4), (2.0, -0.3), (2.0, 0.3), (2.5, 0.3)])
def test_of_what_print_beside_an_edge_moves_it_the_profile_tells_some_and_not_too_much(
    beside: tuple[float, float], side: float, sign: float
) -> None:
    place, height = beside
    seen, moved = profile(((0.0, sign), (side * place, sign * height)))
    told = told_by(seen, SHARP)
    assert abs(moved) > 0.02
    assert 0.5 < float(told.moved[0]) / moved < 1.5
    assert told.rest > 0.003
    assert told_by(seen, ~SHARP).moved == 0.0


def test_more_beside_an_edge_is_more_rest() -> None:
    rest = [
        told_by(profile(((0.0, 1.0), (2.5, height)))[0], SHARP).rest[0] for height in (0.0, 0.1, 0.3, 0.6)
    ]
    assert np.all(np.diff(rest) > 0.0)


def test_where_anything_may_be_the_edge_it_is_left_where_it_is() -> None:
    noise = np.random.default_rng(0).normal(size=(200, 2 * PROFILE_STEPS + 1))
    told = told_by(noise, np.ones(200, bool))
    assert np.median(told.rest) > 0.4
    assert np.all(told.moved[told.rest > 0.3] == 0.0)
    assert np.abs(told.moved).max() <= MOST_MOVED_PX


def test_no_edge_at_all_tells_nothing() -> None:
    told = told_by(np.zeros((1, 2 * PROFILE_STEPS + 1)), SHARP)
    assert told.rest == 1.0
    assert told.moved == 0.0


@pytest.mark.parametrize("scale", [0, 3])
def test_what_a_profile_runs_into_is_there(model: Model, scale: int) -> None:
    """Where nobody has looked for edges before, and where an edge is as far off as it may be."""
    pixels = photographed(linear_picture(model, CAMERA, POSE, (0.3, 0.7, 0.2, 0.9, 0.5, 0.8)), seed=1)

    def problem() -> PoseProblem:
        return PoseProblem.at_scale(channels_of(pixels), model, CAMERA, scale)

    seen = observe(problem(), POSE, 3.0, 2.0)
    lines = np.unique(seen.samples.line)
    place = np.stack([np.full(len(lines), 15.0), np.zeros(len(lines))], axis=1)
    at = Place(place, lines, np.zeros(len(lines), np.int64))
    far = seen._replace(offset=np.full_like(seen.offset, 15.0))
    widely = problem()
    observe(widely, POSE, 40.0, 2.0)
    steps = np.full(len(lines), min(SCALES_PX[scale], MOST_STEP_PX))
    told, known = (profiles_of(one, far, at, steps) for one in (problem(), widely))
    np.testing.assert_array_equal(told, known)
    assert np.isfinite(told).all() and told.any()
