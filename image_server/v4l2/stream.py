"""Streaming: buffers of the driver mapped into memory, dequeued one by one."""

import ctypes
import errno
import mmap
import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from bridge.errors import BadInput, DeviceError
from image_server.v4l2.camera_file import FormatTable
from image_server.v4l2.formats import DECODERS, DamagedFrameError, Layout, decoded
from image_server.v4l2.kernel import (
    BUFFER_CAPTURE,
    BUFFER_CLOCK_MASK,
    BUFFER_CLOCK_MONOTONIC,
    BUFFER_ERROR,
    BUFFER_STAMPED_AT_START,
    MEMORY_MMAP,
    REQUESTS,
    Format,
    fourcc,
    fourcc_name,
)
from image_server.v4l2.node import Node
from numerics.arrays import Grey

BUFFERS = 4  # the usual number: one is filled, one read, two wait
STAMPED_AT_FIRST_PACKET = ("uvcvideo",)
"""Drivers that call it the start of the exposure when data first come, after exposure."""
START_DEADLINE_S = 3.0
"""Longest wait for a first frame; a USB camera needs up to two seconds to wake up."""


@dataclass(frozen=True)
class Stamp:
    """What is known of a frame beside its pixels.

    Attributes
    ----------
    sequence : the driver's number of the frame; a gap is a lost frame.
    time : seconds on the monotonic clock.
    at_start : whether `time` is when the exposure began, not when the frame was complete.
    from_driver : whether the driver took the time; else it is when the frame was dequeued.
    """

    sequence: int
    time: float
    at_start: bool
    from_driver: bool


class Stream:
    """Frames of a camera, from STREAMON to STREAMOFF.

    Raises
    ------
    BadInput : the camera has no such format, or none that can be read.
    DeviceError : the camera is busy, or failed.
    """

    def __init__(self, node: Node, wanted: FormatTable) -> None:
        self._node = node
        self.lost = 0
        self.damaged = 0
        self._last_sequence: int | None = None
        self._buffers: list[mmap.mmap] = []
        self._views: list[Grey] = []
        self.layout = _set_format(node, wanted)
        self.period_s = _set_frame_rate(node, wanted.frame_rate)
        try:
            self._start()
        except OSError as error:
            self.close()
            raise node.failure("starting to stream", error) from error

    def _start(self) -> None:
        request = REQUESTS["REQBUFS"][1](count=BUFFERS, type=BUFFER_CAPTURE, memory=MEMORY_MMAP)
        count = self._node.request("REQBUFS", request).count
        for index in range(count):
            buffer = self._node.request("QUERYBUF", self._buffer(index))
            mapped = self._node.map(buffer.m.offset, buffer.length)
            self._buffers.append(mapped)
            self._views.append(np.frombuffer(mapped, np.uint8))
            self._node.request("QBUF", buffer)
        self._node.request("STREAMON", ctypes.c_int(BUFFER_CAPTURE))

    def frame(self, deadline: float, wanted: "Freshness | None" = None) -> tuple[Grey, Stamp]:
        """The next sound frame that is fresh enough, as (H, W) uint8, and its stamp.

        Only that frame is decoded: stale ones go straight back to the driver.

        Raises
        ------
        DeviceError : none by the deadline (time.monotonic()), or the camera is gone.
        """
        while True:
            buffer = self._dequeue(deadline)
            stamp = _stamp(buffer, self._node.driver)
            try:
                if buffer.flags & BUFFER_ERROR:
                    self.damaged += 1
                elif wanted is None or wanted.accepts(stamp):
                    return decoded(self._views[buffer.index][: buffer.bytesused], self.layout), stamp
            except DamagedFrameError:
                self.damaged += 1
            finally:
                self._queue(buffer)

    def drain(self) -> None:
        """Give back every frame that waits: they are stale, and frames missed meanwhile are not lost ones."""
        for _ in self._buffers:  # no more can wait, however fast the camera is
            if not self._node.wait(0.0):
                break
            self._queue(self._dequeue(time.monotonic()))
        self._last_sequence = None

    def close(self) -> None:
        """Stop streaming and free the buffers."""
        for name, argument in (
            ("STREAMOFF", ctypes.c_int(BUFFER_CAPTURE)),
            ("REQBUFS", REQUESTS["REQBUFS"][1](count=0, type=BUFFER_CAPTURE, memory=MEMORY_MMAP)),
        ):
            if name == "REQBUFS":
                self._views.clear()
                for mapped in self._buffers:
                    mapped.close()
                self._buffers.clear()
            try:
                self._node.request(name, argument)
            except OSError:
                continue  # a camera that is gone has stopped by itself

    def _buffer(self, index: int = 0) -> Any:
        return REQUESTS["DQBUF"][1](index=index, type=BUFFER_CAPTURE, memory=MEMORY_MMAP)

    def _dequeue(self, deadline: float) -> Any:
        while True:
            if not self._node.wait(deadline):
                raise DeviceError(
                    f"No frame came from the camera {self._node.path}.",
                    "Is it connected, and is its format right? Unplug it and connect it again.",
                )
            try:
                buffer = self._node.request("DQBUF", self._buffer())
            except OSError as error:
                if error.errno == errno.EAGAIN and time.monotonic() < deadline:
                    time.sleep(0.001)  # an error event makes the node readable without a frame
                    continue
                raise self._node.failure("fetching a frame", error) from error
            if self._last_sequence is not None:
                self.lost += max(0, buffer.sequence - self._last_sequence - 1)
            self._last_sequence = buffer.sequence
            return buffer

    def _queue(self, buffer: Any) -> None:
        try:
            self._node.request("QBUF", buffer)
        except OSError as error:
            raise self._node.failure("giving a buffer back", error) from error


