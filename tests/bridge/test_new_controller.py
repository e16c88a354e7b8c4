"""What `python -m bridge new-controller` makes passes its tests as made, and what it refuses."""

import contextlib
import os
import subprocess
import sys
from pathlib import Path

import pytest

from experiments.plan import read_plan
from tests.commands import Done, command

pytestmark = pytest.mark.slow


def run(cwd: Path, root: Path, *words: str) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(
        words, cwd=cwd, env=os.environ | {"PYTHONPATH": str(root)},
        capture_output=True, text=True, timeout=240, check=False,
    )  # fmt: skip


def new(cwd: Path, name: str) -> Done:
    with contextlib.chdir(cwd):
        return command("bridge", "new-controller", name)


@pytest.fixture
def mine(tmp_path: Path) -> Path:
    done = new(tmp_path, "mine")
    assert done.returncode == 0, done.stderr
    return tmp_path / "mine"


def test_what_it_makes_passes_its_tests_as_made(mine: Path, root: Path) -> None:
    assert sorted(file.name for file in mine.iterdir()) == [
        "mine.pl",
        "mine.plt",
        "plan.toml",
        "test_mine.py",
    ]
    in_a_world = run(mine.parent, root, "swipl", "-g", "run_tests", "-t", "halt", "mine/mine.plt")
    assert in_a_world.returncode == 0, in_a_world.stderr
    assert "All 5 tests passed" in in_a_world.stderr
    against_mocks = run(mine.parent, root, sys.executable, "-m", "pytest", "-q", "mine")
    assert against_mocks.returncode == 0, against_mocks.stdout
    assert "3 passed" in against_mocks.stdout
    assert [name for name, _ in read_plan(mine / "plan.toml").controllers] == ["mine", "heuristic", "simple"]


@pytest.mark.parametrize(
    ("checkout", "session", "python"),
    [(True, "swipl main.pl", ".venv/bin/python"), (False, "lights-and-camera", "python")],
)
def test_its_files_name_the_commands_that_are_there(
    tmp_path: Path, checkout: bool, session: str, python: str
) -> None:
    if checkout:
        (tmp_path / "main.pl").touch()
    told = new(tmp_path, "mine").stdout
    for text in told, (tmp_path / "mine" / "mine.pl").read_text():
        assert f"  {session} --controller mine/mine.pl" in text
    for text in told, (tmp_path / "mine" / "plan.toml").read_text():
        assert f"  {python} -m experiments run mine/plan.toml --out mine/results" in text


def test_its_tests_fail_where_the_strategy_is_wrong(mine: Path, root: Path) -> None:
    strategy = mine / "mine.pl"
    strategy.write_text(strategy.read_text().replace("if(worth_keeping,", "if(true,"))
    in_a_world = run(mine.parent, root, "swipl", "-g", "run_tests", "-t", "halt", "mine/mine.plt")
    assert in_a_world.returncode != 0
    assert "it_drops_images_that_do_not_help" in in_a_world.stderr
    against_mocks = run(mine.parent, root, sys.executable, "-m", "pytest", "-q", "mine")
    assert "test_images_that_do_not_help_are_dropped" in against_mocks.stdout


@pytest.mark.parametrize("name", ["Mine", "2nd", "a-b", "../mine", "", "a" * 41, "mine.pl"])
def test_a_bad_name_is_refused(tmp_path: Path, name: str) -> None:
    done = new(tmp_path, name)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == (
        f"bridge: A strategy cannot be called {name!r}. "
        "Use up to 40 lower-case letters, digits and underscores, a letter first.\n"
    )
    assert list(tmp_path.iterdir()) == []


def test_a_name_that_is_taken_is_refused(mine: Path) -> None:
    kept = (mine / "mine.pl").read_text()
    again = new(mine.parent, "mine")
    assert (again.returncode, again.stderr) == (
        2, "bridge: There is a folder or file mine here already. Use another name, or remove it.\n",
    )  # fmt: skip
    assert (mine / "mine.pl").read_text() == kept
    shipped = new(mine.parent, "greedy")
    assert shipped.returncode == 2
    assert "There is a strategy greedy already" in shipped.stderr
