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

from bridge.mocks import MockImageServer, MockVisionServer, mock_image_server, mock_vision_server
from tests.session.command import DEADLINE_S, ROOT, start_controller
from tests.session.serving import KEEPING, served

pytestmark = pytest.mark.slow

__all__ = ["mock_image_server", "mock_vision_server"]

COLOUR = re.compile(r"\x1b\[[0-9;]*m")
PASSING = re.compile(r"wide|narrow|\d+\.\d s")
CLEARED = re.compile(r"\r(?:\x1b\[(\d+)A)?\x1b\[J\r")


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


def shown(written: str) -> tuple[list[str], list[list[str]]]:
    """The lines that stay on the terminal, and what stood below them and was cleared, without colours."""
    stay: list[str] = [""]
    below: list[list[str]] = []
    at = 0
    text = COLOUR.sub("", written)
    for clear in [*CLEARED.finditer(text), None]:
        first, *others = text[at : clear.start() if clear else len(text)].split("\n")
        stay[-1] += first
        stay += others
        if clear:
            lines = int(clear[1] or 0) + 1
            below.append(stay[-lines:])
            stay[-lines:] = [""]
            at = clear.end()
    return stay, below


def test_no_word_is_broken_on_a_narrow_terminal(tmp_path: Path) -> None:
    options = ("--seed", "3", "--threshold", "0.001", "--max-iterations", "2", "--explain", "--no-report",
               *KEEPING)  # fmt: skip
    wide = in_a_terminal(300, *options, "--out", tmp_path / "wide")
    narrow = in_a_terminal(80, *options, "--out", tmp_path / "narrow")
    assert COLOUR.search(wide) and COLOUR.search(narrow)
    lines = {name: shown(text)[0] for name, text in (("wide", wide), ("narrow", narrow))}
    assert max(map(len, lines["wide"])) > 110
    assert all(len(line) <= 80 or len(line.split()) == 1 for line in lines["narrow"])  # a path stays whole
    words = [re.sub(PASSING, "", " ".join(lines[name])).split() for name in lines]
    assert words[0] == words[1]


def test_a_session_is_a_table_with_what_is_done_now_below_it(
    mock_vision_server: MockVisionServer, mock_image_server: MockImageServer, tmp_path: Path
) -> None:
    for op in ("capture", "estimate"):  # one that is answered between two looks is not seen below
        mock_vision_server.delay(op, 0.3)
    written = in_a_terminal(
        80, "--vision-server", mock_vision_server.endpoint, "--image-server", mock_image_server.endpoint,
        "--threshold", "0.000001", "--max-iterations", "4", "--no-report", "--out", tmp_path / "run",
    )  # fmt: skip
    stay, below = shown(written)
    head = next(number for number, line in enumerate(stay) if line.startswith(" image left right top"))
    assert "" not in stay[: stay.index(next(line for line in stay if line.startswith("  translation")))]
    rows = [line for line in stay[head:] if re.match(r" i\d ", line)]
    assert [row.split()[0] for row in rows] == ["i1", "i2", "i3", "i4"]
    assert all({"keep", "discard"} & set(row.split()) for row in rows)
    assert len({re.search(r"keep|discard", row).start() for row in rows}) == 1  # type: ignore[union-attr]
    assert all(len(line) < 80 for line in stay[head:] if line.startswith(" "))
    assert all(len(block) == 2 and max(map(len, block)) < 80 for block in below)
    doing = [" ".join(block) for block in below]
    # The first only where a server is slow.
    doings = "starting|listening to|taking|finding|looking at|dropping|waiting for"
    assert all(re.search(doings, words) for words in doing)
    assert any(re.search(r" i[2-4] .*\d s, at most (\d+ min )?\d+ s left$", words) for words in doing)
    assert not any(line.endswith(" left") or "waiting for" in line for line in stay)  # nothing of it stays


