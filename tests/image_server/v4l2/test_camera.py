"""The V4L2 camera without a kernel driver: structures, formats, and controls that vivid does not have."""

import ctypes
import errno
import shutil
import subprocess
import time
from pathlib import Path

import cv2
import numpy as np
import pytest
import v4l2

from bridge.errors import BadInput, DeviceError
from bridge.messages import Settings
from image_server.hardware import Hardware
from image_server.v4l2 import kernel
from image_server.v4l2.calibrate import calibrate
from image_server.v4l2.camera import V4L2Camera
from image_server.v4l2.camera_file import Axis, CameraFile, load_camera_file
from image_server.v4l2.controls import CAMERA, USER, controls, write_control
from image_server.v4l2.formats import DamagedFrameError, Layout, decoded
from image_server.v4l2.stream import Freshness, Stamp
from tests.image_server.v4l2.scripted_camera import ScriptedCamera

STRUCTURES = {
    "v4l2_capability": v4l2.v4l2_capability,
    "v4l2_fmtdesc": v4l2.v4l2_fmtdesc,
    "v4l2_pix_format": kernel.PixFormat,
    "v4l2_format": kernel.Format,
    "v4l2_requestbuffers": v4l2.v4l2_requestbuffers,
    "v4l2_buffer": v4l2.v4l2_buffer,
    "v4l2_streamparm": v4l2.v4l2_streamparm,
    "v4l2_query_ext_ctrl": v4l2.v4l2_query_ext_ctrl,
    "v4l2_querymenu": v4l2.v4l2_querymenu,
    "v4l2_control": v4l2.v4l2_control,
}
FIELDS = {
    "v4l2_capability": ["card", "bus_info", "capabilities"],
    "v4l2_pix_format": ["pixelformat", "bytesperline", "colorspace", "quantization", "xfer_func"],
    "v4l2_format": ["fmt"],
    "v4l2_buffer": ["bytesused", "flags", "timestamp", "sequence", "memory", "m", "length"],
    "v4l2_streamparm": ["parm"],
    "v4l2_query_ext_ctrl": ["type", "name", "minimum", "step", "default_value", "flags", "elems"],
    "v4l2_querymenu": ["index", "name"],
}
NUMBERS = {
    "V4L2_CID_IRIS_ABSOLUTE": CAMERA + 17,
    "V4L2_CID_EXPOSURE_ABSOLUTE": CAMERA + 2,
    "V4L2_CID_FOCUS_ABSOLUTE": CAMERA + 10,
    "V4L2_CID_ZOOM_ABSOLUTE": CAMERA + 13,
    "V4L2_CID_WHITE_BALANCE_TEMPERATURE": USER + 26,
    "V4L2_CID_GAIN": USER + 19,
    "V4L2_BUF_FLAG_ERROR": kernel.BUFFER_ERROR,
    "V4L2_BUF_FLAG_TIMESTAMP_MASK": kernel.BUFFER_CLOCK_MASK,
    "V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC": kernel.BUFFER_CLOCK_MONOTONIC,
    "V4L2_BUF_FLAG_TSTAMP_SRC_SOE": kernel.BUFFER_STAMPED_AT_START,
    "V4L2_QUANTIZATION_FULL_RANGE": kernel.FULL_RANGE,
    "V4L2_COLORSPACE_JPEG": kernel.COLORSPACE_JPEG,
    **{f"VIDIOC_{name}": number for name, (number, _) in kernel.REQUESTS.items()},
}


