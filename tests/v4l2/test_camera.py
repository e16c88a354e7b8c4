"""The camera on a real kernel driver: formats, controls, freshness, read-back and what goes wrong."""

import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from bridge.errors import BadInput, DeviceError
from bridge.messages import Settings
from image_server.hardware import Hardware
from image_server.serve.device import Change
from image_server.v4l2.camera import V4L2Camera
from image_server.v4l2.controls import controls, read_control, write_control
from image_server.v4l2.kernel import REQUESTS
from image_server.v4l2.node import Node
from tests.v4l2.conftest import small

SHUTTERS_S = (0.004, 0.008, 0.016)


def at(shutter_s: float) -> Settings:
    return Settings(lights=(), shutter_s=shutter_s, aperture=4.0)


Opened = Callable[[Path], V4L2Camera]


# --- frames ---


def test_every_format_shows_the_same_picture(fresh: str) -> None:
    pictures = {}
    for name in ("GREY", "Y16", "YUYV"):
        camera = small(fresh, name)
        exposure = camera.capture(at(camera.shutters_s[0]), time.monotonic())
        camera.close()
        assert exposure.verified
        pictures[name] = exposure.pixels.astype(int)
        assert pictures[name].shape == (360, 640)
    assert pictures["GREY"].std() > 50  # a ramp
    for name in ("Y16", "YUYV"):
        assert np.abs(pictures[name] - pictures["GREY"]).max() <= 2


def test_a_setting_shows_in_the_very_next_frame(camera_file: Path, opened: Opened) -> None:
    camera = opened(camera_file)
    for shutter_s, mean in ((0.004, 0), (0.016, 255), (0.008, 127), (0.016, 255), (0.004, 0)):
        exposure = camera.capture(at(shutter_s), time.monotonic())
        assert exposure.verified
        assert exposure.applied == {"shutter_s": shutter_s}
        assert exposure.pixels.mean() == pytest.approx(mean, abs=5)


def test_frames_that_waited_are_stale(camera_file: Path, opened: Opened, behind: Node) -> None:
    """The queue fills while nobody asks; then a control changes behind the camera's back."""
    camera = opened(camera_file)
    assert camera.capture(at(0.016), time.monotonic()).pixels.mean() > 250
    time.sleep(0.5)
    write_control(behind, controls(behind)["test_pattern"], 5)
    time.sleep(0.2)
    exposure = camera.capture(at(0.016), time.monotonic())
    assert exposure.pixels.mean() < 5
    assert not exposure.verified


def test_a_control_that_does_not_hold_is_told(camera_file: Path, opened: Opened, behind: Node) -> None:
    camera = opened(camera_file)
    assert camera.capture(at(0.008), time.monotonic()).verified
    known = controls(behind)
    write_control(behind, known["horizontal_flip"], 1)  # one of the fixed ones
    assert not camera.capture(at(0.008), time.monotonic()).verified
    write_control(behind, known["horizontal_flip"], 0)
    assert camera.capture(at(0.008), time.monotonic()).verified
    write_control(behind, known["test_pattern"], 13)
    exposure = camera.capture(at(0.008), time.monotonic())
    assert not exposure.verified
    assert exposure.applied["shutter_s"] == pytest.approx(0.012)  # half way between 6 and 20


def test_lost_and_damaged_frames_are_counted(camera_file: Path, opened: Opened, behind: Node) -> None:
    camera = opened(camera_file)
    known = controls(behind)
    write_control(behind, known["percentage_of_dropped_buffers"], 60)
    for _ in range(20):
        camera.next_frame()
    write_control(behind, known["percentage_of_dropped_buffers"], 0)
    assert camera.health()["lost_frames"] > 0
    assert camera.health()["damaged_frames"] == 0
    press(behind, "inject_v4l2_buf_flag_error")
    for _ in range(8):
        camera.next_frame()
    assert camera.health()["damaged_frames"] == 1


def press(node: Node, name: str) -> None:
    """Press a button: it cannot be read back."""
    node.request("S_CTRL", REQUESTS["S_CTRL"][1](controls(node)[name].number, 1))


def test_a_stream_that_fails_is_started_again(camera_file: Path, opened: Opened, behind: Node) -> None:
    camera = opened(camera_file)
    camera.capture(at(0.008), time.monotonic())
    press(behind, "inject_fatal_streaming_error")
    exposure = camera.capture(at(0.016), time.monotonic())
    assert exposure.verified
    assert camera.health()["retries"] == 1


# --- controls ---


