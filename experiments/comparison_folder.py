"""What `experiments compare` leaves in its folder, and shows on the terminal."""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib as mpl
from rich.console import Console
from rich.table import Table as RichTable

from bridge.errors import BadInput, DeviceError
from experiments.comparison import (
    POSES,
    Grid,
    differences_grid,
    head,
    power_grid,
    scenes_grid,
    scores_grid,
    strategies_grid,
)
from experiments.deciding import deciding_grid, deciding_rows, make_reports
from experiments.description import read_description
from experiments.outcomes import outcomes_of
from experiments.plots import draw_all
from experiments.renewed import renew
from experiments.table import read_rows

MARKDOWN = "comparison.md"
WIDTH = 170  # characters, where there is no terminal
SHOWN_HERE = ("Strategies", "Paired differences", "Scores")  # on the terminal; all are in the file


def compare_table(folder: Path, out: Path, reports: int = 0, page: Path | None = None) -> None:
    """Write comparison.md and the pictures, and show the tables that answer most.

    Parameters
    ----------
    reports : so many cells that decide are run again with their reports.
    page : a page whose tables and pictures of this plan are renewed, see `renew`.

    Raises
    ------
    BadInput : no experiment there, or one without a row.
    DeviceError : the folder cannot be written.
    """
    mpl.use("Agg")
    description = read_description(folder)
    table = read_rows(folder)
    if table.num_rows == 0:
        raise BadInput(f"The experiment in {folder} has no rows yet.", "Run it for a while.")
    outcomes = outcomes_of(table, description["settings"]["kind"], description["controllers"])
    if reports:
        chosen = [row for pair in deciding_rows(outcomes, table) for row in pair][: 2 * reports]
        if chosen:  # strategies may differ nowhere
            make_reports(table.take(chosen).to_pylist(), description, folder)
    grids = [strategies_grid(outcomes), differences_grid(outcomes)]
    if outcomes.kind in POSES:
        grids += [scenes_grid(outcomes), deciding_grid(outcomes, table, folder, out), power_grid(outcomes)]
    if outcomes.kind == "estimate":
        grids.append(scores_grid(outcomes))
    grids = [grid for grid in grids if grid.rows]  # one strategy differs from no other
    caption = head(description, table.num_rows)
    try:
        out.mkdir(parents=True, exist_ok=True)
        pictures = draw_all(outcomes, caption, out) if outcomes.kind in POSES else []
        text = _markdown(description["plan"], caption, grids, pictures)
        (out / MARKDOWN).write_text(text, encoding="utf-8")
    except OSError as error:
        raise DeviceError(f"Cannot write to {out}: {error.strerror}.") from None
    if page is not None:
        renew(page, description["plan"], grids, caption, out)
    console = Console(width=None if sys.stdout.isatty() else WIDTH)
    console.print(caption, highlight=False)
    for grid in grids:
        if grid.title in SHOWN_HERE:
            console.print(_rich(grid))
    console.print(f"Written: {out / MARKDOWN} and pictures {', '.join(pictures)}", highlight=False)


def _markdown(plan: str, caption: str, grids: list[Grid], pictures: list[str]) -> str:
    shown = "\n".join(f"![{name}]({name}.svg)\n" for name in pictures)
    tables = [f"{grid.markdown()}\n{caption}\n" for grid in grids]
    return "\n".join([f"# {plan}", "", caption, "", shown, *tables])


def _rich(grid: Grid) -> RichTable:
    table = RichTable(title=grid.title, caption=grid.note)
    for heading in grid.headings:
        table.add_column(heading)
    for row in grid.rows:
        table.add_row(*row)
    return table
