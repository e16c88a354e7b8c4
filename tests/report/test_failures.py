"""Sessions that failed, were cut short or are of another version: what live page and report tell of them."""

import json
import re
import shutil
from collections.abc import Iterator
from html import unescape
from pathlib import Path

import pytest

from report.following import Follower
from report.fragments import fragments
from report.page import write_report
from tests.report.browser import Browser, chromium
from tests.report.viewers import view_of
from tests.session.scenes import small
from tests.session.serving import served

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def dark(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Run folder of a session that took one black image."""
    out = tmp_path_factory.mktemp("dark") / "run"
    lights_off = "i1: left 0, 1/240 s, f/5.6"
    one = ("--max-iterations", "1", "--instead", lights_off, "--quiet")
    done = served("--out", out, "--scenario", small("eclipse"), *one)
    assert done.returncode == 3, done.stderr
    assert "no pose" in done.stdout
    return out


def without_result(dark: Path, folder: Path) -> Path:
    """The same as a session leaves it that was killed."""
    shutil.copytree(dark, folder)
    (folder / "result.json").unlink()
    return folder


@pytest.fixture
def cut(dark: Path, tmp_path: Path) -> Path:
    """One that may be written to."""
    return without_result(dark, tmp_path / "cut")


@pytest.fixture(scope="module")
def views(dark: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, str]]:
    """Addresses of both, by the tone in which their state is told."""
    chromium()
    with view_of(dark) as bad, view_of(without_result(dark, tmp_path_factory.mktemp("cut") / "run")) as warn:
        yield {"bad": bad, "warn": warn}


def page(folder: Path) -> dict[str, str]:
    """Text of each part of the live page."""
    follower = Follower(folder)
    try:
        state = follower.look()
        assert state is not None
        parts = fragments(folder, state, "token")
    finally:
        follower.close()
    return {name: " ".join(unescape(re.sub("<[^>]*>", " ", html)).split()) for name, html in parts.items()}


def test_no_pose_is_told_with_what_may_help(dark: Path) -> None:
    advice = json.loads((dark / "result.json").read_text())["advice"]
    assert any("image is black" in one for one in advice) and any("--max-iterations" in one for one in advice)
    for told in (page(dark)["status"], (dark / "report.html").read_text()):
        assert "No pose" in told and "Its image gave no pose." in told
        assert f"What may help: {'; '.join(advice)}" in told
    assert page(dark)["pose"] == "Pose No pose."


def test_a_session_that_was_killed_can_be_resumed_and_is_so_told(cut: Path) -> None:
    told = page(cut)
    assert told["status"].startswith("interrupted No pose It ended without a result;")
    assert f"swipl main.pl --resume {cut} goes on with it" in told["status"]
    assert "since" not in told["status"]
    assert "capture(i1,settings([0,0,0],0.004167,5.6))" in told["events"]


@pytest.mark.parametrize(
    ("file", "pattern", "instead", "words"),
    [
        ("session.pl", r"version\(1\)", "version(99)", "empty, cut or changed"),
        ("history.pl", r"choose\(settings\(\[[1-9]", "choose(settings([0", "was run by another version"),
    ],
)
def test_a_folder_of_another_version_is_told_in_one_line(
    cut: Path, file: str, pattern: str, instead: str, words: str
) -> None:
    text, found = re.subn(pattern, instead, (cut / file).read_text(), count=1)
    assert found
    (cut / file).write_text(text)
    told = page(cut)
    assert told["status"].startswith("interrupted Not known")
    assert words in told["status"] and "--resume" not in told["status"]
    assert told["choice"] == "Why this light? Not known."
    assert "i1, the newest image" in told["now"]  # nothing is lost


def test_a_journal_that_was_cut_in_the_middle_of_a_line_is_told_up_to_there(cut: Path) -> None:
    journal = cut / "history.pl"
    journal.write_text(re.sub(r"(?s)(choose\(settings\().*", r"\1", journal.read_text()))
    told = page(cut)
    assert told["status"].startswith("interrupted No pose It ended without a result;")
    assert told["events"].endswith("connect") and "i1, the newest image" in told["now"]


@pytest.mark.parametrize(("width", "dark_there"), [(1200, False), (390, False), (390, True)])
def test_nothing_is_cut_off(dark: Path, views: dict[str, str], width: int, dark_there: bool) -> None:
    fits = "document.documentElement.scrollWidth <= window.innerWidth"
    with Browser(width, 900, dark_there) as browser:
        browser.open((dark / "report.html").as_uri())
        assert browser.value(fits)
        assert browser.value('getComputedStyle(document.body).getPropertyValue("--tone")') == "#ff7a70"
        for tone, address in views.items():
            browser.open(address)
            browser.until('document.querySelector("#status .badge") != null')
            assert browser.value(fits)
            assert browser.value(f'document.querySelector("#status .badge.{tone}") != null')
            browser.open("about:blank#left")  # a view ends sooner when nobody looks


def test_the_report_holds_the_journal(dark: Path) -> None:
    told = (dark / "report.html").read_text()
    log = re.findall(r'<li class="(\w+)">([^<]*)</li>', told.partition('<ol class="log"')[2])
    assert [name for name, _ in log][:3] == ["connect", "choose", "capture"]
    assert "capture(i1,settings([0,0,0],0.004167,5.6))" in dict(log)["capture"]
    assert f"{len(log)} actions, and what happened meanwhile" in told


@pytest.mark.parametrize(
    ("pattern", "instead", "words"),
    [
        (r"version\(1\)", "version(99)", "empty, cut or changed"),
        (r"(?s)controller.*", "", "empty, cut or changed"),
    ],
)
def test_a_report_says_that_its_journal_cannot_be_followed(
    dark: Path, tmp_path: Path, pattern: str, instead: str, words: str
) -> None:
    folder = tmp_path / "other"
    shutil.copytree(dark, folder)
    text, found = re.subn(pattern, instead, (folder / "session.pl").read_text(), count=1)
    assert found
    (folder / "session.pl").write_text(text)
    told = write_report(folder).read_text()
    (note,) = re.findall(r'<p class="note">(Reasons and journal cannot be shown\. .*)</p>', told)
    assert words in note and 'id="journal"' not in told and "Why this light?" not in told


def test_the_report_of_a_folder_without_journal_and_images_is_written(dark: Path, tmp_path: Path) -> None:
    folder = tmp_path / "bare"
    folder.mkdir()
    shutil.copy(dark / "result.json", folder)
    told = write_report(folder).read_text()
    assert "The file images/i1.png is missing." in told and "no images/stack.toml" in told
