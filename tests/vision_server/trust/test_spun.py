"""A nearly round part whose rims fit at any turn is turned until its bolts fit too."""

import math

import numpy as np
import pytest

from benchmarks.machined_parts import ROUND, circle, drilled, surface_of
from benchmarks.synthetic_parts import random_view, rendered
from geometry.camera import Camera
from geometry.model import Model, find_target, load_model
from geometry.pose import Pose, PoseError
from geometry.rotation import matrix_of
from geometry.turns import round_axes, turned_about
from tests.vision_server.synthetic import one_image
from vision_server.pose.observation import PoseProblem
from vision_server.pose.sampling import spacing_for
from vision_server.trust.probability import odds
from vision_server.trust.ranking import best_first
from vision_server.trust.rivals import turned_round
from vision_server.trust.spun import spun

CAMERA = Camera(640, 480, 768.0, 768.0, 319.5, 239.5)


@pytest.fixture(scope="module")
def flange() -> Model:
    return Model.of_surface("flange", surface_of(ROUND["flange"](96)))


def test_a_flange_is_round_about_its_axis_and_others_are_not(flange: Model) -> None:
    ((axis, _),) = round_axes(flange)
    np.testing.assert_array_equal(axis, [0.0, 0.0, 1.0])
    assert round_axes(load_model(find_target("satellite"))) == ()
    assert round_axes(Model.of_surface("cylinder", surface_of(ROUND["cylinder"](96)))) == ()


def off(pose: Pose, true: Pose, axis: np.ndarray, centre: np.ndarray) -> PoseError:
    """From the nearest of the six poses that look alike."""
    alike = [turned_about(true, axis, centre, k * math.pi / 3.0) for k in range(6)]
    return min((pose.error_to(one) for one in alike), key=lambda one: one.rotation_deg)


@pytest.mark.parametrize("off_deg", [-24.0, 20.0])
def test_the_bolts_are_found_from_a_pose_that_is_turned(flange: Model, off_deg: float) -> None:
    rng = np.random.default_rng(3)
    true = random_view(rng, flange, CAMERA)
    images = one_image(rendered(flange, CAMERA, true, rng))
    problem = PoseProblem.at_scale(images.gradients(["i1"]), flange, CAMERA)
    ((axis, centre),) = round_axes(flange)
    start = turned_about(true, axis, centre, math.radians(off_deg))
    found = spun(problem, start, 2.0 * spacing_for(flange, CAMERA, start), math.radians(50.0))
    assert [one.error_to(true).rotation_deg < 4.0 for one in found] == [True]  # and not 60 degrees from it
    first = best_first(problem, [start], spin_rad=math.radians(50.0))[0]
    assert first.pose.error_to(true).within(1.0, 0.01)
    left = best_first(problem, [start])[0]
    assert not off(left.pose, true, axis, centre).within(1.0, 0.01)


def test_a_pose_that_is_right_is_left(flange: Model) -> None:
    rng = np.random.default_rng(4)
    true = random_view(rng, flange, CAMERA)
    images = one_image(rendered(flange, CAMERA, true, rng))
    problem = PoseProblem.at_scale(images.gradients(["i1"]), flange, CAMERA)
    assert spun(problem, true, spacing_for(flange, CAMERA, true), math.pi) == []


TANK = np.array([[0.055, -0.0025], [0.06, -0.0025], [0.06, 0.0025], [0.055, 0.0025]])


@pytest.fixture(scope="module")
def stage() -> Model:
    """A stepped body with many rims, and one little tank beside it."""
    rims = [
        drilled(circle(radius, 64), [], z, z + 0.02)
        for radius, z in ((0.05, 0.0), (0.04, 0.02), (0.03, 0.04))
    ]
    return Model.of_surface("stage", surface_of([*rims, drilled(TANK, [], 0.006, 0.011)]))


def looking(model: Model, tank_deg: float) -> Pose:
    """From above and aside, the tank at an angle about the axis: 90 is behind the body."""
    turn = matrix_of(np.radians([115.0, 0.0, 0.0])) @ matrix_of(np.radians([0.0, 0.0, tank_deg]))
    return Pose.from_matrix(turn, np.array([0.0, 0.0, 0.3]) - turn @ model.middle)


@pytest.mark.parametrize(("tank_deg", "seen"), [(-60.0, True), (90.0, False)])
def test_turns_are_rivals_where_what_tells_them_is_out_of_sight(
    stage: Model, tank_deg: float, seen: bool
) -> None:
    true = looking(stage, tank_deg)
    images = one_image(rendered(stage, CAMERA, true, np.random.default_rng(5)))
    problem = PoseProblem.at_scale(images.gradients(["i1"]), stage, CAMERA)
    best = best_first(problem, [true])[0]
    rivals = turned_round(best)
    assert (rivals == []) == seen
    if not seen:
        ((pose, support),) = rivals
        assert pose.error_to(true).rotation_deg > 2.0
        assert odds(support.evidence - best.support.evidence) > 0.5


def test_a_turn_that_is_hardly_better_is_looked_at(stage: Model, monkeypatch: pytest.MonkeyPatch) -> None:
    """All rims fit at the other turn, too; the tank is little of what is in sight."""
    true, ((axis, centre),) = looking(stage, -60.0), round_axes(stage)
    start = turned_about(true, axis, centre, math.radians(30.0))
    images = one_image(rendered(stage, CAMERA, true, np.random.default_rng(6)))
    problem = PoseProblem.at_scale(images.gradients(["i1"]), stage, CAMERA)
    monkeypatch.setattr("vision_server.trust.spun.STRONGER", 0.1)
    found = spun(problem, start, spacing_for(stage, CAMERA, start), math.radians(50.0))
    assert any(one.error_to(true).rotation_deg < 4.0 for one in found)
