"""A camera in memory that answers V4L2 requests as the kernel's documentation says a UVC camera does.

It has controls that the kernel's virtual camera lacks: exposure, iris, zoom, focus and white balance.
Its frames follow exposure and iris, a given number of frames late, through a given tone curve.
"""

import errno
import mmap
import os
import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from bridge.errors import DeviceError
from image_server.v4l2.controls import CAMERA, USER
from image_server.v4l2.kernel import fourcc
from image_server.v4l2.node import Node

WIDTH, HEIGHT, PERIOD_S = 64, 48, 0.001
NEXT = 0x80000000
INACTIVE = 0x10


@dataclass
class Knob:
    """One control: the driver's name, its range, its type (1 integer, 2 boolean, 3 menu) and value."""

    name: bytes
    minimum: int
    maximum: int
    default: int
    step: int = 1
    kind: int = 1
    menu: dict[int, bytes] = field(default_factory=dict)
    locked_by: tuple[int, int] | None = None  # inactive while that control has that value
    value: int = 0


def uvc_knobs() -> dict[int, Knob]:
    """Controls as uvcvideo names them (Linux 6.1)."""
    knobs = {
        USER + 12: Knob(b"White Balance, Automatic", 0, 1, 1, kind=2),
        USER + 19: Knob(b"Gain", 0, 100, 30),
        USER + 26: Knob(b"White Balance Temperature", 2800, 6500, 4600, step=10, locked_by=(USER + 12, 1)),
        CAMERA + 1: Knob(
            b"Auto Exposure", 0, 3, 3, kind=3, menu={1: b"Manual Mode", 3: b"Aperture Priority Mode"}
        ),
        CAMERA + 2: Knob(b"Exposure Time, Absolute", 3, 2047, 250, locked_by=(CAMERA + 1, 3)),
        CAMERA + 10: Knob(b"Focus, Absolute", 0, 250, 0, step=5, locked_by=(CAMERA + 12, 1)),
        CAMERA + 12: Knob(b"Focus, Automatic Continuous", 0, 1, 1, kind=2),
        CAMERA + 13: Knob(b"Zoom, Absolute", 100, 500, 100),
        CAMERA + 17: Knob(b"Iris, Absolute", 0, 100, 100),
    }
    for knob in knobs.values():
        knob.value = knob.default
    return knobs