def test_structures_and_numbers_are_the_kernels(tmp_path: Path) -> None:
    compiler = shutil.which("cc")
    assert compiler is not None
    lines = [f'printf("%zu ", sizeof(struct {name}));' for name in STRUCTURES]
    lines += [
        f'printf("%zu ", offsetof(struct {name}, {field}));'
        for name, fields in FIELDS.items()
        for field in fields
    ]
    lines += [f'printf("%lu ", (unsigned long){name} & 0xFFFFFFFFUL);' for name in NUMBERS]
    source = tmp_path / "sizes.c"
    includes = "#include <linux/videodev2.h>\n#include <stddef.h>\n#include <stdio.h>\n"
    source.write_text(includes + "int main(void) {" + "\n".join(lines) + "}")
    subprocess.run([compiler, "-o", tmp_path / "sizes", source], check=True, timeout=60)
    printed = subprocess.run([tmp_path / "sizes"], check=True, capture_output=True, text=True, timeout=10)
    kernels = list(map(int, printed.stdout.split()))
    ours = [ctypes.sizeof(structure) for structure in STRUCTURES.values()]
    ours += [getattr(STRUCTURES[name], field).offset for name, fields in FIELDS.items() for field in fields]
    ours += list(NUMBERS.values())
    names = [*STRUCTURES, *(f"{n}.{f}" for n, fields in FIELDS.items() for f in fields), *NUMBERS]
    assert dict(zip(names, ours, strict=True)) == dict(zip(names, kernels, strict=True))


# --- pixel formats ---

PICTURE = np.add.outer(np.arange(6) * 10, np.arange(8) * 20).astype(np.uint8)


def test_padded_grey_lines() -> None:
    padded = np.hstack([PICTURE, np.full((6, 4), 99, np.uint8)])
    assert np.array_equal(decoded(padded.ravel(), Layout("GREY", 8, 6, 12)), PICTURE)
    cut = padded.ravel()[:-4]  # the last line may lack its padding
    assert np.array_equal(decoded(cut, Layout("GREY", 8, 6, 12)), PICTURE)


def test_sixteen_bits_are_scaled() -> None:
    wide = (PICTURE.astype("<u2") * 257).view(np.uint8)
    assert np.array_equal(decoded(wide.ravel(), Layout("Y16", 8, 6, 16)), PICTURE)


def test_luma_of_yuyv_in_both_ranges() -> None:
    buffer = np.full((6, 16), 128, np.uint8)
    buffer[:, ::2] = PICTURE
    assert np.array_equal(decoded(buffer.ravel(), Layout("YUYV", 8, 6, 16)), PICTURE)
    buffer[:, ::2] = np.rint(16 + PICTURE * (219 / 255))
    limited = decoded(buffer.ravel(), Layout("YUYV", 8, 6, 16, full_range=False))
    assert np.abs(limited.astype(int) - PICTURE).max() <= 1
    buffer[:, ::2] = 255
    assert decoded(buffer.ravel(), Layout("YUYV", 8, 6, 16, full_range=False)).max() == 255


def test_motion_jpeg() -> None:
    _, jpeg = cv2.imencode(".jpg", PICTURE, [cv2.IMWRITE_JPEG_QUALITY, 100])
    shown = decoded(jpeg.ravel(), Layout("MJPG", 8, 6, 0))
    assert np.abs(shown.astype(int) - PICTURE).max() <= 3
    with pytest.raises(DamagedFrameError):
        decoded(jpeg.ravel()[:20], Layout("MJPG", 8, 6, 0))
    with pytest.raises(DamagedFrameError):
        decoded(jpeg.ravel(), Layout("MJPG", 16, 6, 0))


@pytest.mark.parametrize("name", ["GREY", "Y16", "YUYV"])
def test_a_short_buffer_is_damaged(name: str) -> None:
    with pytest.raises(DamagedFrameError):
        decoded(np.zeros(20, np.uint8), Layout(name, 8, 6, 0))


def test_freshness_counts_from_the_start_of_the_exposure() -> None:
    def stamp(time_s: float, at_start: bool = False) -> Stamp:
        return Stamp(0, time_s, at_start, True)

    wanted = Freshness(asked=10.0, changed=0.0, exposure_s=0.1, delay_s=0.03, skip=1)
    assert not wanted.accepts(stamp(10.05))  # began at 9.95
    assert not wanted.accepts(stamp(10.15))  # the one to skip
    assert wanted.accepts(stamp(10.16))
    assert wanted.dropped == 2
    assert Freshness(10.0, 10.0, 0.1, 0.03).accepts(stamp(10.05, at_start=True))
    lit = Freshness(asked=0.0, changed=10.0, exposure_s=0.1, delay_s=0.03)
    assert not lit.accepts(stamp(10.12))  # its first line may have begun at 9.99, under the old light
    assert lit.accepts(stamp(10.14))


