"""What the journal's reader tells of a session: to who follows it, and to its report."""

from pathlib import Path

import pytest

from report.following import Action, Journal

pytestmark = pytest.mark.slow


def told(folder: Path, every_reason: bool) -> list[Action]:
    journal = Journal(folder, every_reason)
    try:
        answer = journal.ask()
        assert not answer.problem
        assert journal.ask().actions == answer.actions  # none is told twice
    finally:
        journal.close()
    return answer.actions


def test_who_follows_is_told_the_newest_reasons_and_the_report_every_one(three_images: Path) -> None:
    newest, every = told(three_images, every_reason=False), told(three_images, every_reason=True)
    decided = ("choose", "capture", "estimate")
    assert [one.text for one in newest] == [one.text for one in every]
    assert [one.name for one in every if one.reason] == 3 * [*decided]
    assert [one.name for one in newest if one.reason] == [*decided]
    for name in decided:
        last = next(number for number, one in reversed([*enumerate(every)]) if one.name == name)
        assert newest[last] == every[last]
