"""What a person sees while kernels are compiled: how many are done, and the time that may be left."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Event, Thread

from numerics.stale_kernels import ROOT

LOOK_S = 0.5  # between two looks at what is compiled; chosen by hand
KERNEL = re.compile(r"^@kernel\(.*?\)\ndef (\w+)", re.MULTILINE | re.DOTALL)
INDEX = re.compile(r"(\w+)\.(\w+)-\d+\.\w+\.nbi")


def kernels(packages: Iterable[str], root: Path = ROOT) -> set[tuple[str, str]]:
    """Every kernel of these packages: the name of its file, without ending, and its own."""
    return {
        (source.stem, name)
        for package in packages
        for source in (root / package).rglob("*.py")
        for name in KERNEL.findall(source.read_text(encoding="utf-8"))
    }


def compiled(packages: Iterable[str], root: Path = ROOT) -> set[tuple[str, str]]:
    """Those that numba keeps on the disk, named as `kernels` does."""
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    folders = [Path(chosen)] if chosen else [root / package for package in packages]
    found = (INDEX.fullmatch(file.name) for folder in folders for file in folder.rglob("*.nbi"))
    return {(match[1], match[2]) for match in found if match}


@contextmanager
def warming(name: str, *packages: str, root: Path = ROOT) -> Iterator[None]:
    """Show on a terminal how far kernels are compiled, while that goes on in the block.

    Parameters
    ----------
    name : what they are of.
    packages, root : where they are; some may never be asked for, so that the time left is at most that.
    """
    if not sys.stderr.isatty():
        yield
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    wanted = kernels(packages, root)
    there = compiled(packages, root) & wanted
    bar = Progress(
        TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(),
        TextColumn("at most"), TimeRemainingColumn(), TextColumn("left"), console=Console(stderr=True),
    )  # fmt: skip
    done = Event()

    def look() -> None:
        while not done.wait(LOOK_S):
            bar.update(task, completed=len((compiled(packages, root) & wanted) - there))

    with bar:
        task = bar.add_task(f"kernels of the {name}", total=len(wanted - there))
        watching = Thread(target=look, daemon=True)
        watching.start()
        try:
            yield
        finally:
            done.set()
            watching.join()
            bar.update(task, completed=len(wanted - there))
