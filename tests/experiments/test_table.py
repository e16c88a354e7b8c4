"""The table: nothing is lost, whatever ends the process that writes it."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from bridge.errors import BadInput, DeviceError
from experiments.description import DESCRIPTION
from experiments.plan import read_plan
from experiments.table import JOURNAL, RESULTS, ResultsTable, read_rows
from tests.experiments.experiment import EMPTY, plan_file


def opened(folder: Path, version: str = "v", text: str = EMPTY.format(last=20)) -> ResultsTable:
    return ResultsTable(folder / "out", read_plan(plan_file(folder, text)).description, version)


def some_rows(folder: Path, count: int = 10) -> list[dict[str, Any]]:
    plan = read_plan(plan_file(folder, EMPTY.format(last=20)))
    return [{"status": "empty", "key": c.key, **c.names()} for c in map(plan.cell, range(count))]


def test_rows_are_there_before_and_after_merging(tmp_path: Path) -> None:
    table = opened(tmp_path)
    table.append(some_rows(tmp_path))
    assert read_rows(tmp_path / "out").num_rows == 10
    table.merge()
    assert (tmp_path / "out" / JOURNAL).stat().st_size == 0
    assert read_rows(tmp_path / "out").num_rows == 10
    assert table.finished() == {row["key"] for row in some_rows(tmp_path)}


@pytest.mark.parametrize("cut", [1, 5, 30])
def test_a_torn_line_is_left_out_and_overwritten(tmp_path: Path, cut: int) -> None:
    table = opened(tmp_path)
    table.append(some_rows(tmp_path))
    table.close()
    journal = tmp_path / "out" / JOURNAL
    os.truncate(journal, journal.stat().st_size - cut)
    table = opened(tmp_path)
    assert len(table.finished()) == 9
    table.append(some_rows(tmp_path)[9:])
    assert read_rows(tmp_path / "out").num_rows == 10


def test_killed_between_the_merge_and_the_emptying_of_the_journal(tmp_path: Path) -> None:
    table = opened(tmp_path)
    table.append(some_rows(tmp_path))
    journal = (tmp_path / "out" / JOURNAL).read_bytes()
    table.merge()
    table.close()
    (tmp_path / "out" / JOURNAL).write_bytes(journal)
    assert read_rows(tmp_path / "out").num_rows == 10


def test_of_two_rows_of_a_cell_the_last_counts(tmp_path: Path) -> None:
    table = opened(tmp_path)
    first = some_rows(tmp_path, 1)
    table.append([{**first[0], "status": "failed"}])
    assert table.finished(without_failed=True) == set()
    table.merge()
    assert table.finished(without_failed=True) == set()
    table.append(first)
    table.merge()
    assert read_rows(tmp_path / "out")["status"].to_pylist() == ["empty"]


def test_another_version_is_refused(tmp_path: Path) -> None:
    opened(tmp_path).close()
    with pytest.raises(BadInput, match="holds rows of version v; this is w"):
        opened(tmp_path, version="w")


def test_another_threshold_is_refused_and_more_seeds_are_not(tmp_path: Path) -> None:
    opened(tmp_path).close()
    opened(tmp_path, text=EMPTY.format(last=50)).close()
    with pytest.raises(BadInput, match=r"holds cells with threshold = None; this plan says 0\.5"):
        opened(tmp_path, text=EMPTY.format(last=20) + "threshold = 0.5\n")


CHANGING = """kind = "empty"
controllers = ["a"]
targets = ["cube", "mine.cao"]
scenarios = ["nominal", "mine.toml"]
[[conditions]]
name = "dim"
ambient_scale = {ambient}
"""
CUBE = Path(__file__).resolve().parents[2] / "targets" / "cube.cao"


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ("mine.cao", "target 'mine'"),
        ("mine.toml", "(target|scenario) 'mine'"),  # how the target looks, too
        ("plan.toml", "condition 'dim'"),
    ],
)
def test_what_is_another_than_in_the_rows_is_refused(tmp_path: Path, changed: str, said: str) -> None:
    def opened_with(edition: int, again: bool = False) -> ResultsTable:
        texts = {"mine.cao": CUBE.read_text(), "mine.toml": "", "plan.toml": CHANGING.format(ambient=0.5)}
        another = (
            CHANGING.format(ambient=edition) if changed == "plan.toml" else f"{texts[changed]}# {edition}\n"
        )
        for file, text in (texts | {changed: another}).items():
            (tmp_path / file).write_text(text)
        return ResultsTable(tmp_path / "out", read_plan(tmp_path / "plan.toml").description, "v", again)

    opened_with(1).close()
    table = opened_with(2)  # there are no rows
    cells = read_plan(tmp_path / "plan.toml").cells()
    failed = [{**cell.names(), "status": "failed", "key": cell.key} for cell in cells]
    table.append(failed)
    table.close()
    with pytest.raises(BadInput, match=f"{said} as it was; it has been changed. All of them failed: --again"):
        opened_with(3)
    table = opened_with(3, again=True)
    table.append([{**row, "status": "empty"} for row in failed])
    table.close()
    opened_with(3).close()
    with pytest.raises(BadInput, match=f"{said} as it was; it has been changed. Rows of both"):
        opened_with(4, again=True)


def test_what_a_plan_no_longer_names_is_still_told(tmp_path: Path) -> None:
    opened(tmp_path, text='kind = "empty"\ncontrollers = ["a", "b"]\ntargets = "cube"\n').close()
    table = opened(tmp_path, text='kind = "empty"\ncontrollers = ["b"]\ntargets = "fixture"\n')
    assert table.description["sources"]["controllers"] == {"a": "a", "b": "b"}
    assert table.description["sources"]["targets"] == {"cube": "cube", "fixture": "fixture"}


def test_another_format_is_refused(tmp_path: Path) -> None:
    opened(tmp_path).close()
    file = tmp_path / "out" / DESCRIPTION
    file.write_text(json.dumps(json.loads(file.read_text()) | {"format": 99}))
    with pytest.raises(BadInput, match="has format 99; this version reads format 1"):
        opened(tmp_path)


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"cells": None}, r"plan.json: expected `int`, got `null` in \[cells\]"),
        ({"settings": {"kind": "dance"}}, "plan.json: there is no kind 'dance'"),
    ],
)
def test_a_description_that_was_changed_is_refused(
    tmp_path: Path, changed: dict[str, object], said: str
) -> None:
    opened(tmp_path).close()
    file = tmp_path / "out" / DESCRIPTION
    file.write_text(json.dumps(json.loads(file.read_text()) | changed))
    with pytest.raises(BadInput, match=said):
        read_rows(tmp_path / "out")


def test_what_is_no_row_is_refused(tmp_path: Path) -> None:
    opened(tmp_path).close()
    (tmp_path / "out" / JOURNAL).write_text('{"key": "a"}\n')
    with pytest.raises(BadInput, match=r"rows.jsonl holds what is no row"):
        read_rows(tmp_path / "out")


def test_a_file_that_is_no_table_is_refused(tmp_path: Path) -> None:
    opened(tmp_path).close()
    (tmp_path / "out" / RESULTS).write_text("something else")
    with pytest.raises(BadInput, match="is no Parquet table"):
        opened(tmp_path)


@pytest.mark.parametrize("lost", ["status", "key"])
def test_a_table_without_one_of_its_columns_is_refused(tmp_path: Path, lost: str) -> None:
    table = opened(tmp_path)
    table.append(some_rows(tmp_path, 1))
    table.merge()
    table.close()
    file = tmp_path / "out" / RESULTS
    whole = pq.read_table(file)
    pq.write_table(whole.drop_columns([lost]), file)
    with pytest.raises(BadInput, match=f"has no column {lost}"):
        opened(tmp_path)
    place = whole.column_names.index(lost)
    pq.write_table(whole.set_column(place, lost, pa.array([[lost]])), file)
    with pytest.raises(BadInput, match=f"has a column {lost} that is not of"):
        opened(tmp_path)


def test_one_writer_at_a_time(tmp_path: Path) -> None:
    table = opened(tmp_path)
    with pytest.raises(BadInput, match="Another run writes to"):
        opened(tmp_path)
    table.close()
    opened(tmp_path).close()


def test_a_full_disk_loses_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    table = opened(tmp_path)
    rows = some_rows(tmp_path)
    table.append(rows[:5])
    whole = os.pwrite

    def full(descriptor: int, data: bytes, place: int) -> int:
        if len(data) > 40:
            return whole(descriptor, data[:40], place)
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "pwrite", full)
    with pytest.raises(DeviceError, match=r"No space left on device\. The 5 rows so far are safe"):
        table.append(rows[5:])
    monkeypatch.undo()
    assert read_rows(tmp_path / "out").num_rows == 5
    table.append(rows[5:])
    assert read_rows(tmp_path / "out").num_rows == 10


def test_a_missing_package_is_said_with_its_remedy() -> None:
    program = (
        "import sys; sys.modules['pyarrow'] = None;"
        "sys.argv = ['experiments', 'run', 'plan.toml', '--out', 'x'];"
        "from experiments.__main__ import main; sys.exit(main())"
    )
    ran = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert ran.returncode == 2
    assert ran.stderr == (
        "experiments: the table of results needs the package pyarrow; "
        "install it: pip install 'lights-and-camera[experiments]'\n"
    )


def test_a_folder_of_something_else_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "result.json").write_text("{}")
    with pytest.raises(BadInput, match=r"in use for something else \(it holds result.json\)"):
        opened(tmp_path)
    (tmp_path / "out" / "result.json").unlink()
    opened(tmp_path).close()
    opened(tmp_path).close()
