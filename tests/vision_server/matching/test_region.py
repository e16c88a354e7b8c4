"""The part of a large frame that a search looks at holds the target at every pose of its range."""

from dataclasses import replace

import numpy as np
import pytest

from geometry.camera import Camera
from geometry.model import find_target, load_model
from geometry.pose import Pose, disturbed
from vision_server.matching import SearchRange
from vision_server.matching.region import MOST_REGION_SHARE, region_of

CAMERA = Camera(4000, 3000, 4800.0, 4800.0, 1999.5, 1499.5)
LENS = replace(CAMERA, distortion=(-0.3, 0.12, 0.001, -0.001, 0.0))
POSE = Pose(np.array([0.5, 0.4, 0.2]), np.array([0.3, -0.2, 4.0]))
REACH = SearchRange(25.0, 250.0)


@pytest.mark.parametrize("camera", [CAMERA, LENS])
@pytest.mark.parametrize("aside", [0.0, 3.0])
def test_the_target_is_in_it_at_any_pose_of_the_range(camera: Camera, aside: float) -> None:
    model = load_model(find_target("satellite"))
    shift = np.array([aside, 0.0, 0.0])
    model, start = replace(model, vertices=model.vertices + shift), POSE.compose(Pose(np.zeros(3), -shift))
    region = region_of(model, camera, start, REACH)
    assert region is not None
    left, top, right, bottom = region
    assert (right - left) * (bottom - top) < MOST_REGION_SHARE * camera.width * camera.height
    rng = np.random.default_rng(1)
    for _ in range(100):
        pose = disturbed(POSE, rng, REACH.rotation_deg, REACH.translation_px, camera.fx)
        seen = camera.project(pose.apply(model.vertices - shift))
        inside = ((seen >= 0) & (seen < [camera.width, camera.height])).all(axis=1)
        assert (seen[inside] >= [left, top]).all()
        assert (seen[inside] < [right, bottom]).all()


@pytest.mark.parametrize(
    ("camera", "place"),
    [
        (Camera(640, 480, 768.0, 768.0, 319.5, 239.5), [0.3, -0.2, 4.0]),  # little is saved
        (CAMERA, [0.0, 0.0, 0.9]),  # it fills the frame
        (CAMERA, [0.0, 0.0, 0.2]),  # it may surround the camera
        (CAMERA, [30.0, 0.0, 4.0]),  # it is outside
    ],
)
def test_else_the_whole_frame_is_looked_at(camera: Camera, place: list[float]) -> None:
    model = load_model(find_target("satellite"))
    assert region_of(model, camera, Pose(POSE.rotation_vector, np.array(place)), REACH) is None
