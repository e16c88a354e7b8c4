"""`lights-and-camera`: one session with the files installed beside this one; options as of main.pl."""

import os
import shutil
import sys
from pathlib import Path

from bridge.foreign import ForeignModuleError, ensure_module

ROOT = Path(__file__).resolve().parent.parent


def main() -> None:
    """Become `swipl main.pl OPTIONS`, with this Python for the servers; the exit status is the session's."""
    try:
        swipl = shutil.which("swipl")
        if swipl is None:
            raise ForeignModuleError("there is no `swipl` on the PATH; install SWI-Prolog 9.0.4 or newer")
        ensure_module()
    except ForeignModuleError as error:
        print(f"lights-and-camera: {error}", file=sys.stderr)
        sys.exit(2)
    os.environ["LIGHTS_AND_CAMERA_PYTHON"] = sys.executable
    os.execv(swipl, [swipl, str(ROOT / "main.pl"), *sys.argv[1:]])
