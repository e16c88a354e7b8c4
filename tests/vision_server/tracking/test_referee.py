"""Judging poses of a cuboid: right, wrong, and of what is not there."""

from dataclasses import replace

import numpy as np
import pytest

from geometry.model import Model
from geometry.pose import Pose
from tests.vision_server.synthetic import CAMERA, POSE, linear_picture, one_image, photographed
from tests.vision_server.tracking.films import GREYS
from vision_server.image_set import ImageSet
from vision_server.pose.covariance import share_within
from vision_server.tracking.referee import (
    LOST,
    OK,
    Around,
    chances_of,
    judged,
    probability,
)


@pytest.fixture(scope="module")
def images(model: Model) -> ImageSet:
    return one_image(photographed(linear_picture(model, CAMERA, POSE, GREYS), 0.8))


@pytest.mark.parametrize("degrees", [0.0, 0.75])
def test_a_right_pose_is_ok(model: Model, images: ImageSet, degrees: float) -> None:
    given = Pose(POSE.rotation_vector + np.radians([degrees, 0.0, 0.0]), POSE.translation)
    found = judged(images, ["i1"], model, CAMERA, given)
    assert found.state == "ok"
    assert (found.better is None) == (degrees == 0.0)


@pytest.mark.parametrize("degrees", [2.0, 8.0])
def test_a_wrong_pose_is_lost_and_a_better_one_named(model: Model, images: ImageSet, degrees: float) -> None:
    given = Pose(POSE.rotation_vector + np.radians([0.0, degrees, 0.0]), POSE.translation)
    found = judged(images, ["i1"], model, CAMERA, given)
    assert found.state == "lost"
    assert found.better is not None
    assert found.better.error_to(POSE).within(0.3, 0.003)


def test_a_pose_of_what_is_not_there_is_lost(model: Model) -> None:
    noise = np.random.default_rng(0).normal(60.0, 3.0, (CAMERA.height, CAMERA.width)).astype(np.uint8)
    found = judged(one_image(noise), ["i1"], model, CAMERA, POSE)
    assert (found.state, found.better) == ("lost", None)
    assert len(found.disagreeing) >= 7


KNOWN = Around(POSE, np.diag([1e-8] * 3 + [1e-10] * 3), 30.0, 1.0, 0.98)


def test_of_two_poses_that_explain_as_much_each_is_believed_half() -> None:
    turned = replace(KNOWN, pose=POSE.stepped([0.0, 0.0, 1.0, 0.0, 0.0, 0.0]))
    alone = probability(chances_of([KNOWN], POSE))
    assert alone > OK
    assert probability(chances_of([KNOWN, turned], POSE)) == pytest.approx(0.5 * alone, abs=0.02)
    assert probability(chances_of([replace(KNOWN, nats=60.0), turned], POSE)) == pytest.approx(
        alone, abs=0.01
    )
    assert probability(chances_of([KNOWN, replace(turned, nats=60.0)], POSE)) < LOST


@pytest.mark.parametrize("degrees", [0.0, 0.7, 1.2])
def test_the_share_within_limits_is_that_of_poses_drawn_one_by_one(degrees: float) -> None:
    given = POSE.stepped(np.r_[0.0, np.radians(degrees), 0.0, 0.001, 0.0, 0.0])
    spread = np.diag([np.radians(0.4) ** 2] * 3 + [0.0015**2] * 3)
    rng = np.random.default_rng(1)
    drawn = [POSE.stepped(step) for step in rng.multivariate_normal(np.zeros(6), spread, 4000)]
    expected = np.mean([given.error_to(one).within(1.0, 0.01) for one in drawn])
    assert share_within((1.0, 0.01), POSE, spread, given) == pytest.approx(expected, abs=0.06)


def test_probability_grows_with_what_is_believed() -> None:
    stated = [probability(((1.0, believed),)) for believed in (0.0, 0.1, 0.3, 0.6, 0.9, 1.0)]
    assert stated == sorted(stated)
    assert stated[0] < LOST < OK < stated[-1]
