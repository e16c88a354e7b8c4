"""Running experiments as a user does, and looking at their tables."""

import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

from experiments.computing import rows_of
from experiments.plan import read_plan
from experiments.table import ResultsTable, read_rows
from experiments.version import code_version
from tests.commands import Done, command

ROOT = Path(__file__).resolve().parents[2]
COMMAND = [sys.executable, "-m", "experiments"]
EMPTY = 'kind = "empty"\ncontrollers = ["a", "b"]\ntargets = ["cube"]\nseeds = "1-{last}"\n'


def plan_file(folder: Path, text: str, name: str = "plan.toml") -> Path:
    """A plan on the disk."""
    file = folder / name
    file.write_text(text, encoding="utf-8")
    return file


def started(plan: Path, out: Path, *options: str) -> "subprocess.Popen[str]":
    """`experiments run`, under way."""
    words = [*COMMAND, "run", str(plan), "--out", str(out), *options]
    return subprocess.Popen(words, cwd=ROOT, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)


def run(plan: Path, out: Path, *options: str, timeout_s: float = 300.0) -> "subprocess.CompletedProcess[str]":
    """`experiments run`, to its end."""
    words = [*COMMAND, "run", str(plan), "--out", str(out), *options]
    return subprocess.run(words, cwd=ROOT, text=True, capture_output=True, timeout=timeout_s, check=False)


def run_here(plan: Path, out: Path, *options: str) -> Done:
    """`experiments run` in the process of the tests, whose workers are processes all the same."""
    before = signal.getsignal(signal.SIGTERM)
    try:
        return command("experiments", "run", plan, "--out", out, *options)
    finally:
        signal.signal(signal.SIGTERM, before)


def computed(plan: Path, out: Path, *stacks: Path) -> Path:
    """The table of a plan, its cells computed one after the other in the process of the tests."""
    read = read_plan(plan, stacks)
    table = ResultsTable(out, read.description, code_version())
    table.append(rows_of(list(read.cells()), code_version()))
    table.merge()
    table.close()
    return out


def rows(out: Path, times: bool = False) -> list[dict[str, Any]]:
    """Rows of a table, without times unless asked for."""
    table = read_rows(out)
    kept = [name for name in table.column_names if times or not (name.endswith("_s") or "seconds" in name)]
    found: list[dict[str, Any]] = table.select(kept).to_pylist()
    return found
