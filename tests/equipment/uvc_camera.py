"""A USB video camera as its driver sees it: descriptors, controls, and pictures in payloads (UVC 1.0).

A frame shows the values that the controls had, and the light that fell, when its exposure began: it is taken
before it is sent. A change of a control therefore shows one frame late or more, as on cameras of glass.
"""

import math
import struct
from collections.abc import Callable, Mapping
from typing import Protocol

import cv2
import numpy as np

from bridge.errors import BadInput
from numerics.arrays import Grey
from tests.equipment.usbip import Stall, UsbDevice
from tests.equipment.uvc_descriptors import (
    LANGUAGES,
    PAYLOAD_BYTES,
    Format,
    configuration_descriptor,
    device_descriptor,
    string_descriptor,
)
from tests.equipment.uvc_model import SELECTORS, CameraModel

SET_CUR, GET_CUR, GET_MIN, GET_MAX, GET_RES, GET_LEN, GET_INFO, GET_DEF = 0x01, *range(0x81, 0x88)
GET_DESCRIPTOR, DEVICE, CONFIGURATION, STRING = 6, 1, 2, 3
TO_DEVICE = (0x00, 0x01, 0x02)  # requests of chapter 9 that need no answer
CLASS_TO_INTERFACE, CLASS_FROM_INTERFACE = 0x21, 0xA1
PROBE, COMMIT = 1, 2
PROBE_LAYOUT = struct.Struct("<HBBIHHHHHII")
ERROR_CODE = 2  # selector of VC_REQUEST_ERROR_CODE_CONTROL
NO_ERROR, WRONG_STATE, OUT_OF_RANGE, INVALID_CONTROL, INVALID_REQUEST = 0, 2, 4, 6, 7
READABLE_WRITABLE, OFF_IN_AUTOMATIC = 0x03, 0x04
PAYLOAD_HEADER = 2
END_OF_HEADER, ERROR_BIT, END_OF_FRAME = 0x80, 0x40, 0x02
AUTOMATICS = {
    "exposure_absolute": ("exposure_auto", (1, 4)),
    "iris_absolute": ("exposure_auto", (1, 8)),
    "white_balance_temperature": ("auto_white_balance", (0,)),
    "focus_absolute": ("focus_auto", (0,)),
}
"""What can be set only while another control has one of some values."""
LATEST_PERIODS = 1.5
"""After so many frame periods a frame that was not fetched gives way to one of the present."""
VIDEO_BLACK, VIDEO_SPAN = 16, 219
SIMPLE_FAULTS = ("none", "silent", "garbage", "unplugged")
MAKER = "Lights and Camera"


class Scene(Protocol):
    """What is in front of the camera."""

    def __call__(self, controls: Mapping[str, int]) -> Grey:
        """The picture (H, W) uint8 under these control values, and the light there is now."""


