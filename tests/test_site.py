"""The documentation site: its menu names every page, it builds without a warning, links lead somewhere."""

import re
import runpy
import shutil
import subprocess
import sys
import tomllib
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

import pytest

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parent.parent
PAGES = sorted(file.name for file in (ROOT / "docs").glob("*.md"))


def in_menu(entries: list[dict[str, Any]]) -> list[str]:
    """Pages of the menu, in order."""
    found: list[str] = []
    for entry in entries:
        for where in entry.values():
            found += [where] if isinstance(where, str) else in_menu(where)
    return found


class Page(HTMLParser):
    """Anchors and links of a page."""

    def __init__(self, file: Path) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.links: list[str] = []
        self.feed(file.read_text())

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if name == "id" and value:
                self.anchors.add(value)
            elif name in ("href", "src") and value:
                self.links.append(value)


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The built site, without the pages that are made from the code."""
    folder = tmp_path_factory.mktemp("site")
    shutil.copytree(ROOT / "docs", folder / "docs")
    shutil.copy(ROOT / "zensical.toml", folder)
    done = subprocess.run(
        [sys.executable, "-m", "zensical", "build", "--strict"],
        cwd=folder, capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout
    assert "No issues found" in done.stdout + done.stderr
    return folder / "build" / "site"


def test_the_menu_names_every_page_once() -> None:
    menu = in_menu(tomllib.loads((ROOT / "zensical.toml").read_text())["project"]["nav"])
    assert sorted(menu) == PAGES


def test_every_link_leads_somewhere(site: Path) -> None:
    pages = {file: Page(file) for file in site.glob("*.html")}
    assert len(pages) >= len(PAGES)
    lost, checked = [], 0
    for file, page in pages.items():
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or link.startswith("//") or parts.path.removeprefix("./").startswith("api/"):
                continue
            checked += 1
            target = (file.parent / unquote(parts.path)).resolve() if parts.path else file
            if file.name == "404.html":  # is served anywhere
                target = site / unquote(parts.path).lstrip("/") if parts.path else file
            if not target.exists() or (
                parts.fragment and target in pages and unquote(parts.fragment) not in pages[target].anchors
            ):
                lost.append(f"{file.name}: {link}")
    assert checked > 1000
    assert lost == []


def test_nothing_is_fetched_from_elsewhere(site: Path) -> None:
    for file in site.glob("*.html"):
        fetched = re.findall(r'<(?:script|link|img)[^>]*(?:src|href)="(https?:[^"]+)"', file.read_text())
        assert fetched == [], file.name


def rooms_of_the_pages() -> list[str]:
    """Rooms that are made into pages, by the Makefile."""
    told = re.search(r"^ROOMS *= (.*)$", (ROOT / "Makefile").read_text(), re.MULTILINE)
    assert told is not None
    return told[1].split()


def test_names_that_modules_export_stand_in_them_where_pdoc_looks() -> None:
    pages = runpy.run_path(str(ROOT / "setup" / "python-pages.py"))
    missing = [
        f"{module.__name__}: {name}"
        for module in pages["modules"](rooms_of_the_pages())
        for name in getattr(module, "__all__", ())
        if name not in vars(module) | getattr(module, "__annotations__", {})
    ]
    assert missing == []


def test_the_code_that_the_api_page_links_to_is_made_into_pages() -> None:
    makefile = (ROOT / "Makefile").read_text()
    rooms = set(rooms_of_the_pages())
    assert "setup/python-pages.py build/api/python $(ROOMS)" in makefile
    assert {"bridge", "geometry", "report", "session", "vision_server"} <= rooms
    made = re.findall(
        r"^room\('?([\w/]+)'?\)\.", (ROOT / "setup" / "prolog-pages.pl").read_text(), re.MULTILINE
    )
    linked = re.findall(r"\(api/prolog/([\w/]+)/index\.html\)", (ROOT / "docs" / "api.md").read_text())
    assert sorted(linked) == sorted(made)
