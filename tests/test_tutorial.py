"""docs/tutorial.md is followed literally, in a clean copy of the project: what it writes, runs and shows."""

from pathlib import Path

import pytest

from tests.followed_pages import ROOT, blocks_of, clean_copy, runs

pytestmark = pytest.mark.slow

__all__ = ["clean_copy"]


def blocks() -> list[tuple[str, str, str]]:
    """Language, file and text of every block of the page."""
    return blocks_of("tutorial.md")


def test_the_tutorial_goes_as_it_says(clean_copy: Path) -> None:
    shown = ""
    for language, file, text in blocks():
        if language == "sh":
            shown = runs(text, clean_copy)
        elif language == "text":
            missing = [line for line in text.splitlines() if line.strip() not in shown]
            assert not missing, f"{missing} is not in\n{shown}"
        else:
            assert (clean_copy / file).is_file(), f"{file} is written before it is there"
            (clean_copy / file).write_text(text)


def test_every_block_is_one_that_is_followed() -> None:
    kinds = [(language, bool(file)) for language, file, _ in blocks()]
    assert {("sh", False), ("text", False), ("prolog", True)} == set(kinds)
    assert kinds.count(("sh", False)) >= 8


def test_what_it_ends_with_is_the_example() -> None:
    code = [text for language, _, text in blocks() if language == "prolog"][-1]
    example = (ROOT / "examples" / "bracket.pl").read_text()

    def clauses(text: str) -> str:
        return "\n".join(line for line in text.splitlines() if line and not line.startswith("%"))

    assert clauses(code) == clauses(example)
