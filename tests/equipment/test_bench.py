"""An emulated bench: what controls and lights do to the picture, and the camera as its bus sees it."""

import struct

import numpy as np
import pytest

from bridge.errors import BadInput
from image_server.simulator.simulator import Simulator
from image_server.v4l2.formats import Layout, decoded
from tests.equipment.bench import Bench
from tests.equipment.faults import FaultPlan
from tests.equipment.usbip import Stall
from tests.equipment.uvc_camera import UvcCamera
from tests.equipment.uvc_descriptors import PAYLOAD_BYTES, Format, configuration_descriptor
from tests.equipment.uvc_model import load_camera_model, model_names

pytestmark = pytest.mark.slow

MANUAL = {
    "exposure_absolute": 100,
    "gain": 0,
    "focus_absolute": 500,
    "iris_absolute": 50,
    "zoom_absolute": 100,
}
FRAME_PERIODS = (333_333, 666_666)
GET_CUR, SET_CUR, GET_INFO = 0x81, 0x01, 0x86


@pytest.fixture(scope="module")
def simulator() -> Simulator:
    return Simulator("cube", "eclipse", 3)


def test_controls_and_lights_act_as_on_a_bench(simulator: Simulator) -> None:
    outputs = [128, 0, 0]
    bench = Bench(simulator, load_camera_model("lens"), lambda: outputs, 255)

    lit = bench(MANUAL) > 20

    def light(**changed: int) -> float:
        return float(bench(MANUAL | changed)[lit].astype(float).sum())

    half = light()
    assert light(exposure_absolute=200) == pytest.approx(2 * half, rel=0.02)
    assert light(iris_absolute=25) == pytest.approx(half / 4, rel=0.05)
    assert light(exposure_absolute=25, gain=27) == pytest.approx(half, rel=0.02)  # 1 + 7 · 27/63 = 4
    sharp = np.abs(np.diff(bench(MANUAL).astype(float), axis=1)).max()
    assert np.abs(np.diff(bench(MANUAL | {"focus_absolute": 1000}).astype(float), axis=1)).max() < 0.6 * sharp
    larger = bench(MANUAL | {"zoom_absolute": 150})
    assert np.count_nonzero(larger > 20) > 1.8 * np.count_nonzero(bench(MANUAL) > 20)
    outputs[0] = 255
    assert light() == pytest.approx(half * 255 / 128, rel=0.02)
    outputs[0] = 0
    assert light() < 0.02 * half


@pytest.fixture
def camera() -> UvcCamera:
    def scene(values: object) -> np.ndarray:
        return np.full((120, 160), 100, np.uint8)

    formats = (Format("YUYV", 160, 120, FRAME_PERIODS), Format("MJPG", 160, 120, FRAME_PERIODS))
    return UvcCamera(load_camera_model("c922"), formats, scene, "S1")


def ask(
    camera: UvcCamera, request: int, selector: int, unit: int, data: bytes = b"", length: int = 4
) -> bytes:
    kind = 0x21 if request == SET_CUR else 0xA1
    return camera.control(struct.pack("<BBHHH", kind, request, selector << 8, unit << 8, length), data)


def test_an_automatic_mode_locks_what_it_sets(camera: UvcCamera) -> None:
    assert ask(camera, GET_INFO, 0x04, 1) == b"\x07"  # exposure time: off while automatic
    with pytest.raises(Stall):
        ask(camera, SET_CUR, 0x04, 1, struct.pack("<I", 100))
    assert ask(camera, GET_CUR, 0x02, 0) == b"\x02"  # why: wrong state
    ask(camera, SET_CUR, 0x02, 1, b"\x01")
    ask(camera, SET_CUR, 0x04, 1, struct.pack("<I", 100))
    assert ask(camera, GET_CUR, 0x04, 1) == struct.pack("<I", 100)
    with pytest.raises(Stall):
        ask(camera, SET_CUR, 0x04, 1, struct.pack("<I", 3000))
    assert ask(camera, GET_CUR, 0x02, 0) == b"\x04"  # why: out of range
    with pytest.raises(Stall):
        ask(camera, SET_CUR, 0x02, 1, b"\x04")  # shutter priority, which it does not have


def test_a_frame_that_nobody_fetches_gives_way_to_the_next(camera: UvcCamera) -> None:
    ask(camera, SET_CUR, 0x02, 1, b"\x01")  # manual
    assert camera.bulk_in(10.0) is None
    ask(camera, SET_CUR, 0x04, 1, struct.pack("<I", 100))
    assert camera.bulk_in(10.5) is None  # that of 10.0 is lost; the next is exposed now
    assert camera.bulk_in(10.52) is None
    assert camera.bulk_in(10.54) is not None


def test_a_late_frame_is_sent_while_nothing_has_changed(camera: UvcCamera) -> None:
    assert camera.bulk_in(10.0) is None
    assert camera.bulk_in(10.5) is not None


def test_frames_come_in_payloads_a_period_after_they_were_exposed(camera: UvcCamera) -> None:
    assert camera.bulk_in(10.0) is None  # this one is exposed now
    assert camera.bulk_in(10.01) is None
    frame, last = b"", 0
    while not last:
        payload = camera.bulk_in(10.04)
        assert payload is not None and len(payload) <= PAYLOAD_BYTES
        frame += payload[2:]
        last = payload[1] & 0x02
    assert camera.frames_sent == 1
    pixels = decoded(np.frombuffer(frame, np.uint8), Layout("YUYV", 160, 120, 320, full_range=False))
    assert np.ptp(pixels) == 0 and abs(int(pixels[0, 0]) - 100) <= 1


@pytest.mark.parametrize("model", model_names())
def test_descriptors_add_up(model: str) -> None:
    formats = (Format("GREY", 64, 48, FRAME_PERIODS), Format("MJPG", 64, 48, FRAME_PERIODS[:1]))
    data = configuration_descriptor(load_camera_model(model), formats)
    assert struct.unpack_from("<H", data, 2)[0] == len(data)
    place, kinds = 0, []
    while place < len(data):
        assert data[place] > 1
        kinds.append(data[place + 1])
        place += data[place]
    assert place == len(data)
    assert kinds.count(0x24) == 4 + 1 + 2 * 3 and kinds[-1] == 5


def test_faults_name_their_device(camera: UvcCamera) -> None:
    plan = FaultPlan({"camera": camera}, ["0.5:camera:silent"])
    plan.now("camera:refuse:gain")
    with pytest.raises(Stall):
        ask(camera, SET_CUR, 0x04, 2, b"\1\0")
    with pytest.raises(BadInput, match="refuse:CONTROL"):
        plan.now("camera:refuse:iris_absolute")
    with pytest.raises(BadInput, match="Begin with camera:"):
        plan.now("silent")
