"""A nearly round part's turn about its own axis is seen where its lug is."""

import numpy as np
import pytest

from benchmarks.machined_parts import circle, drilled, surface_of
from benchmarks.synthetic_parts import rendered
from geometry.camera import Camera
from geometry.model import Model, find_target, load_model
from geometry.near_symmetries import near_symmetries
from geometry.pose import Pose
from geometry.rotation import matrix_of
from vision_server.tracking.fitting import Habits
from vision_server.tracking.following import Sight
from vision_server.tracking.frame import Tone
from vision_server.tracking.round_parts import turn_is_seen, turns_about_own_axes

CAMERA = Camera(640, 480, 768.0, 768.0, 319.5, 239.5)
LUG = np.array([[0.02, -0.01], [0.04, -0.01], [0.04, 0.01], [0.02, 0.01]])


def disc(*lugs: np.ndarray) -> Model:
    """A disc of 100 mm; lugs of these outlines stand on its far side."""
    solids = [drilled(circle(0.05, 48), [], -0.02, 0.0)]
    return Model.of_surface("disc", surface_of(solids + [drilled(lug, [], 0.0, 0.03) for lug in lugs]))


@pytest.mark.parametrize(("tilt_deg", "seen"), [(30.0, False), (150.0, True)])
def test_a_turn_is_seen_where_the_lug_is(tilt_deg: float, seen: bool) -> None:
    model = disc(LUG)
    turn = matrix_of(np.radians([0.0, tilt_deg, 0.0])) @ matrix_of(np.radians([0.0, 0.0, 40.0]))
    pose = Pose.from_matrix(turn, np.array([0.0, 0.0, 0.3]) - turn @ model.middle)
    pixels = rendered(model, CAMERA, pose, np.random.default_rng(2))
    found = Sight(model, CAMERA, Tone.of(1.0, 0.01)).near(pixels, pose, Habits.of(model))
    assert found is not None
    assert turn_is_seen(found, model) == seen


def test_turns_are_small_and_large_ones_and_those_onto_lugs_that_look_alike() -> None:
    thirds = [matrix_of(np.radians([0.0, 0.0, 120.0 * k]))[:2, :2] for k in range(3)]
    model = disc(*[LUG @ third.T for third in thirds], 0.3 * LUG - [0.02, 0.0])
    alike = [one for one in near_symmetries(model) if abs(one.rotation_vector[2]) > 1.0]
    turns = turns_about_own_axes(model)
    angles = np.abs(np.degrees([one.rotation_vector[2] for one in turns]))
    assert len(alike) == 2
    assert all(any(one is turn for turn in turns) for one in alike)
    assert (angles.min(), angles.max()) == pytest.approx((3.0, 180.0))


def test_parts_that_are_not_round_have_none() -> None:
    assert turns_about_own_axes(load_model(find_target("satellite"))) == ()
