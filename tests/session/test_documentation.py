"""What README and docs say can be done is there, and runs."""

import re
import shlex
from pathlib import Path

import pytest

from tests.session.command import ROOT, controller

PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)#]+)[^)]*\)", page.read_text()):
        if "://" not in target:
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
        assert controller("--help").returncode == 0
        return
    done = controller(*options, "--out", tmp_path / "run", cwd=ROOT)
    assert done.returncode in ((0, 3) if "--approach" in options else (0,)), done.stderr
    assert (tmp_path / "run" / "report.html").stat().st_size > 10_000
