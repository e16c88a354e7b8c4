"""What README and docs say can be done is there, and runs."""

import json
import os
import re
import shlex
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

from tests.commands import Done, command, module, process
from tests.session.command import ROOT, controller
from tests.session.scenes import small
from tests.session.serving import served

pytestmark = pytest.mark.slow

PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)#]+)[^)]*\)", page.read_text()):
        if "://" not in target and not target.startswith("api/"):  # pages that `make docs` makes
            assert (page.parent / target).exists(), f"{page.name} links to {target}"


def sessions() -> list[str]:
    """The sessions that README shows, as they stand there."""
    lines = (ROOT / "README.md").read_text().splitlines()
    return [line.strip() for line in lines if line.startswith("    swipl main.pl")]


def test_readme_shows_sessions() -> None:
    assert len(sessions()) >= 5


@pytest.mark.parametrize("line", [line for line in sessions() if not re.search("PATH_TO|RUN_FOLDER", line)])
def test_sessions_of_the_readme(line: str, tmp_path: Path) -> None:
    options = shlex.split(line)[2:]
    if options == ["--help"]:
        assert "--controller" in session_help()
        return
    if "--approach" in options:  # in seven hold points as any other session in one
        options += ["--scenario", str(small("approach"))]
    done = served(*options, "--out", tmp_path / "run", cwd=ROOT)
    assert done.returncode in ((0, 3) if "--approach" in options else (0,)), done.stderr
    assert (tmp_path / "run" / "report.html").stat().st_size > 10_000


def shown(start: str) -> list[tuple[str, str]]:
    """Page and text of the commands that README and docs show and that begin like this."""
    return [
        (page.name, line.strip())
        for page in PAGES
        for line in page.read_text().replace("\\\n", " ").splitlines()  # continued lines are one
        if line.startswith("    ") and line.strip().startswith(start)
    ]


@pytest.mark.parametrize(("page", "line"), shown("make "))
def test_make_has_the_targets(page: str, line: str) -> None:
    target = shlex.split(line, comments=True)[1]
    done = subprocess.run(["make", "-n", target], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, (page, done.stderr)


PROGRAMS = ("vision_server", "image_server", "bridge", "experiments")


@cache
def help_of(name: str, *words: str) -> Done:
    """What a command says of its options; many lines show the same one."""
    if name in PROGRAMS:
        return command(name, *words, "--help") if words else process(name, "--help")
    return module(name, *([] if name.startswith("benchmarks.") else words), "--help")


@pytest.mark.parametrize(("page", "line"), [*shown(".venv/bin/python -m"), *shown("python -m")])
def test_python_commands_take_the_options_that_are_shown(
    page: str, line: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    words = shlex.split(line, comments=True)
    name = words[words.index("-m") + 1]
    asked = [word for word in words[words.index("-m") + 2 :][:1] if re.fullmatch("[a-z][a-z-]*", word)]
    done = help_of(name, *asked)
    assert done.returncode == 0, (page, done.stderr)
    for option in (word.split("=")[0] for word in words if word.startswith("--")):
        assert option in done.stdout, f"{page}: {line} has {option}, which is none of\n{done.stdout}"


@cache
def session_help() -> str:
    """What `swipl main.pl` says of its options."""
    done = controller("--help")
    assert done.returncode == 0
    return done.stdout + done.stderr


@pytest.mark.parametrize(("page", "line"), shown("swipl main.pl"))
def test_session_options_that_are_shown_exist(page: str, line: str) -> None:
    for option in (word for word in shlex.split(line, comments=True) if word.startswith("--")):
        assert option in session_help(), f"{page}: {line}"


@pytest.mark.parametrize(
    ("page", "line"), [at for at in shown("swipl indigolog/run.pl") if "THEORY" not in at[1]]
)
def test_agents_that_are_shown_run(page: str, line: str) -> None:
    done = subprocess.run(
        shlex.split(line, comments=True),
        cwd=ROOT,
        input="quit\n",
        capture_output=True,
        text=True,
        timeout=240,
        check=False,
    )
    assert done.returncode == 0, (page, done.stderr)


def test_the_session_that_shows_how_a_strategy_tunes_does(tmp_path: Path) -> None:
    page = (ROOT / "docs" / "lighting.md").read_text()
    (options,) = re.findall(r"`swipl main.pl (--controller examples/other_parameters.pl [^`]*)`", page)
    done = served(*shlex.split(options), "--no-report", "--out", tmp_path / "run", cwd=ROOT)
    assert done.returncode == 0, done.stderr
    journal = (tmp_path / "run" / "history.pl").read_text()
    tuned = re.findall(r"set_parameter\((\w+),([\d.]+)\)", journal)
    assert ("refinement_scale_px", "4.0") in tuned
    assert len(tuned) > 2  # and one is taken back


def test_a_strategy_may_sense_and_hear_by_itself(tmp_path: Path) -> None:
    page = (ROOT / "docs" / "controllers.md").read_text()
    (code,) = re.findall(r"```prolog\n([^`]*exog_occurs[^`]*)```", page)
    (tmp_path / "lamp.pl").write_text(code)
    (tmp_path / "lamp.txt").write_text("71.\n")

    def session(name: str) -> str:
        done = served(
            "--controller", "lamp.pl", "--out", name, "--threshold", "0.000001", "--max-iterations", "3",
            "--no-report", cwd=tmp_path,
        )  # fmt: skip
        assert done.returncode == 3, done.stderr
        return (tmp_path / name / "history.pl").read_text()

    journal = session("shut")
    assert journal.count("read_celsius,71)") == journal.count("capture(") == 3
    (tmp_path / "door_opened").touch()
    journal = session("opened")
    assert journal.count("door_opened") == 1
    assert journal.count("capture(") <= 1
    assert not (tmp_path / "door_opened").exists()


def test_the_notebook_runs_and_finds_the_pose() -> None:
    notebook = json.loads((ROOT / "examples" / "three_lights.ipynb").read_text())
    cells = ["".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == "code"]
    done = subprocess.run(
        [sys.executable, "-c", "\n".join(cells)],
        cwd=ROOT, env=os.environ | {"MPLBACKEND": "Agg"},
        capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    error = re.search(r"true error: ([\d.]+) deg", done.stdout)
    assert error is not None, done.stdout
    assert float(error[1]) < 0.2
