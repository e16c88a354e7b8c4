"""A session of `swipl main.pl` against mock servers, for tests of strategies."""

import json
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bridge.foreign import ensure_module
from bridge.mocks import MockImageServer, MockVisionServer

MAIN = Path(__file__).resolve().parent.parent / "main.pl"


@dataclass(frozen=True)
class MockSession:
    """What became of a session.

    Attributes
    ----------
    status : exit status (0 pose found, 3 not found, 2 bad usage or input, 4 a device or server failed).
    result : `result.json`; empty where the session wrote none.
    shown : what the terminal showed.
    """

    status: int
    result: dict[str, Any]
    shown: str


def mock_session(
    vision: MockVisionServer, image: MockImageServer, out: Path, *options: str, deadline_s: float = 120.0
) -> MockSession:
    """Run one session to its end.

    Parameters
    ----------
    vision, image : running mocks, scripted as the test needs.
    out : run folder.
    options : more options of `swipl main.pl`, such as `--controller FILE`.
    deadline_s : how long it may take.

    Raises
    ------
    subprocess.TimeoutExpired
        It did not end in time, and was killed.
    """
    ensure_module()
    done = subprocess.run(
        ["swipl", str(MAIN), "--vision-server", vision.endpoint, "--image-server", image.endpoint,
         "--out", str(out), "--no-report", "--json", *options],
        capture_output=True, text=True, timeout=deadline_s, stdin=subprocess.DEVNULL, check=False,
        env=os.environ | {"LIGHTS_AND_CAMERA_PYTHON": sys.executable},
    )  # fmt: skip
    return MockSession(done.returncode, json.loads(done.stdout or "{}"), done.stderr)
