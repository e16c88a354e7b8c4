"""An emulated serial device: a pseudo-terminal, a thread that answers, and faults on request."""

import os
import pty
import re
import select
import threading
import tty
from abc import ABC, abstractmethod
from collections.abc import Callable
from pathlib import Path

from bridge.errors import BadInput

GARBAGE = b"\x00\xff\x7e\x13Qq%\n"
FAULT = re.compile(r"(none|silent|garbage|unplugged|dead:(\d+))")
TICK_S = 0.05

FAULTS = "none, silent, garbage, unplugged or dead:CHANNEL"

Show = Callable[[list[int]], None]


class Emulator(ABC):
    """One device behind a pseudo-terminal; `path` is what a server opens.

    Parameters
    ----------
    channels : how many outputs it has.
    show : told of the outputs whenever they change, from the device's thread.
    link : where to put a symbolic link to the pseudo-terminal.
    """

    name: str

    def __init__(self, channels: int, show: Show | None = None, link: Path | None = None) -> None:
        self.channels = channels
        self.outputs = [0] * channels
        self.requests = 0
        self._show = show or (lambda _outputs: None)
        self._link = link
        self._fault = "none"
        self._dead: set[int] = set()
        self._stop = threading.Event()
        self._master, self._slave = pty.openpty()
        tty.setraw(self._slave)
        self.path = os.ttyname(self._slave)
        if link is not None:
            self._make_link(link)
        self._thread = threading.Thread(target=self._run, name=self.name, daemon=True)
        self._thread.start()

    @abstractmethod
    def answer(self, data: bytes) -> bytes:
        """What the device says to these bytes."""

    def tick(self) -> None:  # noqa: B027  # only some devices do anything by themselves
        """Called every few hundredths of a second."""

    def fault(self, kind: str) -> None:
        """Have a fault from now on: none, silent, garbage, unplugged or dead:CHANNEL.

        Raises
        ------
        BadInput : no such fault.
        """
        self.check_fault(kind)
        word, _, channel = kind.partition(":")
        if word == "dead":
            self._dead.add(int(channel))
            self.put(self.outputs)
        elif kind == "unplugged":
            self._unplug()
        else:
            if kind == "none":
                self._dead.clear()
            self._fault = kind

    def check_fault(self, kind: str) -> None:
        """Refuse a fault that it cannot have."""
        found = FAULT.fullmatch(kind)
        if found is None or (found[2] and not 1 <= int(found[2]) <= self.channels):
            raise BadInput(
                f"The {self.name} has no fault {kind!r}.", f"Give {FAULTS} (1 to {self.channels})."
            )

    def put(self, values: list[int]) -> None:
        """Set the outputs; those that are dead stay 0."""
        outputs = [0 if channel in self._dead else value for channel, value in enumerate(values, 1)]
        if outputs != self.outputs:
            self.outputs = outputs
            self._show(outputs)

    @property
    def dead(self) -> list[int]:
        """Channels whose output has failed."""
        return sorted(self._dead)

    def close(self) -> None:
        """Vanish; may be called twice."""
        self._unplug()
        self._thread.join()
        if self._link is not None and self._link.is_symlink():
            self._link.unlink()
            self._link = None

    def _unplug(self) -> None:
        self._stop.set()
        if threading.current_thread() is not self._thread:
            self._thread.join()
        for descriptor in (self._slave, self._master):
            if descriptor >= 0:
                os.close(descriptor)
        self._slave = self._master = -1

    def _run(self) -> None:
        while not self._stop.is_set():
            ready, _, _ = select.select([self._master], [], [], TICK_S)
            if ready:
                data = os.read(self._master, 4096)
                reply = self.answer(data)
                if self._fault == "garbage":
                    reply = GARBAGE if reply else b""
                if reply and self._fault != "silent":
                    os.write(self._master, reply)
            self.tick()

    def _make_link(self, link: Path) -> None:
        try:
            if link.is_symlink():
                link.unlink()
            link.symlink_to(self.path)
        except OSError as error:
            raise BadInput(
                f"Cannot make the link {link}: {error.strerror}.", "Choose another name."
            ) from None
