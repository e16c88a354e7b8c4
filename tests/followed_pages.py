"""Pages that a test follows literally, in a clean copy of the project: their blocks, and what they show."""

import re
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
BLOCK = re.compile(r'^```(\w+)(?: title="([^"]+)")?\n(.*?)^```$', re.MULTILINE | re.DOTALL)
STATUS = re.compile(r"# exit status (\d)")
DEADLINE_S = 400


def blocks_of(page: str) -> list[tuple[str, str, str]]:
    """Language, file and text of every block of a page of the docs."""
    return [(m[1], m[2] or "", m[3]) for m in BLOCK.finditer((ROOT / "docs" / page).read_text())]


@pytest.fixture
def clean_copy(tmp_path: Path) -> Iterator[Path]:
    """What git knows of, what `make setup` has made of it, and the same virtual environment."""
    listed = subprocess.run(
        ["git", "ls-files", "-co", "--exclude-standard"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    made = [*ROOT.glob("*/**/__pycache__/*"), *ROOT.glob("*/**/*.qlf"), *ROOT.glob("bridge/prolog/*.so")]
    for name in (*listed.stdout.splitlines(), *(str(file.relative_to(ROOT)) for file in made)):
        file = tmp_path / name
        if (ROOT / name).is_file() and not name.startswith(("tests/", ".venv/", "build/")):
            file.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, file)
    (tmp_path / ".venv").symlink_to(ROOT / ".venv")
    yield tmp_path


def runs(text: str, cwd: Path) -> str:
    """Run a block's commands, each to its exit status; all that they show, without colours."""
    shown = ""
    for command in re.sub(r"\\\n\s*", " ", text).splitlines():
        done = subprocess.run(
            # Their process id is the same in all commands of a page.
            ["bash", "-c", command.replace("$$", "tutorial")],
            cwd=cwd, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL,
            text=True, timeout=DEADLINE_S, check=False,
        )  # fmt: skip
        expected = STATUS.search(command)
        assert done.returncode == (int(expected[1]) if expected else 0), f"{command}\n{done.stdout}"
        shown += done.stdout
    return re.sub(r"\x1b\[[0-9;]*m", "", shown)
