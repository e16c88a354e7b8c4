"""`python -m benchmarks` measures only what it is asked for, and nothing when it is asked how."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests.commands import module

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize(
    ("command", "status", "said"),
    [
        (["benchmarks", "--help"], 0, "edges, poses, golog, simulator, transport"),
        (["benchmarks", "edgs"], 2, "no part 'edgs'"),
        (["swipl", "benchmarks/golog.pl", "--help"], 0, "usage"),
        (["swipl", "benchmarks/golog.pl", "memory"], 2, "usage"),
    ],
)
def test_it_says_how_and_measures_nothing(command: list[str], status: int, said: str) -> None:
    if command[0] == "swipl":
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=60, check=False)
    else:
        done = module(*command)
    assert done.returncode == status, done.stderr
    assert said in done.stdout + done.stderr
    assert '"value"' not in done.stdout


@pytest.mark.slow
def test_only_the_part_that_is_named_is_measured() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks", "transport"], cwd=ROOT, capture_output=True, text=True,
        timeout=120, check=True,
    )  # fmt: skip
    lines = done.stdout.splitlines()
    assert lines
    assert all('"name": "transport/' in line for line in lines), lines


@pytest.mark.slow
def test_no_time_is_divided_by_one_of_another_machine() -> None:
    done = subprocess.run(
        ["swipl", "benchmarks/golog.pl", "smallest"], cwd=ROOT, capture_output=True, text=True, timeout=540,
        check=True,
    )  # fmt: skip
    told = [json.loads(line) for line in done.stdout.splitlines()]
    assert len(told) > 5
    within_one_run = {"us_per_step", "of_first", "of_one_fluent"}
    assert {key for one in told for key in one} <= {"name", "value", "unit"} | within_one_run
    assert {one["unit"] for one in told} == {"s"}
