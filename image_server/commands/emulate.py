"""`emulate`: a light driver that is not there, on a pseudo-terminal."""

import sys
import time
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from bridge.lifeline import Lifeline
from image_server.command_line import Argument, Option
from image_server.commands.serving import plain_errors

if TYPE_CHECKING:
    from image_server.emulators.faults import FaultPlan

TICK_S = 0.05


LINK = Option(metavar="FILE", help="Make a symbolic link to the pseudo-terminal.")
FAULT = Option(
    metavar="[S:]FAULT",
    help="silent, garbage, unplugged or dead:CHANNEL, S seconds after the start; repeatable.",
)


class Kind(StrEnum):
    """What can be emulated."""

    DMX = "dmx"
    LINE = "line"


def emulate(
    kind: Annotated[Kind, Argument(help="dmx: Enttec DMX USB Pro; line: the line protocol.")],
    link: Annotated[Path | None, LINK] = None,
    channels: Annotated[int, Option(min=1, max=512, help="Outputs that have a lamp.")] = 3,
    fault: Annotated[list[str] | None, FAULT] = None,
    parent: Annotated[int | None, Option(metavar="PID", help="Stop when this process ends.")] = None,
) -> None:
    """Emulate a light driver; prints its device, then its outputs whenever they change.

    It also takes faults, one a line, on standard input; `none` ends them.
    """
    with plain_errors():
        from image_server.emulators.dmx import EmulatedDmxUsbPro
        from image_server.emulators.faults import FaultPlan
        from image_server.emulators.line import EmulatedLineDriver

        lifeline = Lifeline(parent, signals=True)
        make = EmulatedDmxUsbPro if kind is Kind.DMX else EmulatedLineDriver
        emulator = make(channels, shown, link)
        try:
            plan = FaultPlan({"": emulator}, fault or [])
            print(f"device {link or emulator.path}", flush=True)
            have_faults(plan, lifeline)
        finally:
            emulator.close()
            lifeline.close()
        sys.exit(lifeline.status)


def have_faults(plan: "FaultPlan", lifeline: Lifeline) -> None:
    """Faults as planned, and as they come on standard input, until it is time to stop."""
    commands = _Commands()
    while not lifeline.ended():
        plan.due()
        for line in commands.lines(TICK_S):
            plan.now(line)
            print(f"fault {line}", flush=True)


def shown(outputs: list[int]) -> None:
    """Print what the lights do."""
    print("outputs", *outputs, flush=True)


class _Commands:
    """Lines of standard input, as they come; at its end, none."""

    def __init__(self) -> None:
        import selectors

        self._selector: selectors.DefaultSelector | None = selectors.DefaultSelector()
        try:
            self._selector.register(sys.stdin, selectors.EVENT_READ)
        except (OSError, ValueError):  # a file or nothing at all
            self._selector = None

    def lines(self, wait_s: float) -> list[str]:
        """What came within the wait."""
        if self._selector is None:
            time.sleep(wait_s)
            return []
        if not self._selector.select(wait_s):
            return []
        line = sys.stdin.readline()
        if not line:
            self._selector = None
        return [line.strip()] if line.strip() else []
