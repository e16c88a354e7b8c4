"""The report of a real session as a browser shows it: wide, on a phone, in the dark."""

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.report.browser import Browser, chromium
from tests.report.viewers import view_of
from tests.session.scenes import small
from tests.session.serving import served

pytestmark = pytest.mark.slow

FITS = "document.documentElement.scrollWidth <= window.innerWidth"
TABLES = "[...document.querySelectorAll('.why .scroll, #choice .scroll')]"
TABLES_FIT = f"{TABLES}.every(one => one.scrollWidth <= one.clientWidth)"


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Run folder of a short session."""
    chromium()
    out = tmp_path_factory.mktemp("session") / "run"
    never = ("--threshold", "0.000001", "--max-iterations", "3", "--quiet")
    done = served("--out", out, "--scenario", small(), "--seed", "2", *never)
    assert done.returncode == 3, done.stderr
    return out


@pytest.mark.parametrize(("width", "dark"), [(1200, False), (390, False), (390, True)])
def test_nothing_is_cut_off_and_nothing_overlaps(run: Path, width: int, dark: bool) -> None:
    with Browser(width, 900, dark) as page:
        page.open((run / "report.html").as_uri())
        page.value('document.querySelectorAll("details").forEach(one => one.open = true)')
        assert page.value(FITS) and page.value(TABLES_FIT)
        boxes = "[...document.querySelectorAll('.told h3, .settings, .dial, .numbers div')]"
        overlapping = f"""{boxes}.some((one, i, all) => all.slice(i + 1).some(other => {{
            const [a, b] = [one, other].map(each => each.getBoundingClientRect())
            const beside = a.left >= b.right - 1 || b.left >= a.right - 1
            return !(beside || a.top >= b.bottom - 1 || b.top >= a.bottom - 1)
        }}))"""
        assert page.value(overlapping) is False
        dark_there = "getComputedStyle(document.body).backgroundColor.match(/\\d+/g)[0] < 60"
        assert page.value(dark_there) is dark
        names = "document.querySelectorAll('.candidates tbody th')"
        page.value(f"{names}.forEach(one => one.append(' lamp 7'.repeat(24)))")
        assert page.value(FITS) and page.value(TABLES_FIT)


@pytest.fixture(scope="module")
def approach(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Run folder of an approach of three hold points."""
    chromium()
    out = tmp_path_factory.mktemp("approach") / "run"
    ranges = ("--first-range", "0.8", "--contact-range", "0.5")
    scene = ("--approach", *ranges, "--scenario", small("approach"), "--seed", "3")
    done = served(*scene, "--out", out, "--quiet")
    assert done.returncode in (0, 3), done.stderr
    return out


@pytest.fixture(scope="module")
def approach_view(approach: Path) -> Iterator[str]:
    """Address of its live page."""
    with view_of(approach) as address:
        yield address


@pytest.mark.parametrize(("width", "dark"), [(1200, False), (390, True)])
def test_an_approach_is_a_strip_in_the_report_and_live(
    approach: Path, approach_view: str, width: int, dark: bool
) -> None:
    held = len(json.loads((approach / "result.json").read_text())["planned_holds_m"])
    with Browser(width, 900, dark) as page:
        page.open((approach / "report.html").as_uri())
        assert page.value(FITS)
        assert page.value('document.querySelectorAll(".strip > li").length') == held > 1
        page.open(approach_view)
        page.until('document.querySelector("#approach .strip") != null')
        assert page.value('document.querySelectorAll("#approach .strip > li").length') == held
        assert page.value('document.querySelectorAll("#approach .supported").length') >= 1
        assert page.value('document.querySelectorAll("#choice .scroll").length') == 2
        assert page.value(FITS) and page.value(TABLES_FIT)
        page.open("about:blank#left")


def test_each_image_has_its_edges_and_its_reasons(run: Path) -> None:
    with Browser() as page:
        page.open((run / "report.html").as_uri())
        for number in (1, 2, 3):
            step = f'document.querySelectorAll(".step")[{number - 1}]'
            assert page.value(f'{step}.querySelector("[href=\\"#image-i{number}-edges\\"]") != null')
            page.value(f'{step}.querySelector("details").open = true')
            why = page.value(f'{step}.querySelector("details").innerText')
            assert "expected" in why and "seen" in why and "The five best of" in why
            assert page.value(f'{step}.querySelectorAll(".why tbody tr").length') == 5 + 2
        assert "Unfavourable" in page.value('document.querySelector(".glossary").textContent')
