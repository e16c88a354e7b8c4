"""Enttec DMX USB Pro: DMX512 through a USB widget (Enttec, "DMX USB Pro Widget API", 1.44).

A message is ``0x7E label length_low length_high payload 0xE7``. Label 6 sends a DMX packet: start code 0,
then one byte per channel, 24 to 512 of them; the widget repeats it to the lamps until another comes, also
when the computer has gone. It says nothing about lamps: levels cannot be read back. Labels 3 (parameters)
and 10 (serial number) are answered, so the widget itself is known to live and to have taken the packet
before, since it works off messages in order.
"""

import time
from collections.abc import Sequence

from bridge.errors import DeviceError
from image_server.lights.driver import LightDriver, Status
from image_server.lights.port import Port

START, END = 0x7E, 0xE7  # of a message (the API)
GET_PARAMETERS, SEND_DMX, GET_SERIAL = 3, 6, 10  # labels (the API)
LEAST_CHANNELS, MOST_CHANNELS = 24, 512  # of a packet (the API)
MOST_PAYLOAD = 600  # the API's limit
BAUD = 57600  # a virtual serial port: the widget does not care
ANSWER_DEADLINE_S = 0.5  # chosen by hand: an answer takes some ms


def message(label: int, payload: bytes = b"") -> bytes:
    """One message to or from the widget."""
    return bytes([START, label, len(payload) & 0xFF, len(payload) >> 8]) + payload + bytes([END])


def dmx_packet(values: Sequence[int]) -> bytes:
    """The message that sets the first channels, the rest of the smallest universe being 0."""
    channels = bytes(values).ljust(LEAST_CHANNELS, b"\0")
    return message(SEND_DMX, b"\0" + channels)


class MessageReader:
    """Messages out of a stream of bytes; what does not belong to one is skipped and counted."""

    def __init__(self) -> None:
        self._buffer = bytearray()
        self.skipped = 0

    def feed(self, data: bytes) -> list[tuple[int, bytes]]:
        """Messages completed by these bytes, as (label, payload)."""
        self._buffer += data
        found = []
        while (taken := self._take()) is not None:
            size, made = taken
            del self._buffer[:size]
            if made is None:
                self.skipped += size
            else:
                found.append(made)
        return found

    def _take(self) -> tuple[int, tuple[int, bytes] | None] | None:
        """Bytes to consume, with the message that they were, if they were one; None: wait for more."""
        data = self._buffer
        if not data:
            return None
        if data[0] != START:
            start = data.find(START)
            return (len(data) if start < 0 else start), None
        if len(data) < 4:
            return None
        size = data[2] | data[3] << 8
        if size > MOST_PAYLOAD:
            return 1, None
        if len(data) < size + 5:
            return None
        if data[size + 4] != END:
            return 1, None
        return size + 5, (data[1], bytes(data[4 : size + 4]))


class DmxUsbPro(LightDriver):
    """A widget on a serial port.

    Raises
    ------
    BadInput : no such device, or no permission.
    DeviceError : busy, or not a widget that answers.
    """

    channels = MOST_CHANNELS
    full = 255
    # twice: the first may fill up a message that was cut off when the server was killed
    dark = 2 * dmx_packet([0] * MOST_CHANNELS)

    def __init__(self, path: str) -> None:
        self._port = Port(path, BAUD)
        self._reader = MessageReader()
        try:
            number = self._ask(GET_SERIAL, b"", 4)
            firmware = self._ask(GET_PARAMETERS, b"\0\0", 5)
        except BaseException:
            self._port.close()
            raise
        # four bytes of two decimal digits each, the lowest first
        serial_number = "".join(f"{byte:02x}" for byte in reversed(number[:4]))
        self.identity = (
            f"DMX USB Pro {serial_number} (firmware {firmware[1]}.{firmware[0]}, no read-back) at {path}"
        )

    def set(self, values: Sequence[int]) -> None:
        """Send a packet, and hear that the widget still lives; levels cannot be read back."""
        self._port.send(dmx_packet(values))
        self._ask(GET_SERIAL, b"", 4)

    def check(self) -> Status:
        """The widget answers; of the lamps it knows nothing."""
        self._ask(GET_PARAMETERS, b"\0\0", 5)
        return Status()

    def fileno(self) -> int:
        """Descriptor of the port."""
        return self._port.fileno()

    def close(self) -> None:
        """Give the port back."""
        self._port.close()

    def _ask(self, label: int, payload: bytes, least: int) -> bytes:
        self._port.send(message(label, payload), forget=False)
        deadline = time.monotonic() + ANSWER_DEADLINE_S
        heard = self._reader.skipped
        while True:
            data = self._port.receive(deadline)
            for answered, content in self._reader.feed(data):
                if answered == label and len(content) >= least:
                    return content
            if time.monotonic() >= deadline:
                break
        if self._reader.skipped > heard:
            raise DeviceError(
                f"The lights at {self._port.path} answer with garbage.",
                "Is it an Enttec DMX USB Pro? Check the protocol in the lights file.",
            )
        raise DeviceError(
            f"The lights at {self._port.path} do not answer.", "Check power and cable of the DMX USB Pro."
        )