class UvcCamera(UsbDevice):
    """One camera.

    Parameters
    ----------
    model : its controls and name.
    formats : what it offers; the first is the default. All have the size of the scene's pictures.
    scene : makes its pictures.
    serial : its serial number.
    late_frames : exposures that begin with the old values after a control has been set.
    light : what the light on the scene depends on, to be compared.
    """

    def __init__(
        self,
        model: CameraModel,
        formats: tuple[Format, ...],
        scene: Scene,
        serial: str,
        late_frames: int = 1,
        light: Callable[[], object] = lambda: None,
    ) -> None:
        self.values = {name: default for name, (_, _, _, default) in model.controls.items()}
        self.frames_sent = 0
        self.on_unplug: Callable[[], None] = lambda: None
        self._model = model
        self._formats = formats
        self._scene = scene
        self._strings = {1: MAKER, 2: model.card, 3: serial}
        self._names = {(SELECTORS[name].unit, SELECTORS[name].number): name for name in model.controls}
        self._probe = self._commit = self._negotiated(1, formats[0].intervals[0])
        self._late = late_frames
        self._history: list[dict[str, int]] = []
        self._fault = "none"
        self._refused: set[str] = set()
        self._error = NO_ERROR
        self._exposed: bytes | None = None
        self._began_s = 0.0
        self._light = light
        self._state: object = None
        self._payloads: list[bytes] = []
        self._frame_id = 0

    def fault(self, kind: str) -> None:
        """Have a fault from now on, or with `none` no more; raises BadInput where there is no such fault."""
        self.check_fault(kind)
        word, _, name = kind.partition(":")
        if kind == "unplugged":
            self.on_unplug()
        elif word == "refuse":
            self._refused.add(name)
        else:
            self._refused.clear()
            self._fault = kind

    def check_fault(self, kind: str) -> None:
        """Refuse a fault that it cannot have."""
        word, _, name = kind.partition(":")
        if kind not in SIMPLE_FAULTS and not (word == "refuse" and name in self.values):
            raise BadInput(
                f"The emulated camera has no fault {kind!r}.",
                f"Give {', '.join(SIMPLE_FAULTS)} or refuse:CONTROL.",
            )

    # --- endpoint 0 ---

    def control(self, setup: bytes, data: bytes) -> bytes:
        """Requests of USB's chapter 9, and of the video class."""
        kind, request, value, index, length = struct.unpack("<BBHHH", setup)
        if kind == 0x80 and request == GET_DESCRIPTOR:
            return self._descriptor(value >> 8, value & 0xFF)
        if kind in (0x80, 0x81, 0x82):
            return bytes(length)  # status, configuration, interface: as at the start
        if kind in TO_DEVICE:
            if kind == 0x02:
                self._restart()  # the host clears the endpoint when it stops, and before it starts
            return b""
        if kind not in (CLASS_TO_INTERFACE, CLASS_FROM_INTERFACE):
            raise Stall
        interface, unit, selector = index & 0xFF, index >> 8, value >> 8
        if interface == 1:
            return self._streaming(request, selector, data)
        if unit == 0 and selector == ERROR_CODE and request == GET_CUR:
            return bytes([self._error])
        return self._unit_control(request, unit, selector, data)

    def _descriptor(self, kind: int, index: int) -> bytes:
        if kind == DEVICE:
            return device_descriptor(self._model)
        if kind == CONFIGURATION:
            return configuration_descriptor(self._model, self._formats)
        if kind == STRING and index == 0:
            return LANGUAGES
        if kind == STRING and index in self._strings:
            return string_descriptor(self._strings[index])
        raise Stall

    def _unit_control(self, request: int, unit: int, selector: int, data: bytes) -> bytes:
        name = self._names.get((unit, selector))
        if name is None:
            raise self._refusal(INVALID_CONTROL)
        place = SELECTORS[name]
        minimum, maximum, step, default = self._model.controls[name]
        if request == SET_CUR:
            self._set(name, int.from_bytes(data, "little", signed=place.signed))
            return b""
        if request == GET_INFO:
            return bytes([READABLE_WRITABLE | (0 if self._free(name) else OFF_IN_AUTOMATIC)])
        if request == GET_LEN:
            return place.size.to_bytes(2, "little")
        answers = {
            GET_CUR: self.values[name],
            GET_MIN: minimum,
            GET_MAX: maximum,
            GET_RES: step,
            GET_DEF: default,
        }
        if request not in answers:
            raise self._refusal(INVALID_REQUEST)
        self._error = NO_ERROR
        return answers[request].to_bytes(place.size, "little", signed=place.signed)

    def _set(self, name: str, value: int) -> None:
        minimum, maximum, step, _ = self._model.controls[name]
        if name in self._refused or not self._free(name):
            raise self._refusal(WRONG_STATE)
        # the automatic modes are bits, of which the step tells those there are
        fits = bool(value & step) if name == "exposure_auto" else minimum <= value <= maximum
        if not fits:
            raise self._refusal(OUT_OF_RANGE)
        self.values[name] = value
        self._error = NO_ERROR

    def _free(self, name: str) -> bool:
        master, freeing = AUTOMATICS.get(name, ("", ()))
        return master not in self.values or self.values[master] in freeing

    def _refusal(self, code: int) -> Stall:
        self._error = code
        return Stall()

    # --- pictures ---

    def _streaming(self, request: int, selector: int, data: bytes) -> bytes:
        if selector not in (PROBE, COMMIT):
            raise Stall
        if request == GET_LEN:
            return PROBE_LAYOUT.size.to_bytes(2, "little")
        if request == GET_INFO:
            return bytes([READABLE_WRITABLE])
        if request != SET_CUR:
            return self._probe if selector == PROBE else self._commit
        asked = PROBE_LAYOUT.unpack(data[: PROBE_LAYOUT.size])
        self._probe = self._negotiated(asked[1], asked[3])
        if selector == COMMIT:
            self._commit = self._probe
            self._restart()
        return b""

    def _negotiated(self, format_number: int, interval: int) -> bytes:
        number = min(max(1, format_number), len(self._formats))
        one = self._formats[number - 1]
        nearest = min(one.intervals, key=lambda offered: abs(offered - interval))
        return PROBE_LAYOUT.pack(0, number, 1, nearest, 0, 0, 0, 0, 0, one.frame_bytes, PAYLOAD_BYTES)

    def _restart(self) -> None:
        self._payloads.clear()
        self._exposed = None

    def next_s(self) -> float:
        """When there may be a payload; an exposure begins as soon as the last frame is sent."""
        if self._payloads:
            return 0.0
        if self._fault == "silent":
            return math.inf
        return 0.0 if self._exposed is None else self._began_s + self._period_s

    def bulk_in(self, now: float) -> bytes | None:
        """The next payload."""
        if not self._payloads and not self._frame_ready(now):
            return None
        return self._payloads.pop(0)

    def _frame_ready(self, now: float) -> bool:
        """Whether a frame is due at this time; if so, it is cut into payloads."""
        if self._fault == "silent" or (self._exposed and now - self._began_s < self._period_s):
            return False
        ready, state = self._exposed, (dict(self.values), self._light())
        # A frame that is late is as good as a later one while nothing has changed; else it is lost.
        late = now - self._began_s > LATEST_PERIODS * self._period_s
        if ready is not None and not (late and state != self._state):
            self._exposed = None
            self._payloads = self._packed(ready)
            return True
        self._began_s, self._state = now, state
        self._exposed = self._exposure(self._formats[PROBE_LAYOUT.unpack(self._commit)[1] - 1])
        return False

    @property
    def _period_s(self) -> float:
        return float(PROBE_LAYOUT.unpack(self._commit)[3] * 1e-7)

    def _exposure(self, one: Format) -> bytes:
        """A frame whose exposure begins now, encoded; it is sent a period later."""
        self._history.append(dict(self.values))
        del self._history[: -1 - self._late]
        picture = self._scene(self._history[0])
        if one.name == "MJPG":
            return bytes(cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, 95])[1])
        if one.name == "YUYV":
            pairs = np.full((*picture.shape, 2), 128, np.uint8)
            pairs[..., 0] = np.rint(VIDEO_BLACK + picture * (VIDEO_SPAN / 255))
            return pairs.tobytes()
        if one.name == "Y16":
            return (picture.astype("<u2") * 257).tobytes()
        return picture.tobytes()

    def _packed(self, frame: bytes) -> list[bytes]:
        room = PAYLOAD_BYTES - PAYLOAD_HEADER
        self._frame_id ^= 1
        self.frames_sent += 1
        error = ERROR_BIT if self._fault == "garbage" else 0
        payloads = []
        for start in range(0, len(frame), room):
            last = END_OF_FRAME if start + room >= len(frame) else 0
            flags = END_OF_HEADER | self._frame_id | error | last
            payloads.append(bytes([PAYLOAD_HEADER, flags]) + frame[start : start + room])
        return payloads
