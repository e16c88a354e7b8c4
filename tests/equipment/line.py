"""An emulated driver of the line protocol."""

import time
from pathlib import Path

from image_server.lights.line_protocol import GarbledLineError, decoded, encoded
from tests.equipment.emulator import Emulator, Show

FULL = 255
TEMPERATURE_C = 20.0
WARMING_C = 10.0
"""How much warmer than the room the driver is with everything on."""
FIRST_HOLD_OFF_S = 2.0


class EmulatedLineDriver(Emulator):
    """Outputs that go dark by themselves when nothing is heard for the hold-off time."""

    name = "emulated line driver"

    def __init__(self, channels: int = 3, show: Show | None = None, link: Path | None = None) -> None:
        self._line = b""
        self._hold_off_s = FIRST_HOLD_OFF_S
        self._heard = time.monotonic()
        super().__init__(channels, show, link)

    def answer(self, data: bytes) -> bytes:
        """An answer for each whole line."""
        *lines, self._line = (self._line + data).split(b"\n")
        reply = b""
        for line in lines:
            try:
                number, words = decoded(line)
            except GarbledLineError:
                continue
            self.requests += 1
            self._heard = time.monotonic()
            reply += encoded(number, self._reply(words.split()))
        return reply

    def tick(self) -> None:
        """Go dark when the hold-off time has run out."""
        if self._hold_off_s and time.monotonic() - self._heard > self._hold_off_s:
            self.put([0] * self.channels)

    def _reply(self, words: list[str]) -> str:
        match words:
            case ["ID"]:
                return f"ID emulated-driver 1 channels={self.channels} full={FULL} serial=000042"
            case ["SET", *values] if len(values) == self.channels and all(map(_in_range, values)):
                self.put([int(value) for value in values])
                return self._outputs()
            case ["SET", *_]:
                return f"ERR SET needs {self.channels} values from 0 to {FULL}"
            case ["GET"]:
                return self._outputs()
            case ["HOLD", milliseconds] if milliseconds.isdecimal():
                self._hold_off_s = int(milliseconds) / 1000
                return f"HOLD {milliseconds}"
            case ["STATUS"]:
                warm = WARMING_C * sum(self.outputs) / (FULL * self.channels)
                faults = ",".join(f"{channel}:open_circuit" for channel in self.dead) or "-"
                return f"STATUS temp_c={TEMPERATURE_C + warm:.1f} faults={faults}"
            case _:
                return f"ERR unknown request {words[0] if words else ''}".rstrip()

    def _outputs(self) -> str:
        return "OUT " + " ".join(map(str, self.outputs))


def _in_range(word: str) -> bool:
    return word.isdecimal() and int(word) <= FULL
