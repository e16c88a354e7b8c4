"""The kernel's driver of USB cameras, uvcvideo, on emulated cameras with the controls of real ones.

The camera is plugged into the virtual USB controller (vhci-hcd) and answers as a device does; what comes back
from the kernel is traffic of the real driver: exposure, white balance, focus, zoom, iris and MJPEG.
"""

import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from bridge.errors import BadInput, DeviceError
from bridge.messages import Settings
from geometry.pose import Pose
from image_server.device import Change
from image_server.emulators.usbip import CONTROLLER
from image_server.hardware import Hardware
from image_server.lights.rig import open_rig
from image_server.simulator import Simulator
from image_server.v4l2.camera import V4L2Camera
from image_server.v4l2.camera_file import CameraFile, FormatTable, load_camera_file
from image_server.v4l2.controls import controls, read_control, write_control
from image_server.v4l2.node import Node
from tests.v4l2.conftest import image_server, session

DEADLINE_S = 120.0  # the guest is emulated
SEED = 3

pytestmark = pytest.mark.skipif(
    not CONTROLLER.exists(), reason="no virtual USB controller (vhci-hcd) on this machine: run make test-v4l2"
)


@dataclass
class Bench:
    """A running `bench` command."""

    process: "subprocess.Popen[str]"
    folder: Path
    camera: str
    lights: str

    def fault(self, kind: str) -> None:
        """Have a fault, and wait until it is there."""
        assert self.process.stdin is not None
        self.process.stdin.write(f"{kind}\n")
        self.process.stdin.flush()
        self.word("fault")

    def word(self, first: str) -> str:
        """The rest of the next line that begins with a word."""
        assert self.process.stdout is not None
        for line in self.process.stdout:
            if line.startswith(first):
                return line.split(maxsplit=1)[1].strip()
        raise AssertionError(f"the bench ended without {first!r}: {self.process.stderr}")


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Callable[..., Bench]]:
    """Starts benches; all are gone at the end."""
    running: list[subprocess.Popen[str]] = []

    def start(*arguments: str) -> Bench:
        folder = tmp_path / "bench"
        command = [sys.executable, "-m", "image_server", "bench", str(folder), "--seed", str(SEED)]
        process = subprocess.Popen(
            [*command, *arguments], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        running.append(process)
        made = Bench(process, folder, "", "")
        made.lights = made.word("lights")
        made.camera = made.word("camera")
        return made

    yield start
    for process in running:
        process.terminate()
        process.communicate(timeout=DEADLINE_S)


@pytest.fixture
def opened() -> Iterator[Callable[[CameraFile], V4L2Camera]]:
    """Opens cameras; closed at the end, also of a test that fails."""
    cameras: list[V4L2Camera] = []

    def open_camera(file: CameraFile) -> V4L2Camera:
        cameras.append(V4L2Camera(file))
        return cameras[-1]

    yield open_camera
    for camera in cameras:
        camera.close()


def test_controls_are_those_of_the_camera_itself(bench: Callable[..., Bench]) -> None:
    """As `v4l2-ctl --list-ctrls` shows them on a C922."""
    node = Node(bench("--model", "c922").camera)
    known = controls(node)
    assert node.card == "C922 Pro Stream Webcam: C922 Pr"  # the kernel keeps 31 letters
    assert node.driver == "uvcvideo"
    for name, expected in {
        "exposure_absolute": (3, 2047, 1, 250),
        "focus_absolute": (0, 250, 5, 0),
        "white_balance_temperature": (2000, 6500, 1, 4000),
        "zoom_absolute": (100, 500, 1, 100),
        "gain": (0, 255, 1, 0),
    }.items():
        found = known[name]
        assert (found.minimum, found.maximum, found.step, found.default) == expected, name
    assert known["exposure_auto"].menu == {1: "Manual Mode", 3: "Aperture Priority Mode"}
    assert known["exposure_absolute"].inactive and known["focus_absolute"].inactive
    with pytest.raises(
        BadInput, match=r"focus_absolute = 7 is out of range. Allowed: 0 to 250 in steps of 5"
    ):
        write_control(node, known["focus_absolute"], 7)
    node.close()


@pytest.mark.parametrize("model", ["c922", "live", "lens"])
def test_a_camera_without_a_file_goes_manual(
    model: str, bench: Callable[..., Bench], opened: Callable[[CameraFile], V4L2Camera]
) -> None:
    table = FormatTable(pixel_format="MJPG")
    camera = opened(CameraFile(device=bench("--model", model).camera, format=table))
    assert len(camera.shutters_s) == 5
    for shutter_s in (camera.shutters_s[4], camera.shutters_s[0]):
        exposure = camera.capture(Settings(lights=(), shutter_s=shutter_s, aperture=4.0), time.monotonic())
        assert exposure.verified
        assert exposure.applied == {"shutter_s": shutter_s}
    assert not camera.health()["damaged_frames"]


def test_every_lens_control_shows_in_the_picture(
    bench: Callable[..., Bench], opened: Callable[[CameraFile], V4L2Camera]
) -> None:
    """Iris, focus, zoom and gain on a camera that has them all; read back from the driver with each frame."""
    started = bench("--model", "lens")
    camera = opened(load_camera_file(str(started.folder / "camera.toml")))
    assert camera.file.aperture.values == (2.8, 4.0, 5.6)

    def shot(aperture: float = 4.0) -> np.ndarray:
        settings = Settings(lights=(), shutter_s=camera.shutters_s[1], aperture=aperture)
        exposure = camera.capture(settings, time.monotonic())
        assert exposure.verified
        assert exposure.applied["aperture"] == aperture
        return exposure.pixels.astype(float)

    middle = shot()
    assert middle.max() < 255
    for aperture in (2.8, 5.6):
        light = shot(aperture).sum() / middle.sum()
        assert light == pytest.approx((4.0 / aperture) ** 2, rel=0.06)  # the iris has 100 steps
    sharp = np.abs(np.diff(middle, axis=1)).max()
    camera.set_control("focus_absolute", 900)
    for _ in range(3):
        camera.next_frame()
    assert np.abs(np.diff(shot(), axis=1)).max() < 0.7 * sharp
    assert not camera.health()["damaged_frames"]


def test_what_a_light_does_shows_in_the_next_frame_only(
    bench: Callable[..., Bench], opened: Callable[[CameraFile], V4L2Camera]
) -> None:
    """A USB camera sends a frame a period after it was exposed, and calls that the start of the exposure."""
    started = bench("--model", "c922", "--ambient-scale", "0")
    hardware = Hardware(
        opened(load_camera_file(str(started.folder / "camera.toml"))), open_rig(started.lights)
    )
    shutter_s = hardware.describe().shutters_s[2]
    for levels in ((7, 7, 7), (0, 0, 0)) * 3:
        frame = hardware.capture(Settings(lights=levels, shutter_s=shutter_s, aperture=4.0))
        assert frame.verified
        assert (frame.pixels.mean() > 10) == any(levels)
    hardware.close()


def test_what_goes_wrong_is_told(
    bench: Callable[..., Bench], opened: Callable[[CameraFile], V4L2Camera]
) -> None:
    started = bench("--model", "c922")
    camera = opened(load_camera_file(str(started.folder / "camera.toml")))
    hardware = Hardware(camera)
    changes: list[Change] = []
    hardware.listen(changes.append)
    first, last = camera.shutters_s[0], camera.shutters_s[-1]

    def capture(shutter_s: float) -> bool:
        return hardware.capture(Settings(lights=(), shutter_s=shutter_s, aperture=4.0)).verified

    assert capture(first)
    started.fault("camera:refuse:exposure_absolute")
    with pytest.raises(DeviceError, match=rf"{started.camera} refuses exposure_absolute = 667: it cannot be"):
        capture(last)
    started.fault("camera:none")
    assert capture(last)
    started.fault("camera:garbage")
    with pytest.raises(DeviceError, match=rf"No frame came from the camera {started.camera}"):
        capture(last)
    assert camera.health()["damaged_frames"] > 0
    started.fault("camera:none")
    assert capture(last)
    started.fault("camera:unplugged")
    with pytest.raises(DeviceError, match=rf"The camera {started.camera} is gone .*unplugged"):
        capture(first)
    assert {change.event for change in changes} == {"camera_fault"}
    assert started.camera in hardware.health()["status"]
    hardware.close()


def test_an_automatic_mode_that_comes_back_is_noticed(
    bench: Callable[..., Bench], opened: Callable[[CameraFile], V4L2Camera]
) -> None:
    started = bench("--model", "c922")
    camera = opened(load_camera_file(str(started.folder / "camera.toml")))
    settings = Settings(lights=(), shutter_s=camera.shutters_s[0], aperture=4.0)
    assert camera.capture(settings, time.monotonic()).verified
    other = Node(started.camera)
    known = controls(other)
    write_control(other, known["exposure_auto"], 3)
    assert not camera.capture(settings, time.monotonic()).verified
    with pytest.raises(
        DeviceError, match=r"exposure_absolute = 100: it cannot be set now. An automatic mode"
    ):
        write_control(other, known["exposure_absolute"], 100)
    assert read_control(other, known["exposure_absolute"]) == 42
    other.close()


def test_a_whole_session_finds_the_pose(bench: Callable[..., Bench], tmp_path: Path) -> None:
    """Camera over USB, lights over serial, both driven by the kernel; light 3 dies on the way."""
    started = bench("--model", "c922", "--ambient-scale", "0.3")
    started.fault("dead:3")
    status, result, said = session(
        tmp_path / "run", "--camera", started.folder / "camera.toml", "--lights", started.lights,
        "--target", "cube", "--seed-pose", started.folder / "seed-pose.toml",
    )  # fmt: skip
    assert "event: light_fault(light3)" in said
    assert (status, result["status"]) == (0, "converged"), said
    found = Pose(*(np.array(result["pose"][part]) for part in ("rotation_vector", "translation")))
    error = found.error_to(Simulator("cube", "nominal", SEED).true_pose)
    assert error.rotation_deg < 0.5 and error.translation_fraction_of_range < 0.005


def test_a_camera_is_calibrated_and_recorded(bench: Callable[..., Bench], tmp_path: Path) -> None:
    """The iris of the emulated lens is calibrated by its light; a basis is recorded and is linear."""
    started = bench("--model", "lens")
    made = tmp_path / "made.toml"
    done = image_server(
        "calibrate", "--camera", started.folder / "camera.toml", "--widest-aperture", "2.8", made
    )
    assert done.returncode == 0, done.stderr
    file = load_camera_file(str(made))
    stops = {step: value for value, step in file.aperture.steps}
    assert {100, 78, 55} <= set(stops)
    for step in (100, 78, 55):
        assert stops[step] == pytest.approx(280 / step, rel=0.05)
    assert 1 <= file.settle_frames <= 4
