"""Commands of the Python programs: in a process as users start them, and in that of the tests."""

import contextlib
import io
import os
import runpy
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any, TypeAlias
from unittest import mock

from bridge.command_line import run_command

ROOT = Path(__file__).resolve().parent.parent
DEADLINE_S = 240.0
Done: TypeAlias = "subprocess.CompletedProcess[str]"


def command(program: str, *words: object) -> Done:
    """`python -m PROGRAM WORDS` in this process: what it writes, and its exit status."""
    spoken = list(map(str, words))
    commands = import_module(f"{program}.__main__").COMMANDS
    return _done([program, *spoken], lambda: run_command(program, "", commands, spoken))


def report(*words: object) -> Done:
    """`python -m report WORDS` in this process."""
    from report.__main__ import main

    spoken = ["report", *map(str, words)]
    with mock.patch.object(sys, "argv", spoken):
        return _done(spoken, main)


def module(name: str, *words: object) -> Done:
    """`python -m NAME WORDS` of a module that is a program by itself, in this process."""
    before, sys.argv = sys.argv, [name, *map(str, words)]
    programs = (name, f"{name}.__main__")
    imported = {each: sys.modules.pop(each) for each in programs if each in sys.modules}  # by another test
    try:
        return _done(sys.argv, lambda: runpy.run_module(name, run_name="__main__", alter_sys=True))
    finally:
        sys.argv = before
        sys.modules.update(imported)


@contextlib.contextmanager
def started(words: Sequence[str], **options: Any) -> "Iterator[subprocess.Popen[Any]]":
    """A process, as Popen starts it; a test that fails ends it, and does not wait for it."""
    with subprocess.Popen(words, **options) as process:
        try:
            yield process
        finally:
            process.kill()  # nothing where it has ended


def _done(words: list[str], run: Callable[[], object]) -> Done:
    """What is written meanwhile, and the exit status: what is returned, if that is one, or exited with."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            returned = run()
            status = returned if isinstance(returned, int) else 0
        except SystemExit as end:  # of argparse
            status = int(end.code or 0)
    return subprocess.CompletedProcess(words, status, out.getvalue(), err.getvalue())


def process(program: str, *words: object, env: Mapping[str, str] | None = None) -> Done:
    """The same in a process of its own, as a user starts it."""
    return subprocess.run(
        [sys.executable, "-m", program, *map(str, words)],
        cwd=ROOT, env=os.environ | (env or {}), stdin=subprocess.DEVNULL, capture_output=True, text=True,
        timeout=DEADLINE_S, check=False,
    )  # fmt: skip
