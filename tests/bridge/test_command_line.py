"""Command lines of the Python programs, as a shell uses them."""

import os
import signal
import subprocess
import sys
import time
from argparse import ArgumentParser, ArgumentTypeError
from collections.abc import Callable
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import get_args

import pytest

from bridge.command_line import (
    EXIT_READER_GONE,
    MOST_SEED,
    counted,
    listed,
    number,
    run_command,
    whole_number,
)
from bridge.errors import BadInput, DeviceError
from bridge.messages import Seed
from tests.commands import started


def test_a_reader_that_has_seen_enough_is_no_error() -> None:
    """`... | head` closes its end: no traceback, and no words."""
    program = (
        "import sys; from types import ModuleType; from bridge.command_line import run_command;"
        "command = ModuleType('x'); command.add_options = lambda parser: None;"
        "command.run = lambda options: print('word ' * 100000) or 0;"
        "sys.modules['program.commands.talk'] = command;"
        "sys.modules['program.commands'] = sys.modules['program'] = ModuleType('program');"
        "print('begun', flush=True); sys.stdin.read();"
        "sys.exit(run_command('program', 'It talks.', {'talk': 'Say much.'}, ['talk']))"
    )
    with started(
        [sys.executable, "-c", program],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as done:
        assert done.stdout is not None
        assert done.stderr is not None
        assert done.stdin is not None
        assert done.stdout.readline() == "begun\n"
        done.stdout.close()
        done.stdin.close()
        assert done.stderr.read() == ""
        assert done.wait(60) == EXIT_READER_GONE


@pytest.mark.parametrize(
    ("closing", "word", "status", "said"),
    [
        (">&-", "--version", 4, "vision_server: [Errno 9] Bad file descriptor\n"),
        (">&-", "track --help", 4, "vision_server: [Errno 9] Bad file descriptor\n"),
        ("2>&-", "--version", 0, ""),
        ("2>&-", "talk", 2, ""),
        (">&- 2>&- <&-", "--version", 4, ""),
    ],
)
def test_streams_may_be_closed(closing: str, word: str, status: int, said: str) -> None:
    line = ["sh", "-c", f'exec "$@" {closing}', "sh", sys.executable, "-m", "vision_server", *word.split()]
    done = subprocess.run(line, capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stderr) == (status, said)
    assert done.stdout.startswith("vision_server ") if status == 0 else done.stdout == ""


def opened_by_reader(pipe: Path) -> int:
    """The writing end of a named pipe, as soon as a command has come to read it."""
    for _ in range(600):
        with suppress(OSError):
            return os.open(pipe, os.O_WRONLY | os.O_NONBLOCK)
        time.sleep(0.1)
    raise TimeoutError(f"nobody reads {pipe}")


@pytest.mark.parametrize(("sent", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
@pytest.mark.parametrize(
    "words",
    [
        "vision_server check x.png --model x.cao --pose x.toml --camera",
        "image_server record x --kind frames --settings each --scenario",
        "experiments run --out x",
    ],
)
def test_a_signal_ends_a_command_without_a_word(
    tmp_path: Path, words: str, sent: signal.Signals, status: int
) -> None:
    pipe = tmp_path / "camera.toml"
    os.mkfifo(pipe)
    line = [sys.executable, "-m", *words.split(), str(pipe)]
    with started(line, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as running:
        opened = opened_by_reader(pipe)
        running.send_signal(sent)
        assert running.communicate(timeout=60) == ("", "")
    os.close(opened)
    assert running.returncode == status


@pytest.mark.parametrize(
    ("error", "status", "line"),
    [
        (BadInput("It is\n  no file.", "Give one."), 2, "program: It is no file. Give one.\n"),
        (DeviceError("It is gone."), 4, "program: It is gone.\n"),
        (FileNotFoundError(2, "No such file", "x"), 4, "program: [Errno 2] No such file: 'x'\n"),
    ],
)
def test_an_error_is_one_line_and_its_exit_status(
    error: Exception,
    status: int,
    line: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    class Command(ModuleType):
        def add_options(self, parser: object) -> None:
            """None."""

        def run(self, options: object) -> None:
            raise error

    monkeypatch.setitem(sys.modules, "program", ModuleType("program"))
    monkeypatch.setitem(sys.modules, "program.commands", ModuleType("commands"))
    monkeypatch.setitem(sys.modules, "program.commands.fail", Command("fail"))
    assert run_command("program", "It fails.", {"fail": "Do."}, ["fail"]) == status
    assert capsys.readouterr().err == line


@pytest.mark.parametrize(
    ("read", "word", "told"),
    [
        (number(0.01, 100.0), "0", "must be 0.01 to 100, not 0"),
        (whole_number(0, MOST_SEED), "-1", "must be 0 to 9223372036854775807, not -1"),
        (whole_number(1), "0", "must be at least 1, not 0"),
        (number(), "nan", "must be a finite number, not nan"),
        (number(), "x", "'x' is not a number"),
    ],
)
def test_a_number_out_of_its_bounds_is_told_them(read: Callable[[str], float], word: str, told: str) -> None:
    with pytest.raises(ArgumentTypeError) as caught:
        read(word)
    assert str(caught.value) == told


def test_seeds_are_those_of_the_messages() -> None:
    assert get_args(Seed)[1].le == MOST_SEED


def test_one_of_a_kind_is_not_in_the_plural() -> None:
    assert (counted(0, "cell"), counted(1, "cell"), counted(2, "cell")) == ("0 cells", "1 cell", "2 cells")


@pytest.mark.parametrize("program", ["bridge", "experiments", "image_server", "vision_server"])
def test_every_option_says_what_it_does(program: str) -> None:
    for name in import_module(f"{program}.__main__").COMMANDS:
        parser = ArgumentParser()
        import_module(f"{program}.commands.{name.replace('-', '_')}").add_options(parser)
        assert [action.dest for action in parser._actions if not action.help] == [], name


def test_so_many() -> None:
    assert (counted(1, "image"), counted(2, "image")) == ("1 image", "2 images")


def test_a_list_of_commands_is_as_wide_as_the_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "50")
    lines = listed({"one": "Do " + 9 * "one thing ", "other": "Do all-that-is-long."}).splitlines()
    assert max(map(len, lines)) <= 50
    assert [line[:18].strip() for line in lines] == ["one", *(len(lines) - 2) * [""], "other"]
