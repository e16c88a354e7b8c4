"""The table of an experiment: rows that are safe as soon as they are there, and one Parquet file of them.

A folder holds ``results.parquet``, ``rows.jsonl`` with rows that are not in it yet, and ``plan.json``. Rows
are appended to this journal with one write, so that a process that is killed loses at most what it was
writing; now and then the journal is merged into the Parquet file, which is replaced as a whole.
"""

import fcntl
import json
import os
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

import msgspec
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from bridge.errors import BadInput, DeviceError
from bridge.whole_file import replaced
from experiments.description import DESCRIPTION, OURS, agreed, read_description
from experiments.kinds import COLUMNS, KINDS, Row

RESULTS, JOURNAL, LOCK = "results.parquet", "rows.jsonl", ".lock"
LEAST_MERGED = 10_000  # rows in the journal; then half of the table's, so that merging costs little in all
SYNC_S = 2.0  # between two waits for the disk: what a power failure may cost
FAILED = ("failed", "deadline")
ORDER = ("controller", "stack", "target", "scenario", "condition", "pose", "seed")
TYPES = {str: pa.string(), int: pa.int64(), float: pa.float64()}


def schema_of(kind: str) -> pa.Schema:
    """Columns of the table of a kind of cells."""
    return pa.schema([(name, TYPES[type_]) for name, type_ in {**COLUMNS, **KINDS[kind].columns}.items()])