# --- controls that the virtual camera lacks, on a scripted one ---


def at(camera: V4L2Camera, shutter_s: float, aperture: float = 4.0, **lens: float) -> Settings:
    return Settings(lights=(), shutter_s=shutter_s, aperture=aperture, **lens)  # type: ignore[arg-type]


def test_a_camera_without_a_file_goes_manual() -> None:
    node = ScriptedCamera()
    camera = V4L2Camera(CameraFile(device=node.path), node)
    values = {number: knob.value for number, knob in node.knobs.items()}
    assert values[CAMERA + 1] == 1 and values[CAMERA + 12] == 0 and values[USER + 12] == 0
    assert values[USER + 19] == 0  # gain: least noise
    assert camera.shutters_s == (0.0042, 0.0083, 0.0167, 0.0333, 0.0667)
    exposure = camera.capture(at(camera, 0.0167), time.monotonic())
    assert exposure.verified and exposure.applied == {"shutter_s": 0.0167}
    assert node.knobs[CAMERA + 2].value == 167
    ranges = {known.name: known for known in camera.ranges()}
    assert ranges["control.exposure_absolute"].unit == "100 µs"
    assert (ranges["control.focus_absolute"].maximum, ranges["control.focus_absolute"].step) == (250, 5)
    camera.close()


def test_iris_zoom_focus_and_white_balance_reach_their_controls() -> None:
    node = ScriptedCamera()
    file = CameraFile(
        device=node.path,
        controls={
            "exposure_auto": 1,
            "focus_auto": 0,
            "auto_white_balance": 0,
            "white_balance_temperature": 5000,
        },
        shutter=Axis(control="exposure_absolute", steps=((0.01, 100), (0.02, 200))),
        aperture=Axis(control="iris_absolute", steps=((2.8, 100), (4.0, 49))),
        focal_length=Axis(control="zoom_absolute", steps=((8.0, 100), (16.0, 200))),
        focus=Axis(control="focus_absolute", steps=((0.5, 200), (2.0, 50))),
    )
    hardware = Hardware(V4L2Camera(file, node))
    described = hardware.describe()
    assert described.focal_lengths_mm == (8.0, 16.0) and described.focuses_m == (0.5, 2.0)
    frame = hardware.capture(
        Settings(lights=(), shutter_s=0.02, aperture=4.0, focal_length_mm=16.0, focus_m=0.5)
    )
    values = [node.knobs[CAMERA + n].value for n in (2, 17, 13, 10)]
    assert values == [200, 49, 200, 200]
    assert node.knobs[USER + 26].value == 5000
    assert frame.verified and frame.applied == frame.requested
    with pytest.raises(BadInput, match=r"aperture = 5.6 is not offered. Allowed: 2.8, 4"):
        hardware.capture(Settings(lights=(), shutter_s=0.02, aperture=5.6))
    hardware.close()


def test_the_next_frame_shows_what_was_set_although_the_camera_is_late() -> None:
    node = ScriptedCamera(late=2)
    camera = V4L2Camera(CameraFile(device=node.path, settle_frames=2), node)
    bright, dark = (
        camera.capture(at(camera, shutter_s), time.monotonic()).pixels.mean()
        for shutter_s in (0.0333, 0.0042)
    )
    assert bright / dark == pytest.approx(0.0333 / 0.0042, rel=0.1)
    camera.close()


def test_a_control_that_refuses_names_itself() -> None:
    node = ScriptedCamera()
    known = controls(node)
    with pytest.raises(
        DeviceError, match=r"/dev/scripted refuses focus_absolute = 50: it cannot be set now. An auto"
    ):
        write_control(node, known["focus_absolute"], 50)
    with pytest.raises(
        BadInput, match=r"focus_absolute = 52 is out of range. Allowed: 0 to 250 in steps of 5"
    ):
        write_control(node, known["focus_absolute"], 52)
    with pytest.raises(BadInput, match=r"exposure_auto = 2 .* Allowed: 1 \(Manual Mode\), 3 \(Aperture"):
        write_control(node, known["exposure_auto"], 2)
    node.refuse[CAMERA + 13] = 5  # EIO, as a camera whose firmware hangs
    with pytest.raises(DeviceError, match="/dev/scripted failed in setting zoom_absolute = 200"):
        write_control(node, known["zoom_absolute"], 200)


