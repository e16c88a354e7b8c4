"""Cells to rows, in the process of a worker."""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from bridge.errors import LightsAndCameraError
from experiments.kinds import KINDS, Row
from experiments.plan import Cell
from experiments.version import code_version

if TYPE_CHECKING:
    from experiments.worker import Worker

_warm = threading.local()


class OtherVersion(Exception):  # noqa: N818  # it crosses processes by its name
    """A worker that has other code than the engine."""


def warm_worker(keep: Path | None) -> Worker:
    """This thread's worker, made by its first cell."""
    known: tuple[Path | None, Worker] | None = getattr(_warm, "worker", None)
    if known is None or known[0] != keep:
        from experiments.worker import Worker  # loads numba and all that computes

        _warm.worker = known = keep, Worker(keep)
    return known[1]


def check_version(expected: str) -> None:
    """Raise OtherVersion in a process whose code is not the engine's."""
    if code_version() != expected:
        raise OtherVersion(code_version())


def rows_of(cells: Sequence[Cell], version: str, keep: Path | None = None) -> list[Row]:
    """Compute cells one after the other.

    A cell that cannot be computed is a row that says so; it never ends the others.

    Raises
    ------
    OtherVersion : this process has other code than `version`.
    """
    check_version(version)
    return [row_of(cell, keep) for cell in cells]


def timed_rows(cells: Sequence[Cell], version: str, keep: Path | None) -> tuple[list[Row], float]:
    """The same, and how many seconds they took."""
    began = time.perf_counter()
    return rows_of(cells, version, keep), time.perf_counter() - began


def row_of(cell: Cell, keep: Path | None = None) -> Row:
    """The row of a cell."""
    began = time.perf_counter()
    kind = KINDS[cell.settings.kind]
    try:
        found = kind.run(cell, warm_worker(keep))
    except LightsAndCameraError as error:
        found = {"status": "failed", "message": str(error)}
    except Exception as error:
        found = {"status": "failed", "message": f"{type(error).__name__}: {error}"}
    found.pop("holds" if "holds" not in kind.columns else "", None)
    took = time.perf_counter() - began
    return {"seconds": took, **found, **cell.names(), "cell_seconds": took, "key": cell.key}


def died_row(cell: Cell) -> Row:
    """The row of a cell at which workers died."""
    return {
        "status": "failed",
        "message": "the worker's process died at this cell, again and again",
        **cell.names(),
        "key": cell.key,
    }