class Freshness:
    """Which frames count: those of now, exposed wholly after the last change, and then not the first few.

    Parameters
    ----------
    asked : monotonic time since when a frame is wanted.
    changed : monotonic time of the last change of lights or controls.
    exposure_s : exposure time.
    delay_s : longest time from the end of the exposure of a frame's first line to a stamp that is not
        taken at its start: a rolling shutter's read-out, or a USB camera's buffer.
    skip : further frames to drop: a camera applies controls some frames late.
    """

    def __init__(
        self, asked: float, changed: float, exposure_s: float, delay_s: float, skip: int = 0
    ) -> None:
        self._asked = asked
        self._changed = changed
        self._exposure_s = exposure_s
        self._delay_s = delay_s
        self._skip = skip
        self.dropped = 0

    def accepts(self, stamp: Stamp) -> bool:
        """Whether a frame counts; to be asked once for each frame, in order."""
        latest = stamp.time if stamp.at_start else stamp.time - self._exposure_s
        earliest = latest if stamp.at_start else latest - self._delay_s
        if latest >= self._asked and earliest >= self._changed:
            if self._skip <= 0:
                return True
            self._skip -= 1
        self.dropped += 1
        return False


def formats(node: Node) -> list[str]:
    """Pixel formats that the camera offers, by their four letters."""
    found: list[str] = []
    while True:
        argument = REQUESTS["ENUM_FMT"][1](index=len(found), type=BUFFER_CAPTURE)
        try:
            found.append(fourcc_name(node.request("ENUM_FMT", argument).pixelformat))
        except OSError as error:
            if error.errno == errno.EINVAL:
                return found
            raise node.failure("listing its formats", error) from error


def _set_format(node: Node, wanted: FormatTable) -> Layout:
    offered = formats(node)
    name = wanted.pixel_format or next((name for name in DECODERS if name in offered), None)
    if name is None or name not in offered or name not in DECODERS:
        asked = "a format that can be read" if wanted.pixel_format is None else f"format {name}"
        raise BadInput(
            f"The camera {node.path} does not offer {asked}.",
            f"It offers {', '.join(offered) or 'none'}; {', '.join(DECODERS)} can be read.",
        )
    try:
        argument = node.request("G_FMT", Format(type=BUFFER_CAPTURE))
        pix = argument.fmt.pix
        pix.pixelformat = fourcc(name)
        pix.width, pix.height = wanted.width or pix.width, wanted.height or pix.height
        pix.field = 1  # progressive
        pix.bytesperline = pix.sizeimage = 0
        asked_size = (pix.width, pix.height)
        pix = node.request("S_FMT", argument).fmt.pix
    except OSError as error:
        raise node.failure("setting its format", error) from error
    if (pix.width, pix.height) != asked_size or pix.pixelformat != fourcc(name):
        raise BadInput(
            f"The camera {node.path} does not offer {name} at {asked_size[0]}×{asked_size[1]} px.",
            f"The nearest is {fourcc_name(pix.pixelformat)} at {pix.width}×{pix.height} px.",
        )
    return Layout.of(pix)


def _set_frame_rate(node: Node, rate: float | None) -> float | None:
    """Ask for a frame rate, if one is wanted; the frame period that holds, None where none is known."""
    argument = REQUESTS["G_PARM"][1](type=BUFFER_CAPTURE)
    try:
        node.request("G_PARM", argument)
        interval = argument.parm.capture.timeperframe
        if rate is not None:
            interval.numerator, interval.denominator = 1000, round(1000 * rate)
            node.request("S_PARM", argument)
            interval = argument.parm.capture.timeperframe
    except OSError as error:
        if error.errno in (errno.ENOTTY, errno.EINVAL):
            return None
        raise node.failure("setting its frame rate", error) from error
    if not interval.denominator or not interval.numerator:
        return None
    period = float(interval.numerator / interval.denominator)
    if rate is not None and abs(period * rate - 1) > 0.01:
        raise BadInput(
            f"The camera {node.path} does not offer {rate:g} frames/s at this size.",
            f"The nearest is {1 / period:g}.",
        )
    return period


def _stamp(buffer: Any, driver: str) -> Stamp:
    from_driver = buffer.flags & BUFFER_CLOCK_MASK == BUFFER_CLOCK_MONOTONIC
    stamped = buffer.timestamp.secs + 1e-6 * buffer.timestamp.usecs
    now = time.monotonic()
    return Stamp(
        sequence=buffer.sequence,
        # some drivers say when the frame should have been complete, which may be yet to come
        time=min(stamped, now) if from_driver else now,
        at_start=from_driver
        and bool(buffer.flags & BUFFER_STAMPED_AT_START)
        and driver not in STAMPED_AT_FIRST_PACKET,
        from_driver=from_driver,
    )
