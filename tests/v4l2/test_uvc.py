"""The kernel's driver of USB cameras, uvcvideo, on emulated cameras with the controls of real ones.

The camera is plugged into the virtual USB controller (vhci-hcd) and answers as a device does; what comes back
from the kernel is traffic of the real driver: exposure, white balance, focus, zoom, iris and MJPEG.
"""

import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bridge.errors import BadInput, DeviceError
from bridge.messages import Settings
from geometry.pose import Pose
from image_server.hardware import Hardware
from image_server.lights.opening import open_rig
from image_server.serve.device import Change
from image_server.simulator.simulator import Simulator
from image_server.v4l2.camera import V4L2Camera
from image_server.v4l2.camera_file import Axis, CameraFile, FormatTable, load_camera_file
from image_server.v4l2.controls import controls, read_control, write_control
from image_server.v4l2.node import Node
from tests.equipment.usbip import CONTROLLER, Connection, video_node
from tests.equipment.uvc_camera import UvcCamera
from tests.equipment.uvc_descriptors import Format
from tests.equipment.uvc_model import load_camera_model
from tests.v4l2.conftest import image_server, session

DEADLINE_S = 120.0  # the guest is emulated
SEED = 3
WIDTH, HEIGHT = 160, 120
SERIAL = "TEST01"
WIDE_OPEN = 2.8
PERIODS = (333_333, 666_666)

pytestmark = pytest.mark.skipif(
    not CONTROLLER.exists(), reason="no virtual USB controller (vhci-hcd) on this machine: run make test-v4l2"
)


def scene(values: Mapping[str, int]) -> Any:
    """Bars, brighter with exposure and iris, blurred with focus, larger with zoom."""
    iris, zoom = ((values.get(name) or 100) / 100 for name in ("iris_absolute", "zoom_absolute"))
    light, bar = values["exposure_absolute"] / 400 * iris**2, 8 * zoom
    softness = 0.2 + abs(values["focus_absolute"] - 500) / 250
    wave = np.sin(2 * np.pi * np.arange(WIDTH) / (2 * bar)) / softness
    bars = 0.5 + 0.4 * np.tanh(wave)
    return np.rint(255 * np.clip(np.tile(bars, (HEIGHT, 1)) * light, 0, 1)).astype(np.uint8)


Plug = Callable[[str], tuple[str, UvcCamera]]
Opened = Callable[[CameraFile], V4L2Camera]


@pytest.fixture
def plug() -> Iterator[Plug]:
    """Plugs in a camera of a model; unplugged at the end. Its device node, and itself."""
    connections: list[Connection] = []

    def plug_in(model: str) -> tuple[str, UvcCamera]:
        formats = tuple(Format(name, WIDTH, HEIGHT, PERIODS) for name in ("YUYV", "GREY", "MJPG"))
        camera = UvcCamera(load_camera_model(model), formats, scene, SERIAL)
        connections.append(Connection(camera))
        camera.on_unplug = connections[-1].unplug
        return video_node(connections[-1], SERIAL), camera

    yield plug_in
    for connection in connections:
        connection.unplug()


@pytest.fixture
def opened() -> Iterator[Opened]:
    """Opens cameras; closed at the end, also of a test that fails."""
    cameras: list[V4L2Camera] = []

    def open_camera(file: CameraFile) -> V4L2Camera:
        cameras.append(V4L2Camera(file))
        return cameras[-1]

    yield open_camera
    for camera in cameras:
        camera.close()


def at(shutter_s: float, aperture: float = 4.0, **lens: float) -> Settings:
    return Settings(lights=(), shutter_s=shutter_s, aperture=aperture, **lens)


def test_controls_are_those_of_the_camera_itself(plug: Plug) -> None:
    """As `v4l2-ctl --list-ctrls` shows them on a C922."""
    node = Node(plug("c922")[0])
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
@pytest.mark.parametrize("pixel_format", ["YUYV", "MJPG"])
def test_a_camera_without_a_file_goes_manual(
    model: str, pixel_format: str, plug: Plug, opened: Opened
) -> None:
    """`live` names an iris whose range is 0 to 0."""
    device, _ = plug(model)
    camera = opened(CameraFile(device=device, format=FormatTable(pixel_format=pixel_format)))
    assert len(camera.shutters_s) == 5
    exposures = {s: camera.capture(at(s), time.monotonic()) for s in camera.shutters_s[3::-3]}
    for shutter_s, exposure in exposures.items():
        assert exposure.verified
        assert exposure.applied == {"shutter_s": shutter_s}
    long, short = (exposure.pixels.astype(float).sum() for exposure in exposures.values())
    assert long / short == pytest.approx(camera.shutters_s[3] / camera.shutters_s[0], rel=0.03)
    assert not camera.health()["damaged_frames"]


def test_every_lens_control_is_set_shows_and_is_read_back(plug: Plug, opened: Opened) -> None:
    device, _ = plug("lens")
    camera = opened(
        CameraFile(
            device=device,
            format=FormatTable(pixel_format="GREY"),
            controls={"exposure_auto": 1, "focus_auto": 0, "auto_white_balance": 0},
            shutter=Axis("exposure_absolute", ((0.01, 100), (0.02, 200))),
            aperture=Axis("iris_absolute", ((WIDE_OPEN, 100), (2 * WIDE_OPEN, 50))),
            focal_length=Axis("zoom_absolute", ((8.0, 100), (16.0, 200))),
            focus=Axis("focus_absolute", ((0.6, 500), (2.0, 900))),
        )
    )

    def shot(**changed: float) -> Any:
        asked = {"shutter_s": 0.02, "aperture": WIDE_OPEN, "focal_length_mm": 8.0, "focus_m": 0.6} | changed
        exposure = camera.capture(at(**asked), time.monotonic())
        assert exposure.verified
        assert exposure.applied == pytest.approx(asked)
        return exposure.pixels.astype(float)

    first = shot()
    assert shot(aperture=2 * WIDE_OPEN).mean() == pytest.approx(first.mean() / 4, rel=0.05)
    assert shot(shutter_s=0.01).mean() == pytest.approx(first.mean() / 2, rel=0.05)
    assert _edges(shot(focal_length_mm=16.0)) == pytest.approx(_edges(first) / 2, abs=1)
    assert np.ptp(shot(focus_m=2.0)) < 0.8 * np.ptp(first)