def test_a_control_that_does_not_move_leaves_the_frame_unverified() -> None:
    node = ScriptedCamera()
    camera = V4L2Camera(CameraFile(device=node.path), node)
    assert camera.capture(at(camera, 0.0167), time.monotonic()).verified
    node.sticky.add(CAMERA + 2)
    exposure = camera.capture(at(camera, 0.0333), time.monotonic())
    assert not exposure.verified
    assert exposure.applied == {"shutter_s": 0.0167}
    node.sticky.clear()
    assert camera.capture(at(camera, 0.0333), time.monotonic()).verified  # it is tried again
    camera.close()


@pytest.mark.parametrize("refusal", [errno.ENODEV, errno.ESHUTDOWN])
def test_a_camera_that_is_pulled_out_says_so(refusal: int) -> None:
    """Also in the midst of a request, which the USB end refuses then."""
    node = ScriptedCamera()
    node.refusal_when_gone = refusal
    hardware = Hardware(V4L2Camera(CameraFile(device=node.path), node))
    told: list[str] = []
    hardware.listen(lambda change: told.append(change.event))
    node.gone = True
    with pytest.raises(DeviceError, match="/dev/scripted is gone"):
        hardware.capture(Settings(lights=(), shutter_s=0.0167, aperture=4.0))
    assert told == ["camera_fault"]
    assert "gone" in hardware.health()["status"]
    hardware.close()


@pytest.mark.parametrize(("gamma", "late"), [(1.0, 0), (2.2, 3)])
def test_calibration_measures_tone_curve_delay_and_iris(gamma: float, late: int) -> None:
    node = ScriptedCamera(gamma, late)
    found = calibrate(
        V4L2Camera(CameraFile(device=node.path), node),
        widest_aperture=2.8,
        focal_lengths={8.0: 100, 16.0: 200},
        focuses={0.5: 200},
    )
    measured = next(float(note.split()[1]) for note in found.notes if note.startswith("gamma"))
    assert measured == pytest.approx(gamma, rel=0.05)
    assert late <= found.file.settle_frames <= late + 1
    f_numbers = dict((value, f_number) for f_number, value in found.file.aperture.steps)
    assert f_numbers[100] == 2.8
    assert f_numbers[25] == pytest.approx(5.6, rel=0.05)  # a quarter of the light
    assert found.file.focal_length is not None and found.file.focal_length.steps == ((8.0, 100), (16.0, 200))
    assert found.file.card == "Scripted"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("card = 3", "card"),
        ('[shutter]\ncontrol = "exposure_absolute"', "control and steps go together"),
        ("[shutter]\nfixed = 0.1\nsteps = [[0.1, 3]]", "control and steps go together"),
        ("[aperture]", "needs either control and steps, or fixed"),
        ("[shutter]\ncontrol = 'x'\nsteps = [[-0.1, 3]]", "steps"),
        ("[camera]\nwidth = 3", "missing key"),
        ("[aperture]\nfixed = 1e-5", r">= 0.01 in \[aperture.fixed\]"),
        ("[shutter]\ncontrol = 'x'\nsteps = [[0.1, 3], [1e300, 4]]", r"<= 100000.0 in \[shutter.steps 2 1\]"),
        ("[focus]\nfixed = 1e300", r"<= 1000000.0 in \[focus.fixed\]"),
        ("[focal_length]\nfixed = 1e300", r"<= 1000000.0 in \[focal_length.fixed\]"),
    ],
)
def test_a_bad_camera_file_names_the_key(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "camera.toml"
    file.write_text(f'device = "/dev/video0"\n{text}\n')
    with pytest.raises(BadInput, match=message):
        load_camera_file(str(file))