def test_controls_have_ranges_and_menus(fresh: str) -> None:
    node = Node(fresh)
    known = controls(node)
    brightness = known["brightness"]
    assert (brightness.minimum, brightness.maximum, brightness.step) == (0, 255, 1)
    assert known["menu"].menu == {1: "Menu Item 1", 3: "Menu Item 3", 4: "Menu Item 4"}  # with a hole
    assert known["integer_menu"].menu[8] == "42"
    assert known["read_only_integer_32_bits"].read_only
    assert write_control(node, brightness, 200) == 200
    assert read_control(node, brightness) == 200
    with pytest.raises(BadInput, match=rf"{fresh}: brightness = 256 is out of range. Allowed: 0 to 255"):
        write_control(node, brightness, 256)
    with pytest.raises(BadInput, match=r"menu = 2 is out of range. Allowed: 1 \(Menu Item 1\), 3"):
        write_control(node, known["menu"], 2)
    with pytest.raises(
        DeviceError, match=rf"{fresh} refuses read_only_integer_32_bits = 1: it cannot be set"
    ):
        write_control(node, known["read_only_integer_32_bits"], 1)
    node.close()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"test_pattern"', '"exposure_absolute"', "has no control exposure_absolute"),
        ("[0.016, 6]", "[0.016, 60]", "test_pattern = 60 is out of range"),
        ("osd_text_mode = 2", "osd_text_mode = 7", "osd_text_mode = 7 is out of range"),
        ("osd_text_mode = 2", "read_only_integer_32_bits = 2", "cannot be set"),
        (
            "width = 640\nheight = 360\nframe",
            "width = 641\nheight = 360\nframe",
            "does not offer GREY at 641×360",
        ),
        ('"GREY"', '"MJPG"', "does not offer format MJPG"),
        ("frame_rate = 30.0", "frame_rate = 1000.0", "does not offer 1000 frames/s"),
        ("settle_frames = 1", 'card = "Other"', "is 'vivid', but its file was made for 'Other'"),
        ("settle_frames = 1", "settle = 1", "unknown key"),
        ("[0.008, 20]", "[0.004, 20]", "two steps of the same value"),
    ],
)
def test_a_camera_file_that_does_not_fit_says_where(
    camera_file: Path, opened: Opened, old: str, new: str, message: str
) -> None:
    text = camera_file.read_text()
    assert old in text
    camera_file.write_text(text.replace(old, new, 1))
    with pytest.raises(BadInput, match=message):
        opened(camera_file)


# --- devices that cannot be used ---


def test_a_camera_in_use_is_busy(camera_file: Path, opened: Opened) -> None:
    camera = opened(camera_file)
    with pytest.raises(DeviceError, match=r"is busy .* Another program"):
        opened(camera_file)
    camera.close()
    opened(camera_file)


def test_no_permission_says_which_group(fresh: str) -> None:
    code = (
        "import os, sys; from image_server.v4l2.node import Node; os.setgid(65534); os.setuid(65534)\n"
        f"try: Node('{fresh}')\nexcept Exception as error: sys.exit(str(error))"
    )
    os.chmod(fresh, 0o600)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert f"No permission to use the camera {fresh}" in done.stderr
    assert "video" in done.stderr


def test_other_nodes_are_no_cameras(fresh: str) -> None:
    outputs = 0
    for path in Path("/dev").glob("video*"):
        try:
            Node(str(path)).close()
        except BadInput as error:
            assert str(path) in error.message and "not a camera" in error.message
            outputs += 1
    assert outputs  # vivid has nodes for video output beside that for capture


def test_an_unplugged_camera_is_an_event_and_an_error(camera_file: Path, opened: Opened) -> None:
    """On the second virtual camera: what has been disconnected does not come back."""
    cameras = [path for path in sorted(Path("/dev").glob("video*")) if _is_camera(path)]
    last = str(cameras[-1])
    assert last not in camera_file.read_text()
    text = camera_file.read_text()
    camera_file.write_text(text.replace(text.split('"')[1], last))
    hardware = Hardware(opened(camera_file))
    changes: list[Change] = []
    hardware.listen(changes.append)
    assert hardware.capture(at(0.008)).verified
    other = Node(last)
    press(other, "disconnect")
    other.close()
    with pytest.raises(DeviceError, match=rf"The camera {last} is gone .*unplugged"):
        hardware.capture(at(0.016))
    assert [change.event for change in changes] == ["camera_fault"]
    assert last in hardware.health()["status"]
    hardware.close()


def _is_camera(path: Path) -> bool:
    try:
        Node(str(path)).close()
    except (BadInput, DeviceError):
        return False
    return True
