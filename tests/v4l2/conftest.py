"""The virtual camera of the kernel's driver vivid; `make test-v4l2` runs these tests where there is one."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from bridge.errors import LightsAndCameraError
from image_server.v4l2.camera import V4L2Camera
from image_server.v4l2.camera_file import CameraFile, FormatTable
from image_server.v4l2.controls import controls, write_control
from image_server.v4l2.node import Node

CAMERA_FILE = """
device = "{device}"
settle_frames = 1

[format]
pixel_format = "GREY"
width = 640
height = 360
frame_rate = 30.0

[controls]
test_pattern = 20
osd_text_mode = 2

# vivid has no exposure time: its brightness stands for one
[shutter]
control = "brightness"
steps = [[0.004, 64], [0.008, 128], [0.016, 192]]

[camera]
width = 640
height = 360
fx = 800.0
fy = 800.0
cx = 319.5
cy = 179.5
"""


@pytest.fixture(scope="session")
def vivid() -> str:
    """Device node of the first virtual camera, or a skip that says how to get one."""
    for path in sorted(Path("/dev").glob("video*")):
        try:
            node = Node(str(path))
        except LightsAndCameraError:
            continue
        driver = node.driver
        node.close()
        if driver == "vivid":
            return str(path)
    pytest.skip("no virtual camera (driver vivid) on this machine: run make test-v4l2")


@pytest.fixture
def fresh(vivid: str) -> Iterator[str]:
    """The virtual camera with every control at its default."""
    _reset(vivid)
    yield vivid
    _reset(vivid)


def _reset(device: str) -> None:
    node = Node(device)
    for control in controls(node).values():
        if control.name in (
            "brightness",
            "contrast",
            "test_pattern",
            "percentage_of_dropped_buffers",
            "autogain",
        ):
            write_control(node, control, control.default)
    node.close()


@pytest.fixture
def camera_file(fresh: str, tmp_path: Path) -> Path:
    """A camera file for the virtual camera."""
    file = tmp_path / "camera.toml"
    file.write_text(CAMERA_FILE.format(device=fresh))
    return file


def small(device: str, pixel_format: str | None = None) -> V4L2Camera:
    """The camera at a size that needs little time."""
    table = FormatTable(pixel_format=pixel_format, width=640, height=360, frame_rate=30.0)
    return V4L2Camera(
        CameraFile(device=device, format=table, controls={"test_pattern": 20, "osd_text_mode": 2})
    )
