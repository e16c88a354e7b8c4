"""Of poses that a frame allows: the lines and the motion decide together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from geometry.model import Model
from geometry.pose import Pose
from geometry.rotation import matrix_of
from tests.vision_server.synthetic import CAMERA, POSE
from tests.vision_server.tracking.films import filmed
from vision_server.tracking.fitting import Habits
from vision_server.tracking.following import Found, Sight, likeliest, looked_again, turned_about
from vision_server.tracking.frame import Tone
from vision_server.tracking.motion import Motion


def seen(model: Model) -> Found:
    """The cuboid where it is."""
    sight = Sight(model, CAMERA, Tone.of(1.0, 0.01))
    found = sight.near(next(filmed(model, [POSE])), POSE, Habits.of(model))
    assert found is not None
    return found


def turned(found: Found, degrees: float) -> Found:
    """The same lines, as if the target were turned."""
    turn = matrix_of(np.radians([0.0, degrees, 0.0]))
    pose = Pose.from_matrix(turn @ found.pose.matrix, found.pose.translation)
    return replace(found, fit=replace(found.fit, pose=pose))


def half_seen(found: Found) -> Found:
    """With every second sample of its lines missing."""
    supports = found.support.supports.copy()
    supports[:, ::2] = False
    return replace(found, support=replace(found.support, supports=supports))


def test_of_poses_with_the_same_lines_the_foreseen_one_is_taken(model: Model) -> None:
    right = seen(model)
    other = turned(right, 3.0)
    expected = Motion.at_rest(right.pose, right.covariance, model.middle)
    assert likeliest([other, right], expected, model.middle) is right


def test_lines_tell_what_the_motion_leaves_open(model: Model) -> None:
    right = seen(model)
    other = half_seen(turned(right, 3.0))
    assert other.evidence < right.evidence - 10.0
    vague = np.diag([0.1**2] * 3 + [0.05**2] * 3)
    expected = Motion.at_rest(other.pose, vague, model.middle)
    surprises = [
        expected.innovation(one.pose, one.covariance, model.middle).squared for one in (other, right)
    ]
    assert surprises[0] < surprises[1]
    assert likeliest([other, right], expected, model.middle) is right


def test_a_look_aside_ends_where_one_from_nothing_does_and_is_dropped_if_it_comes_back(
    model: Model,
) -> None:
    right, habits, frame = seen(model), Habits.of(model), next(filmed(model, [POSE]))
    start = turned_about(right.pose, model.middle, np.radians([0.0, 3.0, 0.0]))
    anew = Sight(model, CAMERA, Tone.of(1.0, 0.01)).near(frame, start, habits)
    again = looked_again(right, start, habits)
    assert anew is not None and again is not None
    assert again.pose.error_to(anew.pose).within(0.1, 0.001)
    assert looked_again(right, start, habits, back=(0.5, 0.004)) is None
    assert looked_again(right, start, habits, back=(1e-6, 1e-9)) is not None
