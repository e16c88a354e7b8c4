"""A written page, looked through: that it stands alone, that its structure is sound, what it says."""

import json
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

from report.page import write_report

VOID = {"meta", "link", "input", "br", "img"}


class Page(HTMLParser):
    """Checks that tags nest, and gathers ids, addresses and texts."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.ids: list[str] = []
        self.loads: list[str] = []
        self.uses: list[str] = []
        self.labelled_by: list[str] = []
        self.unnamed: list[str] = []
        self.words: list[str] = []
        self.feed(html)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        if "id" in given:
            self.ids.append(str(given["id"]))
        for key in ("src", "href", "data", "poster", "action"):
            if key in given and tag != "a":
                (self.uses if tag == "use" else self.loads).append(str(given[key]))
        if "aria-labelledby" in given:
            self.labelled_by.append(str(given["aria-labelledby"]))
        if given.get("role") == "img" and not given.get("aria-label"):
            self.unnamed.append(tag)
        assert tag != "script"
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open[-1:] != ["style"]:
            self.words.append(data)

    @property
    def text(self) -> str:
        """All text, white space folded."""
        return " ".join(" ".join(self.words).split())


def page_of(folder: Path) -> Page:
    """Write and check the page of a run folder."""
    html = write_report(folder).read_text(encoding="utf-8")
    page = Page(html)
    assert html.startswith("<!DOCTYPE html>") or html.lstrip().startswith("<!DOCTYPE html>")
    assert all(address.startswith("data:") for address in page.loads)
    assert not re.search(r"@import|url\((?!#)", html)
    assert all(use.removeprefix("#") in page.ids for use in page.uses)
    assert set(page.labelled_by) <= set(page.ids)
    assert len(page.ids) == len(set(page.ids))
    assert page.unnamed == []
    return page


def changed(folder: Path, **fields: Any) -> None:
    """Change fields of a run folder's result.json."""
    path = folder / "result.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | fields))
