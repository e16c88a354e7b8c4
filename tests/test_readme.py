"""The figures of the README's table are those of the results page."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
README = (ROOT / "README.md").read_text()


def rows_of(text: str) -> list[list[str]]:
    """Cells of each row of a Markdown table, its head included."""
    lines = [line for line in text.splitlines() if line.startswith("| ") and not line.startswith("| ---")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def results() -> dict[str, dict[str, str]]:
    """What the results page tells of each strategy on shapes drawn anew, without the intervals."""
    page = (ROOT / "docs" / "results.md").read_text()
    head, *rows = rows_of(page.partition("<!-- unseen: Strategies -->")[2].partition("<!-- end -->")[0])
    return {row[0]: dict(zip(head, (cell.split(" [")[0] for cell in row), strict=True)) for row in rows}


def claimed() -> list[list[str]]:
    """The README's rows of strategies."""
    return [row for row in rows_of(README) if len(row) == 6 and "%" in row[1]]


def test_the_readme_tells_of_ours_and_of_one_auto_exposed_image() -> None:
    named = {name for row in claimed() for name in re.findall(r"`(?:--controller )?(\w+)`", row[0])}
    assert {"heuristic", "informed", "auto_exposed"} <= named


@pytest.mark.parametrize("row", claimed(), ids=lambda row: row[0])
def test_its_figures_are_those_of_the_results(row: list[str]) -> None:
    (name,) = re.findall(r"`(?:--controller )?(\w+)`", row[0])
    found = results()[name]
    assert row[1:4] == [f"{found[share]} %" for share in ("right, %", "tight, %", "trusted, %")]
    assert row[4] == f"{round(float(found['false, %']) * int(found['n']) / 100)} of {found['n']}"
    assert row[5] == f"{float(found['images']):.1f}"


def test_the_command_is_the_one_of_the_results() -> None:
    (command,) = re.findall(r"`(\.venv/bin/python -m experiments run [^`]+)`", README)
    assert command in (ROOT / "docs" / "results.md").read_text()
