"""Which code a row was computed by."""

import hashlib
import subprocess
from functools import cache
from pathlib import Path

from bridge import __version__

ROOT = Path(__file__).resolve().parent.parent
NOT_COMPUTING = (":!docs", ":!tests", ":!benchmarks", ":!examples", ":!*.md")  # no row depends on them


@cache
def code_version() -> str:
    """The commit, with a digest of what has been changed since; the release where there is no repository.

    Two machines whose answers are equal compute the same rows.
    """
    try:
        commit = _git("rev-parse", "--short=12", "HEAD").decode().strip()
        changes = _git("diff", "HEAD", "--no-ext-diff", "--", ".", *NOT_COMPUTING)
    except (OSError, subprocess.CalledProcessError):
        return f"release {__version__}"
    return f"{commit}+{hashlib.sha256(changes).hexdigest()[:8]}" if changes else commit


def _git(*words: str) -> bytes:
    return subprocess.run(["git", "-C", str(ROOT), *words], capture_output=True, check=True).stdout
