"""docs/tutorial.md is followed literally, in a clean copy of the project: what it writes, runs and shows."""

import re
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parent.parent
BLOCK = re.compile(r'^```(\w+)(?: title="([^"]+)")?\n(.*?)^```$', re.MULTILINE | re.DOTALL)
STATUS = re.compile(r"# exit status (\d)")
DEADLINE_S = 400


def blocks() -> list[tuple[str, str, str]]:
    """Language, file and text of every block of the page."""
    return [(m[1], m[2] or "", m[3]) for m in BLOCK.finditer((ROOT / "docs" / "tutorial.md").read_text())]


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


def test_the_tutorial_goes_as_it_says(clean_copy: Path) -> None:
    shown = ""
    for language, file, text in blocks():
        if language == "sh":
            shown = runs(text, clean_copy)
        elif language == "text":
            missing = [line for line in text.splitlines() if line.strip() not in shown]
            assert not missing, f"{missing} is not in\n{shown}"
        else:
            assert (clean_copy / file).is_file(), f"{file} is written before it is there"
            (clean_copy / file).write_text(text)


def test_every_block_is_one_that_is_followed() -> None:
    kinds = [(language, bool(file)) for language, file, _ in blocks()]
    assert {("sh", False), ("text", False), ("prolog", True)} == set(kinds)
    assert kinds.count(("sh", False)) >= 8


def test_what_it_ends_with_is_the_example() -> None:
    code = [text for language, _, text in blocks() if language == "prolog"][-1]
    example = (ROOT / "examples" / "bracket.pl").read_text()

    def clauses(text: str) -> str:
        return "\n".join(line for line in text.splitlines() if line and not line.startswith("%"))

    assert clauses(code) == clauses(example)
