"""How far `make bench` is, on a terminal: what is measured, and the time left if it is as long as last."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from rich.console import Console
from rich.progress import Progress, ProgressColumn, SpinnerColumn, Task, TextColumn, TimeElapsedColumn
from rich.text import Text

REMEMBERED = Path(__file__).resolve().parent.parent / "build" / "bench-seconds.json"


class TimeLeft(ProgressColumn):
    """What is left of the seconds that the parts took last time; nothing where one of them is not known."""

    def render(self, task: Task) -> Text:
        """As text, such as `about 34 s left`."""
        to_come = task.fields["to_come_s"]
        if to_come is None:
            return Text("")
        left = max(0.0, to_come - (time.monotonic() - task.fields["since"]))
        return Text(f"about {left:.0f} s left" if left >= 1.0 else "longer than last time")


def remembered(file: Path = REMEMBERED) -> dict[str, float]:
    """Seconds that each part took when it was measured last."""
    with suppress(OSError, ValueError, TypeError, AttributeError):
        return {str(name): float(seconds) for name, seconds in json.loads(file.read_text()).items()}
    return {}


@contextmanager
def measuring(
    names: list[str], file: Path = REMEMBERED, console: Console | None = None
) -> Iterator[Callable[[str], None]]:
    """Call what is given with the name of each part as it begins; how long each takes is remembered."""
    took = remembered(file)
    console = console or Console(stderr=True)
    shown = Progress(
        SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn(), TimeLeft(),
        console=console, disable=not console.is_terminal, transient=True,
    )  # fmt: skip
    began: dict[str, float] = {}

    def ended() -> None:
        for name, since in began.items():
            took[name] = time.monotonic() - since
        began.clear()

    def begin(name: str) -> None:
        ended()
        began[name] = time.monotonic()
        ahead = [took.get(other) for other in names[names.index(name) :]]
        known = [seconds for seconds in ahead if seconds is not None]
        shown.update(
            task,
            description=f"{name}, {names.index(name) + 1} of {len(names)}",
            to_come_s=sum(known) if len(known) == len(ahead) else None,
            since=began[name],
        )

    with shown:
        task = shown.add_task("", total=None, to_come_s=None, since=time.monotonic())
        yield begin
    ended()
    with suppress(OSError):  # then it is not known next time
        file.parent.mkdir(exist_ok=True)
        file.write_text(json.dumps(took))
