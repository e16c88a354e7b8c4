"""A camera that is given, beside the one that an image server describes."""

from __future__ import annotations

from dataclasses import replace

import msgspec
import pytest

from bridge.errors import BadInput
from bridge.messages import CameraDescription
from tests.vision_server.synthetic import CAMERA
from vision_server.serve.described import camera_doubt, used_camera

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
