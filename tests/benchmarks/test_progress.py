"""What is shown of the progress of `make bench`."""

import io
import json
from pathlib import Path

from rich.console import Console

from benchmarks.progress import measuring, remembered


def shown(file: Path, names: list[str], terminal: bool = True) -> str:
    """What two parts, measured in no time, show."""
    written = io.StringIO()
    with measuring(names, file, Console(file=written, force_terminal=terminal, width=80)) as begin:
        for name in names:
            begin(name)
    return written.getvalue()


def test_the_time_left_is_told_from_the_second_time_on(tmp_path: Path) -> None:
    file = tmp_path / "build" / "seconds.json"
    first = shown(file, ["edges", "golog"])
    assert "golog, 2 of 2" in first and "left" not in first
    assert set(remembered(file)) == {"edges", "golog"}
    file.write_text(json.dumps({"edges": 60.0, "golog": 40.0}))
    assert "about 40 s left" in shown(file, ["edges", "golog"])
    file.write_text(json.dumps({"edges": 60.0}))
    assert "left" not in shown(file, ["edges", "golog"])


def test_what_was_remembered_may_be_broken_and_a_file_shows_nothing(tmp_path: Path) -> None:
    file = tmp_path / "seconds.json"
    for text in ("{", "[]", '{"edges": "long"}'):
        file.write_text(text)
        assert remembered(file) == {}
    assert shown(file, ["edges"], terminal=False).strip() == ""
    assert set(remembered(file)) == {"edges"}
