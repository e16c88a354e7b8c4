"""A V4L2 camera as settings in, frame out: set, settle, drop what is stale, read back."""

import time
from dataclasses import dataclass
from typing import Any

from bridge.errors import DeviceError
from bridge.messages import SettingRange, Settings
from image_server.v4l2.camera_file import CameraFile
from image_server.v4l2.controls import SETTABLE, Control, controls, read_control, write_control
from image_server.v4l2.file_check import check_card, check_controls, completed, named_control
from image_server.v4l2.node import Node
from image_server.v4l2.stream import START_DEADLINE_S, Freshness, Stamp, Stream
from numerics.arrays import Grey

ATTEMPTS = 2
"""Times that a frame is asked for: a stream that has stalled is started again once."""
ASSUMED_PERIOD_S = 1 / 15
"""Frame period of a camera that does not tell its own."""


@dataclass(frozen=True)
class Exposure:
    """One frame of the camera.

    Attributes
    ----------
    pixels : (H, W) uint8.
    applied : the settings as read back after the frame had come, by name.
    verified : whether all of them, and the fixed controls, are those that were set.
    timestamp : middle of the exposure, seconds since 1970 (UTC).
    """

    pixels: Grey
    applied: dict[str, float]
    verified: bool
    timestamp: float


class V4L2Camera:
    """One camera, streaming from the start.

    Parameters
    ----------
    file : its camera file; what that leaves out is proposed from the camera's list of controls.
    node : its device node, where that is open already.

    Raises
    ------
    BadInput : no such camera, another camera than the file's, or a control or value it does not have.
    DeviceError : busy, gone, or a control that refuses.
    """

    def __init__(self, file: CameraFile, node: Node | None = None) -> None:
        self._node = node or Node(file.device)
        self._stream: Stream | None = None
        self._retries = self._lost = self._damaged = self._dropped = 0
        self._set: dict[str, int] = {}
        try:
            check_card(file, self._node)
            self.controls = controls(self._node)
            self.file = completed(file, self.controls)
            check_controls(self.file, self.controls, self._node)
            self._axes = self.file.axes()
            self._stream = Stream(self._node, self.file.format)
            for name, value in self.file.controls.items():
                self._write(name, value)
            self._changed = time.monotonic()
        except BaseException:
            self.close()
            raise

    @property
    def identity(self) -> str:
        """Card, driver and place of the camera."""
        node = self._node
        return f"{node.card} ({node.driver}, {node.bus}) at {node.path}"

    @property
    def card(self) -> str:
        """The camera's own name."""
        return self._node.card

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of its frames, px."""
        layout = self._streaming().layout
        return layout.width, layout.height

    @property
    def frame_rate(self) -> float | None:
        """Frames per second that the driver promises; None where it does not."""
        period = self._streaming().period_s
        return None if period is None else 1 / period

    @property
    def shutters_s(self) -> tuple[float, ...]:
        """Shutters that can be asked for; a camera whose shutter cannot be set has one, a frame period."""
        if self.file.shutter is not None:
            return self.file.shutter.values
        return (self._streaming().period_s or ASSUMED_PERIOD_S,)

    def capture(self, settings: Settings, steady_at: float) -> Exposure:
        """A frame of now under these settings, exposed wholly after `steady_at` (time.monotonic()).

        Raises
        ------
        BadInput : a setting that the camera file has no step for.
        DeviceError : a control refuses, no frame comes, or the camera is gone.
        """
        changed = self._apply(settings)
        for attempt in range(1, ATTEMPTS + 1):
            try:
                return self._fresh(settings, steady_at, changed)
            except DeviceError:
                if attempt == ATTEMPTS:
                    raise
                self._retries += 1
                self._restart()
        raise AssertionError("unreachable: the last attempt returns or raises")

    def set_control(self, name: str, value: int) -> None:
        """Set one control, whatever the camera file says.

        Raises
        ------
        BadInput : no such control, or a value out of its range.
        DeviceError : the control refuses, or does not keep the value.
        """
        if write_control(self._node, self._control(name), value) != value:
            raise DeviceError(
                f"The camera {self._node.path} does not keep {name} = {value}.", "Is an automatic mode on?"
            )
        self._set.pop(name, None)

    def next_frame(self) -> tuple[Grey, Stamp]:
        """The next frame in the driver's queue, however old."""
        stream = self._streaming()
        period = stream.period_s or ASSUMED_PERIOD_S
        return stream.frame(time.monotonic() + START_DEADLINE_S + 4 * period)

    def ranges(self) -> tuple[SettingRange, ...]:
        """Every control of the camera with unit, range and step, as `control.NAME`."""
        return tuple(
            SettingRange(
                name=f"control.{control.name}",
                unit=control.unit,
                minimum=control.minimum,
                maximum=control.maximum,
                step=control.step,
            )
            for control in self.controls.values()
            if control.kind in SETTABLE
        )

    def health(self) -> dict[str, Any]:
        """Counts since the start, and the frame rate that the driver promises."""
        stream = self._stream
        return {
            "device": self.identity,
            "format": None if stream is None else stream.layout.name,
            "frame_rate": None if stream is None else self.frame_rate,
            "lost_frames": self._lost + (stream.lost if stream else 0),
            "damaged_frames": self._damaged + (stream.damaged if stream else 0),
            "stale_frames": self._dropped,
            "retries": self._retries,
        }

    def close(self) -> None:
        """Stop and give the camera back; may be called twice."""
        self._stop()
        self._node.close()

    # --- settings ---

    def _apply(self, settings: Settings) -> bool:
        """Set what differs from what is set; whether anything did."""
        wanted = {}
        for name, axis in self._axes.items():
            value = getattr(settings, name)
            if value is not None:
                assert axis.control is not None
                wanted[axis.control] = axis.number(name, value)
        changed = False
        for control, value in wanted.items():
            if self._set.get(control) != value:
                self._write(control, value)
                changed = True
        if changed:
            self._changed = time.monotonic()
        return changed

    def _write(self, name: str, value: int) -> None:
        self._set.pop(name, None)
        held = write_control(self._node, self.controls[name], value)
        if held == value:
            self._set[name] = value  # else it is tried again, and no frame counts as verified

    def _read_back(self, settings: Settings) -> tuple[dict[str, float], bool]:
        """Settings that the controls stand for now, and whether every control has its value."""
        applied = {}
        verified = all(self._holds(name, value) for name, value in self.file.controls.items())
        for name, axis in self._axes.items():
            asked = getattr(settings, name)
            assert axis.control is not None
            value = read_control(self._node, self.controls[axis.control])
            applied[name] = axis.meaning(value)
            verified &= asked is None or value == axis.number(name, asked)
        return applied, verified

    def _holds(self, name: str, value: int) -> bool:
        return read_control(self._node, self.controls[name]) == value

    # --- frames ---

    def _fresh(self, settings: Settings, steady_at: float, changed: bool) -> Exposure:
        stream = self._streaming()
        stream.drain()
        period = stream.period_s or ASSUMED_PERIOD_S
        skip = self.file.settle_frames if changed else 0
        now, shutter_s = time.monotonic(), settings.shutter_s
        fresh = Freshness(now, max(steady_at, self._changed), shutter_s, period, skip)
        deadline = max(now, steady_at) + START_DEADLINE_S + (skip + 5) * max(period, shutter_s) + shutter_s
        pixels, stamp = stream.frame(deadline, fresh)
        self._dropped += fresh.dropped
        applied, verified = self._read_back(settings)
        half = settings.shutter_s / 2
        middle = stamp.time + half if stamp.at_start else stamp.time - half
        return Exposure(
            pixels=pixels,
            applied=applied,
            verified=verified and stamp.from_driver,
            timestamp=time.time() - (time.monotonic() - middle),
        )

    def _streaming(self) -> Stream:
        if self._stream is None:
            self._stream = Stream(self._node, self.file.format)
        return self._stream

    def _stop(self) -> None:
        if self._stream is not None:
            self._lost += self._stream.lost
            self._damaged += self._stream.damaged
            self._stream.close()
            self._stream = None

    def _restart(self) -> None:
        self._stop()
        self._streaming()

    def _control(self, name: str) -> Control:
        return named_control(self.controls, name, self._node)
