"""Command lines of the Python programs, as a shell uses them."""

import subprocess
import sys
from types import ModuleType

import pytest

from bridge.command_line import EXIT_READER_GONE, run_command
from bridge.errors import BadInput, DeviceError


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
    with subprocess.Popen(
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