def _edges(picture: Any) -> int:
    row = picture[HEIGHT // 2] > picture[HEIGHT // 2].mean()
    return int(np.count_nonzero(np.diff(row)))


def test_what_goes_wrong_is_told(plug: Plug, opened: Opened) -> None:
    device, emulated = plug("c922")
    camera = opened(CameraFile(device=device))
    hardware = Hardware(camera)
    changes: list[Change] = []
    hardware.listen(changes.append)
    first, last = camera.shutters_s[0], camera.shutters_s[-1]

    def verified(shutter_s: float) -> bool:
        return hardware.capture(at(shutter_s)).verified

    assert verified(first)
    emulated.fault("refuse:exposure_absolute")
    with pytest.raises(DeviceError, match=rf"{device} refuses exposure_absolute = 667: not in the state"):
        verified(last)
    emulated.fault("none")
    assert verified(last)
    emulated.fault("garbage")
    with pytest.raises(DeviceError, match=rf"No frame came from the camera {device}"):
        verified(last)  # uvcvideo keeps damaged frames to itself
    emulated.fault("none")
    assert verified(last)
    emulated.fault("unplugged")
    with pytest.raises(DeviceError, match=rf"The camera {device} is gone .*unplugged"):
        verified(first)
    assert {change.event for change in changes} == {"camera_fault"}
    assert device in hardware.health()["status"]
    hardware.close()


def test_an_automatic_mode_that_comes_back_is_noticed(plug: Plug, opened: Opened) -> None:
    device, _ = plug("c922")
    camera = opened(CameraFile(device=device))
    assert camera.capture(at(camera.shutters_s[0]), time.monotonic()).verified
    other = Node(device)
    known = controls(other)
    write_control(other, known["exposure_auto"], 3)
    assert not camera.capture(at(camera.shutters_s[0]), time.monotonic()).verified
    with pytest.raises(
        DeviceError, match=r"exposure_absolute = 100: it cannot be set now. An automatic mode"
    ):
        write_control(other, known["exposure_absolute"], 100)
    assert read_control(other, known["exposure_absolute"]) == 42
    other.close()


def test_an_iris_is_calibrated_by_its_light(plug: Plug, tmp_path: Path) -> None:
    device, _ = plug("lens")
    made = tmp_path / "made.toml"
    done = image_server("calibrate", "--camera", device, "--widest-aperture", str(WIDE_OPEN), made)
    assert done.returncode == 0, done.stderr
    file = load_camera_file(str(made))
    stops = {step: value for value, step in file.aperture.steps}
    for step in (100, 78, 55):
        assert stops[step] == pytest.approx(100 * WIDE_OPEN / step, rel=0.05)
    assert 1 <= file.settle_frames <= 4


# --- a whole bench: camera over USB, lights over serial, a simulated target between them ---


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Path, str, "subprocess.Popen[str]"]]:
    """Folder of a running `bench`, its lights, and its process; no sun."""
    folder = tmp_path_factory.mktemp("bench")
    process = subprocess.Popen(
        [
            sys.executable,
            "-m",
            "tests.equipment",
            "bench",
            folder,
            "--seed",
            str(SEED),
            "--ambient-scale",
            "0",
        ],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    lights = process.stdout.readline().split()
    assert lights[:1] == ["lights"]
    assert process.stdout.readline().startswith("camera /dev/video")
    yield folder, lights[1], process
    process.terminate()
    process.communicate(timeout=DEADLINE_S)


def test_what_a_light_does_shows_in_the_next_frame_and_not_before(
    bench: tuple[Path, str, "subprocess.Popen[str]"], opened: Opened
) -> None:
    """A USB camera sends a frame a period after it was exposed, and calls that the start of the exposure."""
    folder, lights, _ = bench
    with closing(
        Hardware(opened(load_camera_file(str(folder / "camera.toml"))), open_rig(lights))
    ) as hardware:
        shutter_s = hardware.describe().shutters_s[2]
        for levels in ((7, 7, 7), (0, 0, 0)) * 3:
            frame = hardware.capture(Settings(lights=levels, shutter_s=shutter_s, aperture=4.0))
            assert frame.verified
            assert (frame.pixels.mean() > 5) == any(levels)


def test_a_whole_session_finds_the_pose_though_a_light_dies(
    bench: tuple[Path, str, "subprocess.Popen[str]"], tmp_path: Path
) -> None:
    folder, lights, process = bench
    assert process.stdin is not None
    process.stdin.write("dead:3\n")
    process.stdin.flush()
    status, result, said = session(
        tmp_path / "run", "--camera", folder / "camera.toml", "--lights", lights,
        "--target", "cube", "--seed-pose", folder / "seed-pose.toml",
    )  # fmt: skip
    assert "event: light_fault(light3)" in said
    assert (status, result["status"]) == (0, "converged"), said
    found = Pose.from_dict(result["pose"])
    error = found.error_to(Simulator("cube", "nominal", SEED).true_pose)
    assert error.rotation_deg < 0.5 and error.translation_fraction_of_range < 0.005
