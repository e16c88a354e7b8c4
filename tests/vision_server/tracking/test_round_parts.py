"""A nearly round part's turn about its own axis is seen where its lug is."""

import numpy as np
import pytest

from benchmarks.machined_parts import circle, drilled, surface_of
from benchmarks.synthetic_parts import rendered
from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from geometry.rotation import matrix_of
from vision_server.tracking.fitting import Habits
from vision_server.tracking.following import Sight
from vision_server.tracking.frame import Tone
from vision_server.tracking.round_parts import turn_is_seen

CAMERA = Camera(640, 480, 768.0, 768.0, 319.5, 239.5)
LUG = np.array([[0.02, -0.01], [0.04, -0.01], [0.04, 0.01], [0.02, 0.01]])


def disc() -> Model:
    """A disc of 100 mm; a lug stands on its far side."""
    solids = [drilled(circle(0.05, 48), [], -0.02, 0.0), drilled(LUG, [], 0.0, 0.03)]
    return Model.of_surface("disc", surface_of(solids))


@pytest.mark.parametrize(("tilt_deg", "seen"), [(30.0, False), (150.0, True)])
def test_a_turn_is_seen_where_the_lug_is(tilt_deg: float, seen: bool) -> None:
    model = disc()
    turn = matrix_of(np.radians([0.0, tilt_deg, 0.0])) @ matrix_of(np.radians([0.0, 0.0, 40.0]))
    pose = Pose.from_matrix(turn, np.array([0.0, 0.0, 0.3]) - turn @ model.middle)
    pixels = rendered(model, CAMERA, pose, np.random.default_rng(2))
    found = Sight(model, CAMERA, Tone.of(1.0, 0.01)).near(pixels, pose, Habits.of(model))
    assert found is not None
    assert turn_is_seen(found, model) == seen
