"""Sessions of several kinds, for those who kill or cut them; their images are small."""

import os
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path

from tests.session.command import ROOT
from tests.session.scenes import small

NEVER = ("--threshold", "0.000001", "--max-iterations")
CASES: dict[str, tuple[str, ...]] = {
    "short": (),
    "long": (*NEVER, "5"),
    "satellite": ("--target", "satellite", "--scenario", "blur", "--controller", "greedy", *NEVER, "4"),
    "drifting": ("--scenario", "drifting", *NEVER, "5"),
    "turning-sun": ("--scenario", "turning-sun", *NEVER, "4"),
    "approach": ("--approach", "--first-range", "0.5", "--contact-range", "0.4"),
    "stack": ("--stack", "STACK", *NEVER, "3"),
    "first-sight": ("--first-sight", "--target", "fixture", *NEVER, "2"),
    "informed": ("--controller", "informed", "--scenario", "harsh", *NEVER, "4"),
    "viewed": ("--view", *NEVER, "2"),
}


def words_of(case: str) -> list[str]:
    """Options of a case, whose images are small."""
    words = list(CASES[case])
    if "STACK" in words:
        words[words.index("STACK")] = str(stack())
    elif "--scenario" in words:
        at = words.index("--scenario") + 1
        words[at] = str(small(words[at]))
    else:
        words += ["--scenario", str(small("approach" if "--approach" in words else "nominal"))]
    return words


def stack() -> Path:
    """A stack that was recorded from the simulator, of small images; it goes with the kept servers."""
    return _recorded(os.environ["XDG_RUNTIME_DIR"])


@cache
def _recorded(goes_with: str) -> Path:
    folder = Path(tempfile.mkdtemp(prefix="stack-", dir=goes_with)) / "stack"
    words = ["record", str(folder), "--kind", "basis", "--scenario", str(small()), "--seed", "2"]
    command = [sys.executable, "-m", "image_server", *words, "--average", "2"]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    return folder