class ScriptedCamera(Node):
    """The node of such a camera.

    Parameters
    ----------
    gamma : grey values are 255 · signal^(1/gamma).
    late : frames after which a change of exposure or iris shows.
    """

    def __init__(self, gamma: float = 1.0, late: int = 0) -> None:
        self.path = "/dev/scripted"
        self.knobs = uvc_knobs()
        self.refuse: dict[int, int] = {}
        self.sticky: set[int] = set()
        self.requests: list[str] = []
        self.gone = False
        self.refusal_when_gone = errno.ENODEV
        self._gamma = gamma
        self._late = late
        self._history: list[float] = []
        self._buffers: list[mmap.mmap] = []
        self._queue: list[int] = []
        self._sequence = 0
        self._last_s = 0.0
        self._scene = np.linspace(0.02, 0.9, WIDTH * HEIGHT).reshape(HEIGHT, WIDTH)

    card = property(lambda _self: "Scripted")  # type: ignore[assignment]
    driver = property(lambda _self: "uvcvideo")  # type: ignore[assignment]
    bus = property(lambda _self: "usb-0")  # type: ignore[assignment]

    def request(self, name: str, argument: Any) -> Any:
        """Answer one request."""
        self.requests.append(name)
        if self.gone:
            raise OSError(self.refusal_when_gone, os.strerror(self.refusal_when_gone))
        getattr(self, f"_{name.lower()}")(argument)
        return argument

    def map(self, offset: int, length: int) -> mmap.mmap:
        """A buffer."""
        self._buffers.append(mmap.mmap(-1, length))
        return self._buffers[offset]

    def wait(self, deadline: float) -> bool:
        """A frame is ready every period, if a buffer is queued."""
        if self.gone:
            return True
        next_s = self._last_s + PERIOD_S
        if not self._queue or next_s > max(deadline, time.monotonic()):
            return False
        time.sleep(max(0.0, next_s - time.monotonic()))
        return True

    def close(self) -> None:
        """Nothing to free."""

    def failure(self, doing: str, error: OSError) -> DeviceError:
        """In the words of a real node."""
        return super().failure(doing, error)

    # --- controls ---

    def _query_ext_ctrl(self, query: Any) -> None:
        if query.id & NEXT:
            number = next((n for n in sorted(self.knobs) if n > query.id & ~NEXT), None)
        else:
            number = query.id if query.id in self.knobs else None
        if number is None:
            raise OSError(errno.EINVAL, "Invalid argument")
        knob = self.knobs[number]
        query.id, query.type, query.name = number, knob.kind, knob.name
        query.minimum, query.maximum, query.step = knob.minimum, knob.maximum, knob.step
        query.default_value, query.elems = knob.default, 1
        query.flags = INACTIVE if self._locked(knob) else 0

    def _querymenu(self, query: Any) -> None:
        text = self.knobs[query.id].menu.get(query.index)
        if text is None:
            raise OSError(errno.EINVAL, "Invalid argument")
        query.name = text

    def _g_ctrl(self, control: Any) -> None:
        control.value = self.knobs[control.id].value

    def _s_ctrl(self, control: Any) -> None:
        if control.id in self.refuse:
            raise OSError(self.refuse[control.id], "refused")
        knob = self.knobs[control.id]
        if self._locked(knob):
            raise OSError(errno.EACCES, "Permission denied")
        if control.id not in self.sticky:
            knob.value = control.value

    def _locked(self, knob: Knob) -> bool:
        return knob.locked_by is not None and self.knobs[knob.locked_by[0]].value == knob.locked_by[1]

    # --- streaming ---

    def _enum_fmt(self, description: Any) -> None:
        if description.index > 0:
            raise OSError(errno.EINVAL, "Invalid argument")
        description.pixelformat = fourcc("GREY")

    def _g_fmt(self, fmt: Any) -> None:
        pix = fmt.fmt.pix
        pix.width, pix.height, pix.pixelformat, pix.bytesperline = WIDTH, HEIGHT, fourcc("GREY"), WIDTH

    _s_fmt = _g_fmt

    def _g_parm(self, parm: Any) -> None:
        interval = parm.parm.capture.timeperframe
        interval.numerator, interval.denominator = 1, round(1 / PERIOD_S)

    def _reqbufs(self, request: Any) -> None:
        if request.count == 0:
            self._buffers.clear()

    def _querybuf(self, buffer: Any) -> None:
        buffer.m.offset, buffer.length = buffer.index, WIDTH * HEIGHT

    def _qbuf(self, buffer: Any) -> None:
        self._queue.append(buffer.index)

    def _streamon(self, _kind: Any) -> None:
        self._last_s = time.monotonic()

    def _streamoff(self, _kind: Any) -> None:
        self._queue.clear()

    def _dqbuf(self, buffer: Any) -> None:
        if not self._queue:
            raise OSError(errno.EAGAIN, "try again")
        self._last_s = time.monotonic()
        buffer.index = self._queue.pop(0)
        buffer.bytesused = WIDTH * HEIGHT
        buffer.flags = 0x2000
        buffer.sequence = self._sequence
        self._sequence += 1
        buffer.timestamp.secs = int(self._last_s)
        buffer.timestamp.usecs = int(1e6 * (self._last_s % 1))
        self._buffers[buffer.index][:] = self._picture().tobytes()

    def _picture(self) -> Any:
        exposure = self.knobs[CAMERA + 2].value / 333 * self.knobs[CAMERA + 17].value / 100
        self._history.append(exposure)
        shown = self._history[max(0, len(self._history) - 1 - self._late)]
        signal = (self._scene * shown).clip(0, 1)
        return np.rint(255 * signal ** (1 / self._gamma)).astype(np.uint8)
