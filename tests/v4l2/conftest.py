"""The virtual camera of the kernel's driver vivid, and commands; `make test-v4l2` runs these tests."""

import json
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest

from bridge.errors import LightsAndCameraError
from image_server.v4l2.camera import V4L2Camera
from image_server.v4l2.camera_file import CameraFile, FormatTable, load_camera_file
from image_server.v4l2.controls import controls, write_control
from image_server.v4l2.node import Node
from tests.session.command import ROOT

DEADLINE_S = 600.0  # the guest is emulated

CAMERA_FILE = """
device = "{device}"
settle_frames = 1

[format]
pixel_format = "GREY"
width = 640
height = 360
frame_rate = 30.0

[controls]
osd_text_mode = 2
horizontal_flip = 0

# vivid has no exposure time: its test patterns black, grey ramp and white stand for one
[shutter]
control = "test_pattern"
steps = [[0.004, 5], [0.008, 20], [0.016, 6]]

[camera]
width = 640
height = 360
fx = 800.0
fy = 800.0
cx = 319.5
cy = 179.5
"""

RESET = ("test_pattern", "horizontal_flip", "osd_text_mode", "brightness", "percentage_of_dropped_buffers")


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


@pytest.fixture
def opened() -> Iterator[Callable[[Path], V4L2Camera]]:
    """Opens the camera of a file; closed at the end, also of a test that fails."""
    with ExitStack() as stack:

        def open_camera(file: Path) -> V4L2Camera:
            camera = V4L2Camera(load_camera_file(str(file)))
            stack.callback(camera.close)
            return camera

        yield open_camera


@pytest.fixture
def behind(fresh: str) -> Iterator[Node]:
    """The same camera, opened a second time to change what the first one has set."""
    node = Node(fresh)
    yield node
    node.close()


def _reset(device: str) -> None:
    node = Node(device)
    for control in controls(node).values():
        if control.name in RESET:
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


def run(*command: str | Path) -> "subprocess.CompletedProcess[str]":
    """A command that ends by itself."""
    return subprocess.run(
        list(map(str, command)), capture_output=True, text=True, timeout=DEADLINE_S, check=False,
        stdin=subprocess.DEVNULL,
    )  # fmt: skip


def image_server(*arguments: str | Path) -> "subprocess.CompletedProcess[str]":
    """A command of the image server."""
    return run(sys.executable, "-m", "image_server", *arguments)


def session(out: Path, *arguments: str | Path) -> tuple[int, dict[str, Any], str]:
    """A session: its exit status, its result, and what it and its servers said."""
    done = run("swipl", ROOT / "main.pl", "--out", out, "--no-report", *arguments)
    logs = "\n".join(log.read_text() for log in out.glob("*.log"))
    file = out / "result.json"
    return done.returncode, json.loads(file.read_text()) if file.is_file() else {}, done.stderr + logs
