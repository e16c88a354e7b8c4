"""A target that is elsewhere, in pictures that are drawn where it is."""

from dataclasses import replace

import numpy as np

from geometry.model import Model
from geometry.pose import Pose
from tests.vision_server.synthetic import CAMERA, POSE, linear_picture
from vision_server.channels.channel import channel_statistics
from vision_server.channels.gradients import gradient_channel
from vision_server.pose.observation import PoseProblem
from vision_server.prediction.target_moved import REACHES_PX, SPACING_PX, clearly_elsewhere, moved_to
from vision_server.trust.ranking import refined
from vision_server.trust.support import support_at

GREYS = (0.2, 0.8, 0.4, 0.6, 0.3, 0.7)


def problem(model: Model, pose: Pose | None) -> PoseProblem:
    picture = np.full((CAMERA.height, CAMERA.width), 0.05)
    if pose is not None:
        picture = linear_picture(model, CAMERA, pose, GREYS, background=0.05)
    noise = np.random.default_rng(1).normal(0.0, 1.5, picture.shape)
    pixels = np.clip(255.0 * picture + noise, 0, 255).astype(np.uint8)
    channel = gradient_channel("i", channel_statistics(pixels, 1.0, 1.0))
    return PoseProblem.at_scale([channel], model, CAMERA)


def test_a_target_that_moved_by_a_hundredth_of_the_range_is_found_where_it_is(model: Model) -> None:
    range_m = float(np.linalg.norm(POSE.translation))
    for step in ([0.01, 0.0, 0.0], [0.0, -0.01, 0.0], [0.007, 0.007, 0.0]):
        there = Pose(POSE.rotation_vector, POSE.translation + range_m * np.array(step))
        found = moved_to(problem(model, there), POSE)
        assert found is not None
        assert found.error_to(there).within(0.3, 0.003)


def test_nothing_is_said_of_a_target_that_stayed_or_cannot_be_seen(model: Model) -> None:
    assert moved_to(problem(model, POSE), POSE) is None
    assert moved_to(problem(model, None), POSE) is None


def test_a_place_without_more_evidence_is_no_other_place(model: Model) -> None:
    there = Pose(POSE.rotation_vector, POSE.translation + np.array([0.01, 0.0, 0.0]))
    shown = problem(model, there)
    found, here = refined(shown, there, REACHES_PX, SPACING_PX), support_at(shown, POSE, SPACING_PX)
    assert found is not None
    assert here is not None
    assert clearly_elsewhere(found, POSE, here)
    assert not clearly_elsewhere(found, POSE, replace(found.support, strength=0.0))
