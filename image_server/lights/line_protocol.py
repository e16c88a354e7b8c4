"""The line protocol: a text protocol for small drivers of lights, with read-back (docs/hardware.md).

A request is one line ``NUMBER WORDS*HH`` and so is its answer, which repeats the number; HH is the exclusive
or of all bytes before the asterisk, as in NMEA 0183. The driver turns everything off by itself when it has
heard nothing for its hold-off time.

    ID                  ID KIND VERSION channels=N full=N serial=TEXT
    SET V1 V2 ... VN    OUT V1 V2 ... VN      what the outputs have now
    GET                 OUT V1 V2 ... VN
    HOLD MS             HOLD MS               hold-off time from now on, 0: never
    STATUS              STATUS temp_c=T|- faults=CHANNEL:REASON,...|-
    (anything else)     ERR REASON
"""

import math
import re
import time
from collections.abc import Sequence

from bridge.errors import DeviceError
from image_server.lights.driver import LightDriver, Status
from image_server.lights.port import Port

BAUD = 115200  # docs/hardware.md
WAKE_S = 3.0  # until a first answer, chosen by hand: an Arduino starts afresh when its port is opened
ANSWER_DEADLINE_S = 0.5  # chosen by hand: an answer takes some ms
MOST_CHANNELS, MOST_FULL = 512, 65535  # that a lights file can name
MOST_LINE = 4096  # bytes; so many channels of five digits fit
IDENTITY = re.compile(r"ID (\S+) (\S+) channels=(\d+) full=(\d+) serial=(\S+)")
STATUS = re.compile(r"STATUS temp_c=(\S+) faults=(\S+)")


class GarbledLineError(ValueError):
    """A line whose check does not fit."""


def encoded(number: int, words: str) -> bytes:
    """One line with its number and check."""
    body = f"{number} {words}"
    return f"{body}*{_check(body):02X}\n".encode("ascii")


def decoded(line: bytes) -> tuple[int, str]:
    """Number and words of a line.

    Raises
    ------
    GarbledLineError : not a line of the protocol.
    """
    body, star, check = line.strip().decode("ascii", "replace").rpartition("*")
    number, _, words = body.partition(" ")
    if not star or len(line) > MOST_LINE or not number.isdecimal() or check != f"{_check(body):02X}":
        raise GarbledLineError(repr(line))
    return int(number), words


def _check(body: str) -> int:
    check = 0
    for byte in body.encode("ascii", "replace"):
        check ^= byte
    return check


class LineDriver(LightDriver):
    """A driver that speaks the line protocol.

    Parameters
    ----------
    path : serial device.
    hold_off_s : how long the driver stays lit without a word from here; 0 is for ever.

    Raises
    ------
    BadInput : no such device, or no permission.
    DeviceError : busy, or nothing that answers in this protocol.
    """

    def __init__(self, path: str, hold_off_s: float = 2.0) -> None:
        self._port = Port(path, BAUD)
        self._number = 0
        try:
            found = IDENTITY.fullmatch(self._first_answer())
            if found is None:
                raise DeviceError(f"The lights at {path} do not say what they are.", "Update their firmware.")
            kind, version, channels, full, serial_number = found.groups()
            self.identity = f"{kind} {serial_number} (version {version}) at {path}"
            self.channels, self.full = int(channels), int(full)
            if not (1 <= self.channels <= MOST_CHANNELS and 1 <= self.full <= MOST_FULL):
                raise self._nonsense(found.group())
            self.dark = b"\n" + encoded(0, "SET" + " 0" * self.channels)
            self._ask(f"HOLD {round(1000 * hold_off_s)}", "HOLD ")
        except BaseException:
            self._port.close()
            raise

    def set(self, values: Sequence[int]) -> list[int]:
        """Set all channels; what the outputs have then."""
        padded = [*values, *[0] * (self.channels - len(values))]
        answer = self._ask("SET " + " ".join(map(str, padded)), "OUT ")
        outputs = answer.split()[1:]
        if len(outputs) != self.channels or not all(word.isdecimal() for word in outputs):
            raise self._nonsense(answer)
        return [int(word) for word in outputs]

    def check(self) -> Status:
        """Temperature and failed channels."""
        answer = self._ask("STATUS", "STATUS ")
        found = STATUS.fullmatch(answer)
        if found is None:
            raise self._nonsense(answer)
        temperature, faults = found.groups()
        try:
            listed = [fault.partition(":") for fault in faults.split(",")] if faults != "-" else []
            degrees = math.nan if temperature == "-" else float(temperature)
            return Status(
                faults={int(channel): reason or "failed" for channel, _, reason in listed},
                # an open sensor, which an Arduino prints as nan or inf, is no reason to put the lights out
                temperature_c=degrees if math.isfinite(degrees) else None,
            )
        except ValueError:
            raise self._nonsense(answer) from None

    def fileno(self) -> int:
        """Descriptor of the port."""
        return self._port.fileno()

    def close(self) -> None:
        """Give the port back."""
        self._port.close()

    def _first_answer(self) -> str:
        deadline = time.monotonic() + WAKE_S
        while True:
            try:
                return self._ask("ID", "ID ")
            except DeviceError:
                if time.monotonic() >= deadline:
                    raise

    def _ask(self, words: str, answer: str) -> str:
        self._number += 1
        self._port.send(encoded(self._number, words))
        deadline = time.monotonic() + ANSWER_DEADLINE_S
        line, garbled = b"", False
        while True:
            line += self._port.receive(deadline)
            *complete, line = line.split(b"\n")
            for candidate in complete:
                try:
                    number, reply = decoded(candidate)
                except GarbledLineError:
                    garbled = True
                    continue
                if number == self._number:
                    return self._accepted(words, answer, reply)
            garbled |= len(line) > MOST_LINE
            line = line[-MOST_LINE:]
            if time.monotonic() >= deadline:
                break
        if garbled or line:
            raise DeviceError(
                f"The lights at {self._port.path} answer with garbage.",
                "Check protocol and cable, and that nothing else talks to them.",
            )
        raise DeviceError(f"The lights at {self._port.path} do not answer.", "Check their power and cable.")

    def _accepted(self, words: str, answer: str, reply: str) -> str:
        if not reply.startswith(answer):
            raise DeviceError(
                f"The lights at {self._port.path} refuse {words.split(maxsplit=1)[0]}: {reply}.",
                "Compare the lights file with what the driver has.",
            )
        return reply

    def _nonsense(self, reply: str) -> DeviceError:
        return DeviceError(f"The lights at {self._port.path} answered {reply!r}, which makes no sense.")
