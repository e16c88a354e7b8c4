"""Commands of the Python programs: in a process as users start them, and in that of the tests."""

import contextlib
import io
import os
import runpy
import subprocess
import sys
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import TypeAlias

from bridge.command_line import run_command

ROOT = Path(__file__).resolve().parent.parent
DEADLINE_S = 240.0
Done: TypeAlias = "subprocess.CompletedProcess[str]"


def command(program: str, *words: object) -> Done:
    """`python -m PROGRAM WORDS` in this process: what it writes, and its exit status."""
    out, err = io.StringIO(), io.StringIO()
    spoken = list(map(str, words))
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            status = run_command(program, "", import_module(f"{program}.__main__").COMMANDS, spoken)
        except SystemExit as end:  # of argparse
            status = int(end.code or 0)
    return subprocess.CompletedProcess([program, *spoken], status, out.getvalue(), err.getvalue())


def module(name: str, *words: object) -> Done:
    """`python -m NAME WORDS` of a module that is a program by itself, in this process."""
    out, err = io.StringIO(), io.StringIO()
    argv, sys.argv = sys.argv, [name, *map(str, words)]
    imported = sys.modules.pop(name, None)  # by another test
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            try:
                runpy.run_module(name, run_name="__main__", alter_sys=True)
                status = 0
            except SystemExit as end:
                status = int(end.code or 0)
    finally:
        sys.argv = argv
        if imported is not None:
            sys.modules[name] = imported
    return subprocess.CompletedProcess([name, *map(str, words)], status, out.getvalue(), err.getvalue())


def process(program: str, *words: object, env: Mapping[str, str] | None = None) -> Done:
    """The same in a process of its own, as a user starts it."""
    return subprocess.run(
        [sys.executable, "-m", program, *map(str, words)],
        cwd=ROOT, env=os.environ | (env or {}), stdin=subprocess.DEVNULL, capture_output=True, text=True,
        timeout=DEADLINE_S, check=False,
    )  # fmt: skip
