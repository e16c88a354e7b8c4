"""The cells that decide: where strategies differ most, with the reports of their sessions."""

from __future__ import annotations

import os
from contextlib import closing
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pyarrow as pa

from bridge.errors import BadInput
from bridge.stopping import Stopping
from experiments.comparison import Grid
from experiments.computing import row_of, warm_worker
from experiments.outcomes import Outcomes
from experiments.plan import Cell, Condition, PlanScene, PlanSettings

SHOWN = 20  # cells in the list, chosen by hand
CELLS = "cells"


def deciding_rows(outcomes: Outcomes, table: pa.Table) -> list[tuple[int, int]]:
    """Pairs of rows of the table, one right and one wrong in the same scene with the same seed.

    Scenes where the shares of right poses differ most between strategies come first.
    """
    strategies = range(len(outcomes.strategies))
    shares = np.stack([np.nanmean(_padded(outcomes.matrix(s, outcomes.right)), axis=1) for s in strategies])
    spread = np.nanmax(shares, axis=0) - np.nanmin(shares, axis=0)
    seeds = table["seed"].to_numpy()
    places: dict[tuple[int, int], list[int]] = {}
    for row in np.flatnonzero(spread[outcomes.scene_of] > 0.0).tolist():
        places.setdefault((int(outcomes.scene_of[row]), int(seeds[row])), []).append(row)
    found = []
    for (scene, seed), rows in places.items():
        right = [row for row in rows if outcomes.right[row]]
        wrong = [row for row in rows if not outcomes.right[row]]
        if right and wrong:
            first = min(right, key=lambda row: int(outcomes.strategy_of[row]))
            second = min(wrong, key=lambda row: int(outcomes.strategy_of[row]))
            found.append((-float(spread[scene]), scene, seed, first, second))
    return [(first, second) for *_, first, second in sorted(found)[:SHOWN]]


def deciding_grid(outcomes: Outcomes, table: pa.Table, folder: Path, link_from: Path) -> Grid:
    """The cells that decide, with links to the reports that there are."""
    rows = []
    seeds = table["seed"].to_pylist()
    for first, second in deciding_rows(outcomes, table):
        cells = [outcomes.scenes[int(outcomes.scene_of[first])], str(seeds[first])]
        for row in (first, second):
            name = outcomes.strategies[int(outcomes.strategy_of[row])]
            cells.append(f"{name} ({_outcome(outcomes, row)}){_link(table, row, folder, link_from)}")
        rows.append(cells)
    return Grid(
        "Cells that decide",
        ["scene", "seed", "right", "wrong"],
        rows,
        "Where the shares of right poses differ most between strategies. `compare --reports N` runs the first"
        " of them again and links their reports.",
    )


def make_reports(rows: list[dict[str, Any]], description: dict[str, Any], folder: Path) -> None:
    """Run cells again, with their run folders and reports under `folder`/cells."""
    keep = (folder / CELLS).resolve()
    with Stopping() as stopping, closing(warm_worker(keep)):
        for row in rows:
            cell = cell_of(row, description)
            if not _report(folder, cell.key).exists():
                with stopping.waiting():
                    row_of(cell, keep)
                stopping.heed()


def cell_of(row: dict[str, Any], description: dict[str, Any]) -> Cell:
    """The cell that a row is of.

    Raises
    ------
    BadInput : the row names something that its table does not know.
    """
    sources = description["sources"]
    try:
        condition = None
        if row["condition"] is not None:
            condition = msgspec.convert(sources["conditions"][row["condition"]], Condition)
        if row["stack"] is not None:
            place: tuple[str, ...] = (sources["stacks"][row["stack"]],)
        else:
            place = sources["targets"][row["target"]], sources["scenarios"][row["scenario"]]
        controller = sources["controllers"][row["controller"]]
    except KeyError as error:
        raise BadInput(f"The table does not say what {error} was.", "Was its plan.json changed?") from None
    unit = sources.get("units", {}).get(row["target"], "m")
    scene = PlanScene(row["stack"], row["target"], row["scenario"], place, condition, row["pose"], unit)
    settings = msgspec.convert(description["settings"], PlanSettings)
    return Cell(scene, row["controller"], controller, row["seed"], settings)


def _outcome(outcomes: Outcomes, row: int) -> str:
    degrees, share = (outcomes.columns[name][row] for name in ("rotation_deg", "translation_fraction"))
    off = "no pose" if np.isnan(degrees) else f"{degrees:.2f}°, {100 * share:.2f} %"
    return f"{outcomes.status[row]}, {off}"


def _link(table: pa.Table, row: int, folder: Path, link_from: Path) -> str:
    report = _report(folder, table["key"][row].as_py())
    if not report.exists():
        return ""
    return f" [report]({os.path.relpath(report, link_from)})"


def _report(folder: Path, key: int) -> Path:
    return folder / CELLS / f"{key:016x}" / "report.html"


def _padded(matrix: np.ndarray[Any, np.dtype[np.float64]]) -> np.ndarray[Any, np.dtype[np.float64]]:
    """A column of zeros where a scene has no outcome, so that means are defined."""
    empty = ~np.isfinite(matrix).any(axis=1)
    out = matrix.copy()
    out[empty, 0] = 0.0
    return out
