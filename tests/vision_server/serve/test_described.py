"""A camera that is given, beside the one that an image server describes."""

from __future__ import annotations

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from bridge.errors import BadInput
from bridge.messages import CameraDescription, LightDescription
from geometry.pose import Pose
from tests.vision_server.synthetic import CAMERA
from vision_server.serve.described import camera_doubt, lights_doubt, used_camera

DESCRIBED = msgspec.convert(CAMERA.to_dict(), CameraDescription)


def test_what_is_described_is_used_where_no_file_is_given() -> None:
    assert used_camera(None, DESCRIBED, "ipc:///images").camera == CAMERA
    with pytest.raises(BadInput, match="No camera is given"):
        used_camera(None, None, "ipc:///images")


def test_cameras_that_differ_by_more_than_calibrations_do_are_said() -> None:
    assert camera_doubt(CAMERA, None) is None
    assert camera_doubt(replace(CAMERA, fx=1.001 * CAMERA.fx), DESCRIBED) is None
    for other in (replace(CAMERA, fx=0.95 * CAMERA.fx), replace(CAMERA, cy=CAMERA.cy + 5.0)):
        assert "describes another camera" in str(camera_doubt(other, DESCRIBED))
    assert "320x240" in str(camera_doubt(replace(CAMERA, width=2 * CAMERA.width), DESCRIBED))


def test_a_light_that_reaches_nothing_is_said() -> None:
    seed_pose = Pose(np.zeros(3), np.array([0.0, 0.0, 0.7]))
    near = LightDescription(name="a", levels=8, position=(0.3, 0.0, 0.0))
    far = LightDescription(name="b", levels=8, position=(300.0, 0.0, 0.0))
    strong = msgspec.structs.replace(far, power=1e6)
    unknown = LightDescription(name="c", levels=8)
    assert lights_doubt([near, strong, unknown], seed_pose) is None
    assert lights_doubt([far], None) is None
    assert "'b' is 300 m from the target, which is 0.7 m from the camera" in str(
        lights_doubt([near, far], seed_pose)
    )
