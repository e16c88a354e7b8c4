"""What a terminal shows: whole words, colours only where they are wanted, the result on standard output."""

import fcntl
import os
import pty
import re
import struct
import subprocess
import termios
from pathlib import Path

import pytest

from tests.session.command import DEADLINE_S, ROOT, controller

pytestmark = pytest.mark.slow

COLOUR = re.compile(r"\x1b\[[0-9;]*m")
PASSING = re.compile(r"wide|narrow|\d+\.\d s|waiting for the \w+ to answer \"\w+\" \.\.\.")


def in_a_terminal(columns: int, *options: str | Path, **environment: str) -> str:
    """What `swipl main.pl` with these options writes on a terminal that is so wide."""
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
    session = subprocess.Popen(
        ["swipl", str(ROOT / "main.pl"), *map(str, options)],
        stdin=theirs, stdout=theirs, stderr=theirs, env=os.environ | {"TERM": "xterm"} | environment,
    )  # fmt: skip
    os.close(theirs)
    written = b""
    while True:
        try:
            written += os.read(ours, 65536)
        except OSError:  # nobody has the other end any more
            break
    os.close(ours)
    session.wait(DEADLINE_S)
    return written.decode().replace("\r\n", "\n")


def test_no_word_is_broken_on_a_narrow_terminal(tmp_path: Path) -> None:
    options = ("--seed", "3", "--threshold", "0.001", "--max-iterations", "2", "--explain", "--no-report")
    wide = in_a_terminal(300, *options, "--out", tmp_path / "wide")
    narrow = in_a_terminal(80, *options, "--out", tmp_path / "narrow")
    assert COLOUR.search(wide) and COLOUR.search(narrow)
    lines = {name: COLOUR.sub("", text).splitlines() for name, text in (("wide", wide), ("narrow", narrow))}
    assert max(map(len, lines["wide"])) > 110
    assert all(len(line) <= 80 or len(line.split()) == 1 for line in lines["narrow"])  # a path stays whole
    words = [re.sub(PASSING, "", " ".join(lines[name])).split() for name in lines]
    assert words[0] == words[1]


def test_errors_are_broken_between_words_too() -> None:
    said = COLOUR.sub("", in_a_terminal(60, "--controller", "wizard"))
    assert max(map(len, said.splitlines())) <= 60
    assert "is neither a file nor one of auto_exposed, " in " ".join(said.replace("ERROR:", "").split())


def test_no_colour_where_none_is_wanted() -> None:
    assert COLOUR.search(in_a_terminal(80, "--dry-run"))
    assert "\x1b" not in in_a_terminal(80, "--dry-run", NO_COLOR="1")


def test_the_result_is_on_standard_output_however_quiet(tmp_path: Path) -> None:
    done = controller("--seed", "3", "--out", tmp_path / "run", "--no-report", "--quiet")
    assert done.stderr == ""
    assert done.stdout.startswith("Pose found after ")
    assert "translation" in done.stdout
    assert not COLOUR.search(done.stdout)
    one = controller(
        "--seed", "3", "--out", tmp_path / "one", "--no-report", "--quiet", "--max-iterations", "1"
    )
    assert "after 1 image, 1 kept" in one.stdout


def test_who_reads_only_the_beginning_ends_no_session(tmp_path: Path) -> None:
    out = tmp_path / "run"
    command = f"swipl {ROOT / 'main.pl'} --seed 3 --out {out} --no-report --quiet --json | head -1"
    done = subprocess.run(
        ["bash", "-o", "pipefail", "-c", command],
        check=False,
        capture_output=True,
        text=True,
        timeout=DEADLINE_S,
    )
    assert (done.stdout, done.stderr, done.returncode) == ("{\n", "", 0)
