"""Who works in a run folder, and what it is told to do: a lock and a file; loads next to nothing."""

from __future__ import annotations

import fcntl
import os
import struct
from pathlib import Path

from bridge.errors import BadInput
from bridge.whole_file import replaced

LOCK = "hhqqi"  # struct flock of fcntl(2): type, whence, start, length, process


def must_be_session(folder: Path) -> None:
    """Raise BadInput where there is no such folder, or none of a session."""
    if not folder.is_dir():
        raise BadInput(f"{folder}: no such folder; give the run folder of a session (--out of main.pl)")
    if not any((folder / name).is_file() for name in ("session.pl", "history.pl", "result.json")):
        raise BadInput(
            f"{folder}: no session was begun here (no session.pl, history.pl or result.json in it)"
        )


def session_process(folder: Path) -> int | None:
    """The process of the session that works in this folder: it holds the lock of session.pl.

    A process on another machine that shares the folder counts as 0.
    """
    try:
        with (folder / "session.pl").open("rb") as file:
            asked = struct.pack(LOCK, fcntl.F_RDLCK, os.SEEK_SET, 0, 0, 0)
            kind, *_, process = struct.unpack(LOCK, fcntl.fcntl(file, fcntl.F_GETLK, asked))
    except OSError:
        return None
    return None if kind == fcntl.F_UNLCK else max(0, process)


def waits(folder: Path) -> bool:
    """Whether the session was told to pause and has ended the action it was in."""
    return (folder / "held").exists()


def hold(folder: Path, word: str) -> None:
    """Tell the session to pause, step, stop, or go on (docs/result.md).

    Raises
    ------
    BadInput : a word that is none of these, a session that has ended, a folder that cannot be written.
    """
    if word not in ("pause", "step", "stop", "go"):
        raise BadInput(f"a session cannot be told to {word!r}; it knows pause, step, stop and go")
    if session_process(folder) is None:
        raise BadInput("the session has ended: it cannot be told anything any more")
    try:
        if word == "go":
            (folder / "hold").unlink(missing_ok=True)
        else:
            with replaced(folder / "hold") as new:
                new.write_text(f"{word}\n")
    except OSError as error:
        raise BadInput(f"{folder / 'hold'}: cannot be written ({error.strerror})") from error