def test_on_a_narrow_terminal_the_times_are_not_cut_off(
    mock_vision_server: MockVisionServer, mock_image_server: MockImageServer, tmp_path: Path
) -> None:
    for op in ("capture", "estimate"):
        mock_vision_server.delay(op, 1.3)
    written = in_a_terminal(
        60, "--vision-server", mock_vision_server.endpoint, "--image-server", mock_image_server.endpoint,
        "--threshold", "0.000001", "--max-iterations", "2", "--no-report", "--out", tmp_path / "run",
    )  # fmt: skip
    below = shown(written)[1]
    assert all(max(map(len, block)) < 60 for block in below)
    waiting = [block[0].rstrip() for block in below if "waiting for" in block[0]]
    assert any("waiting for the image, 1 s" in line for line in waiting)
    assert all(re.search(r"\d s$", line) for line in waiting), waiting
    assert all(re.search(r"\d s( left)?$", block[1]) for block in below), below


def test_after_a_second_it_is_said_what_is_waited_for(tmp_path: Path) -> None:
    endpoint = f"ipc://{tmp_path / 'nobody'}"
    dry = start_controller("--image-server", endpoint, "--dry-run")  # waits as long, meanwhile
    session = in_a_terminal(80, "--image-server", endpoint, "--out", tmp_path / "run")
    assert any("waiting for the image server to start, 2 s" in " ".join(block) for block in shown(session)[1])
    _, said = dry.communicate(timeout=DEADLINE_S)
    assert dry.returncode == 4
    assert f"Nobody has listened at {endpoint} for 5 s." in said


def test_no_table_where_the_cursor_cannot_move_or_nothing_is_wanted(tmp_path: Path) -> None:
    options = (*KEEPING, "--seed", "3", "--no-report", "--out")
    dumb = in_a_terminal(80, *options, tmp_path / "dumb", TERM="dumb")
    quiet = in_a_terminal(80, *options, tmp_path / "quiet", "--quiet")
    for written in (dumb, quiet):
        assert not re.search(r"\x1b\[\d*[AJ]", written)
        assert "Pose found" in written
    assert "merit" in dumb.partition("Pose found")[0]  # lines, as in a file
    assert not quiet.partition("Pose found")[0].strip("\x1b[]0123456789m;\n ")


def test_errors_are_broken_between_words_too() -> None:
    said = COLOUR.sub("", in_a_terminal(60, "--controller", "wizard"))
    assert max(map(len, said.splitlines())) <= 60
    assert "is neither a file nor one of auto_exposed, " in " ".join(said.replace("ERROR:", "").split())


def test_no_colour_where_none_is_wanted(
    mock_vision_server: MockVisionServer, mock_image_server: MockImageServer, tmp_path: Path
) -> None:
    assert COLOUR.search(in_a_terminal(80, "--dry-run", *KEEPING))
    assert "\x1b" not in in_a_terminal(80, "--dry-run", *KEEPING, NO_COLOR="1")
    mock_vision_server.delay("capture", 0.3)  # something stands below, and is cleared
    session = in_a_terminal(
        80, "--vision-server", mock_vision_server.endpoint, "--image-server", mock_image_server.endpoint,
        "--max-iterations", "2", "--no-report", "--out", tmp_path / "run", NO_COLOR="1",
    )  # fmt: skip
    assert CLEARED.search(session) and not COLOUR.search(session)


def test_the_result_is_on_standard_output_however_quiet(tmp_path: Path) -> None:
    done = served("--seed", "3", "--out", tmp_path / "run", "--no-report", "--quiet")
    assert done.stderr == ""
    assert done.stdout.startswith("Pose found after ")
    assert "translation" in done.stdout
    assert not COLOUR.search(done.stdout)
    one = served("--seed", "3", "--out", tmp_path / "one", "--no-report", "--quiet", "--max-iterations", "1")
    assert "after 1 image, 1 kept" in one.stdout


def test_who_reads_only_the_beginning_ends_no_session(tmp_path: Path) -> None:
    out = tmp_path / "run"
    options = " ".join(("--seed 3 --no-report --quiet --json", *KEEPING))
    command = f"swipl {ROOT / 'main.pl'} {options} --out {out} | head -1"
    done = subprocess.run(
        ["bash", "-o", "pipefail", "-c", command],
        check=False,
        capture_output=True,
        text=True,
        timeout=DEADLINE_S,
    )
    assert (done.stdout, done.stderr, done.returncode) == ("{\n", "", 0)
