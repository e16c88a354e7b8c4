"""Faults of emulated devices: now, or at times after the start."""

import re
import time
from collections.abc import Mapping, Sequence
from typing import Protocol

from bridge.errors import BadInput

TIMED = re.compile(r"(\d+(?:\.\d*)?|\.\d+):(.+)")


class Faulty(Protocol):
    """An emulated device."""

    def fault(self, kind: str) -> None:
        """Have a fault from now on."""

    def check_fault(self, kind: str) -> None:
        """Refuse a fault that it cannot have."""


class FaultPlan:
    """Faults such as "silent", "5:silent" (after five seconds) or "5:camera:silent".

    Parameters
    ----------
    devices : by the word that stands before their faults; one may have no word.
    plan : the faults.

    Raises
    ------
    BadInput : no such fault.
    """

    def __init__(self, devices: Mapping[str, Faulty], plan: Sequence[str]) -> None:
        self._devices = devices
        self._timed: list[tuple[float, str]] = []
        for entry in plan:
            timed = TIMED.fullmatch(entry)
            seconds, kind = (float(timed[1]), timed[2]) if timed else (0.0, entry)
            device, word = self._meant(kind)
            device.check_fault(word)
            self._timed.append((time.monotonic() + seconds, kind))

    def due(self) -> None:
        """Let what is due happen."""
        now = time.monotonic()
        for entry in [entry for entry in self._timed if entry[0] <= now]:
            self._timed.remove(entry)
            self.now(entry[1])

    def now(self, kind: str) -> None:
        """Let one fault happen."""
        device, word = self._meant(kind)
        device.fault(word)

    def _meant(self, kind: str) -> tuple[Faulty, str]:
        name, colon, word = kind.partition(":")
        if colon and name in self._devices:
            return self._devices[name], word
        if "" not in self._devices:
            raise BadInput(f"Nothing here has the fault {kind!r}.", f"Begin with {', '.join(self._devices)}:")
        return self._devices[""], kind
