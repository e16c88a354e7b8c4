"""Folders of workers under the temporary folder, and what killed workers left there."""

import os
import shutil
import tempfile
from contextlib import suppress
from pathlib import Path

NAME = "lights-and-camera-worker-"


def new_scratch() -> Path:
    """A folder of this process, which only this user can look into; its path is short enough for sockets."""
    return Path(tempfile.mkdtemp(prefix=f"{NAME}{os.getpid()}-"))


def sweep() -> None:
    """Remove the folders of processes that are gone."""
    for folder in Path(tempfile.gettempdir()).glob(f"{NAME}*"):
        with suppress(ValueError, OSError):
            pid = int(folder.name.removeprefix(NAME).partition("-")[0])
            try:
                os.kill(pid, 0)
            except ProcessLookupError:
                shutil.rmtree(folder, ignore_errors=True)
