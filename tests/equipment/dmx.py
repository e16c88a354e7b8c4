"""An emulated Enttec DMX USB Pro with lamps on its first channels."""

from pathlib import Path

from image_server.lights.dmx_usb_pro import GET_PARAMETERS, GET_SERIAL, SEND_DMX, MessageReader, message
from tests.equipment.emulator import Emulator, Show

PARAMETERS = bytes([4, 1, 9, 1, 40])
"""Firmware 1.4, break 9 × 10.67 µs, mark after break 1 × 10.67 µs, 40 packets a second."""
SERIAL = bytes.fromhex("78563412")


class EmulatedDmxUsbPro(Emulator):
    """Like the widget, it keeps its last packet for ever."""

    name = "emulated DMX USB Pro"

    def __init__(self, channels: int = 3, show: Show | None = None, link: Path | None = None) -> None:
        self._reader = MessageReader()
        super().__init__(channels, show, link)

    def answer(self, data: bytes) -> bytes:
        """Labels 3 and 10 are answered, label 6 is done."""
        reply = b""
        for label, payload in self._reader.feed(data):
            self.requests += 1
            if label == SEND_DMX and payload[:1] == b"\0":
                self.put(list(payload[1 : self.channels + 1].ljust(self.channels, b"\0")))
            elif label == GET_PARAMETERS:
                reply += message(GET_PARAMETERS, PARAMETERS)
            elif label == GET_SERIAL:
                reply += message(GET_SERIAL, SERIAL)
        return reply
