"""Servers that stay, for the sessions of many tests: to start them takes most of a short session's time.

`test_kept_servers.py` shows that a session on them finds what one on servers of its own finds.
"""

import os
import signal
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.session.command import alive, controller, gone

KEEPING = ("--keep-servers", "--idle-s", "300")  # longer than tests of anything else take in between


def served(*options: str | Path, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Run one session to its end, on servers that others left where these fit."""
    return controller(*options, *KEEPING, cwd=cwd)


@contextmanager
def kept_servers() -> Iterator[Path]:
    """A folder where servers are kept; they end with it. Its environment is this process's meanwhile."""
    before = os.environ.get("XDG_RUNTIME_DIR")
    with tempfile.TemporaryDirectory(prefix="r") as parent:  # a socket's path must be short
        os.environ["XDG_RUNTIME_DIR"] = parent
        folder = Path(parent) / "lights-and-camera"
        try:
            yield folder
        finally:
            end_kept_servers(folder)
            if before is None:
                del os.environ["XDG_RUNTIME_DIR"]
            else:
                os.environ["XDG_RUNTIME_DIR"] = before


def kept(folder: Path) -> dict[str, int]:
    """Process ids of the servers that run there, by the name of their socket; a file may be empty yet."""
    told = {file.stem: file.read_text().rstrip(".\n") for file in folder.glob("*.pid")}
    named = {name: int(pid) for name, pid in told.items() if pid}
    return {name: pid for name, pid in named.items() if alive(pid)}


def end_kept_servers(folder: Path) -> None:
    """End all that run there."""
    running = kept(folder)
    for pid in running.values():
        os.kill(pid, signal.SIGTERM)
    gone(running, 20)
