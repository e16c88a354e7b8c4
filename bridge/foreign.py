"""The C module that gives Prolog its ZeroMQ sockets, built from its sources where it is missing or older.

It is built for the swipl of this machine: `make setup` does it, and an installed copy at its first session.
Only Python's own library is needed, so that `python bridge/foreign.py` works before anything is installed.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

FOLDER = Path(__file__).resolve().parent / "prolog"
MODULE = FOLDER / "zmq4pl.so"
NEEDED = "it needs swipl-ld (SWI-Prolog), a C compiler and the headers of libzmq (Debian: libzmq3-dev)"


class ForeignModuleError(RuntimeError):
    """The module cannot be built; the message says why and what to do."""


def ensure_module() -> None:
    """Build `MODULE` unless it is newer than its sources.

    Raises
    ------
    ForeignModuleError : no swipl-ld, a folder that cannot be written, or what the compiler said.
    """
    sources = sorted(FOLDER.glob("*.c"))
    newest = max(file.stat().st_mtime for file in [*sources, *FOLDER.glob("*.h")])
    if MODULE.exists() and MODULE.stat().st_mtime >= newest:
        return
    linker = shutil.which("swipl-ld")
    if linker is None:
        raise ForeignModuleError(f"the C module {MODULE} is not built yet: {NEEDED}")
    if not os.access(FOLDER, os.W_OK):
        raise ForeignModuleError(f"the C module {MODULE} is not built yet, and its folder cannot be written")
    with tempfile.TemporaryDirectory(dir=FOLDER) as folder:  # two that build at once do not meet
        built = Path(folder) / MODULE.name
        command = [linker, "-shared", "-O2", "-Wall", "-o", str(built), *map(str, sources), "-lzmq"]
        ran = subprocess.run(command, capture_output=True, text=True, check=False, cwd=folder)
        sys.stderr.write(ran.stderr)
        if ran.returncode != 0 or not built.exists():
            raise ForeignModuleError(f"the C module {MODULE} could not be built (see above): {NEEDED}")
        built.replace(MODULE)


if __name__ == "__main__":
    try:
        ensure_module()
    except ForeignModuleError as error:
        sys.exit(f"setup: {error}")
