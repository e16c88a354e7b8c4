"""Judging poses of a cuboid: right, wrong, and of what is not there."""

from dataclasses import replace

import numpy as np
import pytest

from geometry.model import Model
from geometry.pose import Pose
from tests.vision_server.synthetic import CAMERA, POSE, linear_picture, one_image, photographed
from tests.vision_server.tracking.films import GREYS
from vision_server.image_set import ImageSet
from vision_server.tracking.referee import Evidence, judged, probability


@pytest.fixture(scope="module")
def images(model: Model) -> ImageSet:
    return one_image(photographed(linear_picture(model, CAMERA, POSE, GREYS), 0.8))


@pytest.mark.parametrize("degrees", [0.0, 0.3])
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


def test_probability_grows_with_each_evidence() -> None:
    middle = Evidence(believed=0.9, within=0.8, worth=0.5, turned=0.3)
    assert probability(replace(middle, believed=0.99)) > probability(middle)
    assert probability(replace(middle, within=0.99)) > probability(middle)
    assert probability(replace(middle, turned=0.9)) <= probability(middle)
