"""How far kernels are compiled, as it is shown on a terminal."""

import os
import pty
import re
import subprocess
import sys
from pathlib import Path

import pytest

from numerics.warming import compiled, kernels

SOURCE = """
from numerics.kernels import kernel

@kernel()
def first(x):
    return x

@kernel(
    inline="always",
)
def _second(x):
    return x

def plain(x):
    return x
"""
SCRIPT = """
import sys, time
from pathlib import Path
from numerics.warming import warming
root = Path(sys.argv[1])
with warming("camera", "room", root=root):
    (root / "room" / "__pycache__" / "maths.first-4.py311.nbi").touch()
    time.sleep(1.5)
"""


@pytest.fixture
def room(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A package of two kernels, of which none is compiled."""
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    (tmp_path / "room" / "__pycache__").mkdir(parents=True)
    (tmp_path / "room" / "maths.py").write_text(SOURCE)
    return tmp_path


def test_kernels_and_what_is_compiled_of_them_have_the_same_names(room: Path) -> None:
    assert kernels(["room"], room) == {("maths", "first"), ("maths", "_second")}
    assert compiled(["room"], room) == set()
    (room / "room" / "__pycache__" / "maths._second-9.py311.nbi").touch()
    (room / "room" / "__pycache__" / "maths._second-9.py311.1.nbc").touch()
    assert compiled(["room"], room) == {("maths", "_second")}


def test_where_numba_was_told_to_keep_them_they_are_found(
    room: Path, monkeypatch: pytest.MonkeyPatch, tmp_path_factory: pytest.TempPathFactory
) -> None:
    elsewhere = tmp_path_factory.mktemp("kept")
    (elsewhere / "maths.first-4.py311.nbi").touch()
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(elsewhere))
    assert compiled(["room"], room) == {("maths", "first")}


def test_a_terminal_shows_how_many_are_done_and_what_is_left(room: Path, root: Path) -> None:
    ours, theirs = pty.openpty()
    command = [sys.executable, "-c", SCRIPT, str(room)]
    environment = os.environ | {"TERM": "xterm", "COLUMNS": "80", "PYTHONPATH": str(root)}
    with subprocess.Popen(command, stderr=theirs, env=environment, cwd=root) as process:
        os.close(theirs)
        shown = b""
        while True:
            try:
                shown += os.read(ours, 65536)
            except OSError:
                break
    os.close(ours)
    assert process.returncode == 0
    text = re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", shown.decode())
    assert "kernels of the camera" in text and "1/2" in text and "2/2" in text and "left" in text


def test_no_word_of_it_goes_into_a_file(room: Path, root: Path) -> None:
    command = [sys.executable, "-c", SCRIPT, str(room)]
    done = subprocess.run(command, capture_output=True, cwd=root, check=True)
    assert done.stdout == done.stderr == b""
