"""The serial line to a driver of lights, and what each of its failures means in plain words."""

import errno
import termios
import time
from pathlib import Path

import serial

from bridge.errors import BadInput, DeviceBusy, DeviceError

READ_SLICE_S = 0.05
"""Longest single wait for bytes; the deadline is the caller's."""


FAILURES = (serial.SerialException, OSError, ValueError, TypeError, termios.error)
"""What pyserial lets through from a device that is not there (any more)."""


class PortGoneError(DeviceError):
    """The serial device has vanished: asking again is of no use."""


class Port:
    """A serial line, locked for this process.

    Raises
    ------
    BadInput : no such device, no permission, or not a serial device.
    DeviceBusy : another program has it.
    """

    def __init__(self, path: str, baud: int) -> None:
        self.path = path
        try:
            self._serial = serial.Serial(path, baud, timeout=READ_SLICE_S, write_timeout=1.0, exclusive=True)
        except FAILURES as error:
            raise _opening_failed(path, error) from None

    def fileno(self) -> int:
        """The descriptor, for a watchdog to inherit."""
        return int(self._serial.fileno())

    def send(self, data: bytes, forget: bool = True) -> None:
        """Write it all; `forget` drops what came in unread before.

        Raises
        ------
        DeviceError : the line is gone, or takes nothing.
        """
        try:
            if forget:
                self._serial.reset_input_buffer()
            self._serial.write(data)
            self._serial.flush()
        except serial.SerialTimeoutException:
            raise DeviceError(f"The lights at {self.path} take no data.", "Check cable and power.") from None
        except FAILURES as error:
            raise self._gone() from error

    def receive(self, deadline: float) -> bytes:
        """What has come in, at least one byte, unless the deadline (time.monotonic()) passes."""
        try:
            while True:
                data = bytes(self._serial.read(max(1, self._serial.in_waiting)))
                if data or time.monotonic() >= deadline:
                    return data
        except FAILURES as error:
            raise self._gone() from error

    def close(self) -> None:
        """Give the line back; may be called twice."""
        try:
            self._serial.close()
        except FAILURES:
            return  # a line that is gone needs no closing

    def _gone(self) -> PortGoneError:
        return PortGoneError(
            f"The lights at {self.path} are gone.", "Was the cable unplugged? Connect it and start again."
        )


def _opening_failed(path: str, error: Exception) -> Exception:
    number = getattr(error, "errno", None)
    text = str(error)
    if number == errno.ENOENT:
        found = [*Path("/dev").glob("ttyUSB*"), *Path("/dev").glob("ttyACM*")]
        names = ", ".join(sorted(map(str, found))) or "none"
        return BadInput(
            f"There is no serial device {path}.", f"Is it connected? USB serial devices here: {names}."
        )
    if number in (errno.EACCES, errno.EPERM):
        return BadInput(
            f"No permission to use the lights at {path}.",
            "Join the group of the device (usermod -aG dialout USER), then log in again.",
        )
    if number in (errno.EBUSY, errno.EAGAIN) or "exclusively lock" in text:
        return DeviceBusy(f"The lights at {path} are busy.", f"Another program uses them: fuser {path}")
    if (
        number in (errno.ENOTTY, errno.EINVAL)
        or "Could not configure" in text
        or isinstance(error, ValueError)
    ):
        return BadInput(f"{path} is not a serial device.", "Lights are at a device such as /dev/ttyUSB0.")
    return DeviceError(f"Cannot open the lights at {path}: {text}.")
