"""Which images of a set speak against a pose, as something in the scene has moved."""

import numpy as np
import pytest

from geometry.model import Model
from geometry.pose import Pose
from tests.vision_server.synthetic import CAMERA, POSE, linear_picture, one_image, photographed
from tests.vision_server.tracking.films import GREYS
from vision_server.image_set import ImageSet
from vision_server.pipeline import PipelineSettings
from vision_server.serve import witnesses
from vision_server.serve.witnesses import disagreeing_images


@pytest.fixture(scope="module")
def images(model: Model) -> ImageSet:
    """Two of a still scene."""
    found = one_image(photographed(linear_picture(model, CAMERA, POSE, GREYS), 0.8))
    found.add("i2", photographed(linear_picture(model, CAMERA, POSE, GREYS[::-1]), 0.8), 1.0, 1.0)
    return found


def test_images_that_all_show_a_better_pose_are_of_a_still_scene(
    model: Model, images: ImageSet, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A pose that is a little off is shown by one image, where its lines are soft, and not by another."""
    off = Pose(POSE.rotation_vector + np.radians([0.0, 3.0, 0.0]), POSE.translation)
    support = witnesses._support
    softer: list[float] = []

    def of_soft_lines(problem: object, pose: Pose) -> float:
        if pose is not off:
            return support(problem, pose)  # type: ignore[arg-type]
        softer.append(1.0)
        return 1.0 if len(softer) == 1 else 0.0

    monkeypatch.setattr(witnesses, "_support", of_soft_lines)
    monkeypatch.setattr(witnesses, "_is_elsewhere", lambda *_: True)
    settings = PipelineSettings()
    assert disagreeing_images(images, ["i1", "i2"], model, CAMERA, off, None, settings) == ["i2"]
    softer.clear()
    assert disagreeing_images(images, ["i1", "i2"], model, CAMERA, off, POSE, settings) == []
