"""Parts that are not quite their model, as their lines tell."""

from dataclasses import replace

import numpy as np
import pytest

from experiments.kinds.estimate import normalised_error_squared
from geometry.model import Model
from tests.vision_server.refined_poses import UNKNOWNS, drawn_courses, found, misshapen
from tests.vision_server.synthetic import POSE
from vision_server.trust import settling
from vision_server.trust.settling import T_FREEDOM, Settled, settled
from vision_server.trust.tolerance import are_off, with_tolerance

USUAL_M = 1e-4  # of a part of 0.2 m
LINES = 40
OFF = 0.001  # of the size


@pytest.mark.parametrize("seed", range(4))
def test_lines_that_are_off_by_more_than_was_foreseen_say_so(seed: int) -> None:
    courses, true = drawn_courses(LINES, seed)
    assert not are_off(courses, true, USUAL_M, T_FREEDOM)
    courses.place[:] += np.random.default_rng(seed).normal(0.0, 0.3, courses.place.shape)
    assert are_off(courses, true, USUAL_M, T_FREEDOM)


def test_a_few_that_lie_on_something_else_do_not_speak_for_all() -> None:
    courses, true = drawn_courses(LINES, 0)
    courses.place[:3] += 2.0
    assert not are_off(courses, true, USUAL_M, T_FREEDOM)


def test_a_tolerance_is_as_many_pixels_as_the_part_moves_in_the_image() -> None:
    courses, _ = drawn_courses(LINES, 0)
    courses.motion[:] = 0.0
    courses.motion[:, 0, 4], courses.spread[:] = 500.0, 0.3
    np.testing.assert_allclose(with_tolerance(courses, 0.0008).spread, 0.5)
    assert with_tolerance(courses, 0.0008).motion.shape[2] == UNKNOWNS


def ends(model: Model, part: Model, seed: int, *tolerances: tuple[float, float]) -> list[Settled]:
    """Where a pose ends with tolerances that are told and untold, shares of the size."""
    best, out = found(part, model, seed), []
    for told, untold in np.array(tolerances) * model.diameter:
        problem = replace(best.problem, tolerance_m=told, untold_tolerance_m=untold)
        last = settled(replace(best, problem=problem))
        assert last is not None
        out.append(last)
    return out


def test_the_covariance_of_a_part_that_is_off_is_honest_though_nobody_has_told(model: Model) -> None:
    squares = []
    for seed in range(8):
        part = misshapen(model, np.random.default_rng(seed), OFF)
        pair = ends(model, part, seed, (0.0, 0.0), (0.0, OFF))
        squares.append([normalised_error_squared(one.best.pose, one.covariance, POSE) for one in pair])
    exact, allowed = np.mean(squares, axis=0)
    assert exact > 50.0
    assert 2.0 < allowed < 10.0  # 6 are expected


def test_lines_that_ask_for_it_are_allowed_to_be_off_in_the_fit(
    model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    part = misshapen(model, np.random.default_rng(3), OFF)
    monkeypatch.setattr(settling, "are_off", lambda *_: True)
    exact, asked = ends(model, part, 3, (0.0, 0.0), (0.0, OFF))
    off = [one.best.pose.error_to(POSE).rotation_deg for one in (exact, asked)]
    assert off[1] < off[0]
    assert asked.agreement is not None and exact.agreement is not None
    assert asked.agreement.share == pytest.approx(exact.agreement.share, abs=0.01)  # as if it were its model