class ResultsTable:
    """The table of a folder, written by one process at a time.

    Parameters
    ----------
    folder : made when it is not there.
    description : of the plan, with its settings.
    version : of the code that computes the rows.
    again : cells that failed are computed once more.

    Raises
    ------
    BadInput : the folder cannot be used, is in use, or holds rows of other settings, of another version, or
        of files that say something else now.
    """

    def __init__(
        self, folder: Path, description: Mapping[str, Any], version: str, again: bool = False
    ) -> None:
        self.folder = folder
        self._schema = schema_of(description["settings"]["kind"])
        try:
            folder.mkdir(parents=True, exist_ok=True)
            _check_is_ours(folder)
            self._lock = os.open(folder / LOCK, os.O_RDWR | os.O_CREAT, 0o644)
        except OSError as error:
            raise BadInput(f"Cannot use the folder {folder}: {error.strerror}.") from None
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(self._lock)
            raise BadInput(f"Another run writes to {folder}.", "Wait, or name another folder.") from None
        try:
            if not (folder / DESCRIPTION).exists() and (folder / RESULTS).exists():
                raise BadInput(f"{folder} holds {RESULTS} but no {DESCRIPTION}.", "Name another folder.")
            self.description = agreed(folder, description, version, partial(_check_changed, folder, again))
            self._journal = os.open(folder / JOURNAL, os.O_RDWR | os.O_CREAT, 0o644)
            self._open_journal()
        except BaseException:
            os.close(self._lock)
            raise

    def _open_journal(self) -> None:
        rows, self._safe = _journal_rows(self.folder)
        self._pending = len(rows)
        try:
            os.ftruncate(self._journal, self._safe)
        except OSError as error:
            raise DeviceError(f"Cannot write to {self.folder}: {error.strerror}.") from None
        self._merged = 0
        file = self.folder / RESULTS
        if file.exists():
            self._merged = _checked_results(file, self._schema).metadata.num_rows
        self._synced = time.monotonic()

    def finished(self, without_failed: bool = False) -> set[int]:
        """Keys of the cells that have a row; nothing else of the table is read."""
        file = self.folder / RESULTS
        keys: set[int] = set()
        if file.exists():
            found = pq.read_table(file, columns=["key", "status"] if without_failed else ["key"])
            if without_failed:
                found = found.filter(pc.invert(pc.is_in(found["status"], pa.array(FAILED))))
            keys.update(found["key"].to_numpy().tolist())
        for row in _journal_rows(self.folder)[0]:
            if without_failed and row["status"] in FAILED:
                keys.discard(row["key"])
            else:
                keys.add(row["key"])
        return keys

    def append(self, rows: Sequence[Row]) -> None:
        """Add rows; they are safe when this returns.

        Raises
        ------
        DeviceError : the disk is full, or takes nothing for another reason. What was there before stays.
        """
        data = b"".join(msgspec.json.encode(row) + b"\n" for row in rows)
        try:
            written = 0
            while written < len(data):
                written += os.pwrite(self._journal, data[written:], self._safe + written)
            if time.monotonic() - self._synced > SYNC_S:
                os.fsync(self._journal)
                self._synced = time.monotonic()
        except OSError as error:
            raise self._refused(error) from None
        self._safe += len(data)
        self._pending += len(rows)
        if self._pending >= max(LEAST_MERGED, self._merged // 2):
            self.merge()

    def merge(self) -> None:
        """Bring the journal into the Parquet file, sorted by cell; of a cell's rows the last counts."""
        if self._pending == 0 and (self.folder / RESULTS).exists():
            return
        try:
            table = read_rows(self.folder, self._schema)
            metadata = {"lights-and-camera": json.dumps(self.description)}
            with replaced(self.folder / RESULTS) as new:
                pq.write_table(table.replace_schema_metadata(metadata), new, compression="zstd")
                with new.open("rb") as written:
                    os.fsync(written.fileno())
            os.ftruncate(self._journal, 0)
        except OSError as error:
            raise self._refused(error) from None
        self._merged, self._pending, self._safe = table.num_rows, 0, 0

    def _refused(self, error: OSError) -> DeviceError:
        with suppress(OSError):  # a torn line is left out when it is read
            os.ftruncate(self._journal, self._safe)
        rows = self._merged + self._pending
        return DeviceError(
            f"Cannot write to {self.folder}: {error.strerror}. The {rows} rows so far are safe.",
            "Make room, and run the same command again: it continues.",
        )

    def close(self) -> None:
        """Let another process have it."""
        os.close(self._journal)
        os.close(self._lock)


def _check_is_ours(folder: Path) -> None:
    """Raise BadInput for a folder that something else is in already."""
    names = {file.name for file in folder.iterdir()}
    strange = sorted(name for name in names if not name.startswith("."))
    if strange and names.isdisjoint((RESULTS, JOURNAL, DESCRIPTION)):
        raise BadInput(
            f"{folder} is in use for something else (it holds {strange[0]}).", "Name a new folder as --out."
        )


def _check_changed(folder: Path, again: bool, axis: str, name: str) -> None:
    """Raise BadInput where rows stay of what a name on an axis stood for before."""
    rows = read_rows(folder)
    rows = rows.filter(pc.equal(rows[axis.removesuffix("s")], name))
    failed = pc.all(pc.is_in(rows["status"], pa.array(FAILED))).as_py()
    if rows.num_rows and not (again and failed):
        raise BadInput(
            f"{folder} holds rows of the {axis.removesuffix('s')} {name!r} as it was; it has been changed.",
            "All of them failed: --again computes them once more." if failed
            else "Rows of both are not compared: name another folder, or change it back.",
        )  # fmt: skip


def _checked_results(file: Path, schema: pa.Schema) -> pq.ParquetFile:
    """The Parquet file, with these columns; none of its rows is read."""
    try:
        results = pq.ParquetFile(file)
    except (OSError, pa.ArrowInvalid) as error:
        raise BadInput(f"{file} is no Parquet table: {str(error).splitlines()[0]}") from None
    for field in schema:
        if field.name not in results.schema_arrow.names:
            raise BadInput(f"{file} has no column {field.name}.", OURS)
        _cast(pa.array([], results.schema_arrow.field(field.name).type), field, file)
    return results


def _cast(column: Any, field: pa.Field, file: Path) -> Any:
    """A column of a file, an array or chunked, as one of the table."""
    try:
        return column.cast(field.type)
    except (pa.ArrowInvalid, pa.ArrowNotImplementedError):
        raise BadInput(f"{file} has a column {field.name} that is not of {field.type}.", OURS) from None


def _journal_rows(folder: Path) -> tuple[list[Row], int]:
    """Rows of the journal and how many bytes they are; a line that was torn is not among them."""
    try:
        data = (folder / JOURNAL).read_bytes()
    except FileNotFoundError:
        return [], 0
    end = data.rfind(b"\n") + 1
    decoder = msgspec.json.Decoder(dict[str, Any])
    rows: list[Row] = []
    safe = 0
    for line in data[:end].splitlines(keepends=True):
        try:
            rows.append(decoder.decode(line))
        except msgspec.DecodeError:  # a hole where the disk was full, or the power failed
            break
        safe += len(line)
    return rows, safe


def read_rows(folder: Path, schema: pa.Schema | None = None) -> pa.Table:
    """All rows of an experiment, also while it runs; sorted by cell, one for each.

    Raises
    ------
    BadInput : no experiment there, or one that cannot be read.
    """
    if schema is None:
        schema = schema_of(read_description(folder)["settings"]["kind"])
    # The journal first: what is merged meanwhile is then found twice, not never.
    try:
        journal = pa.Table.from_pylist(_journal_rows(folder)[0], schema=schema)
    except (pa.ArrowInvalid, pa.ArrowTypeError, OverflowError) as error:
        said = str(error).splitlines()[0]
        raise BadInput(f"{folder / JOURNAL} holds what is no row: {said}.", OURS) from None
    file = folder / RESULTS
    table = journal
    if file.exists():
        merged = _checked_results(file, schema).read(columns=schema.names)
        columns = [_cast(merged[field.name], field, file) for field in schema]
        table = pa.concat_tables([pa.table(columns, schema=schema), journal])
    if journal.num_rows:
        last = (
            table.append_column("row", pa.array(range(table.num_rows)))
            .group_by("key", use_threads=False)
            .aggregate([("row", "max")])["row_max"]
        )
        table = table.take(last)
        table = table.take(pc.sort_indices(table, [(name, "ascending") for name in ORDER]))
    return table
