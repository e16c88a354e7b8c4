"""Each test that docs/promises.md names exists."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PAGE = (ROOT / "docs" / "promises.md").read_text()
NAMED = sorted(set(re.findall(r"`(tests/[\w/.]+)::(\w+)`", PAGE)))


def test_each_promise_has_a_test() -> None:
    rows = [line for line in PAGE.splitlines() if line.startswith("| ") and not line.startswith("| ---")]
    promises = [row for row in rows if row != "| promise | test |"]
    assert len(promises) > 40
    assert [row for row in promises if not re.search(r"\| `tests/\S+::\w+`[^|]* \|$", row)] == []


@pytest.mark.parametrize(("file", "name"), NAMED)
def test_the_test_exists(file: str, name: str) -> None:
    pattern = rf"^def {name}\(" if file.endswith(".py") else rf"^test\({name}\b"
    assert re.search(pattern, (ROOT / file).read_text(), re.MULTILINE)
