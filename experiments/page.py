"""The page of the results so far: one file, every row in it, drawn by the browser that opens it."""

from __future__ import annotations

import base64
import json
import time
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, FileSystemLoader, Template
from markupsafe import Markup

from bridge.errors import DeviceError
from bridge.whole_file import replaced
from experiments.comparison import Grid, differences_grid, head, strategies_grid
from experiments.description import read_description
from experiments.outcomes import Outcomes, outcomes_of
from experiments.table import read_rows
from experiments.version import ROOT

PAGE = "results.html"
REFRESH_S = 10  # of a page of an experiment that runs


def write_page(folder: Path, running: bool) -> Path:
    """Write the page of an experiment; where it is.

    Parameters
    ----------
    folder : of the table.
    running : the page then loads itself again now and then.

    Raises
    ------
    BadInput : no experiment there.
    DeviceError : the page cannot be written.
    """
    description = read_description(folder)
    table = read_rows(folder)
    outcomes = outcomes_of(table, description["settings"]["kind"], description["controllers"])
    grids: list[Grid] = []
    if table.num_rows:
        grids = [strategies_grid(outcomes), differences_grid(outcomes)]
    text = _template().render(
        colours=Markup((ROOT / "report" / "colours.css").read_text(encoding="utf-8")),  # as of a report
        title=f"Experiment {description['plan']}",
        head=head(description, table.num_rows),
        when=time.strftime("%Y-%m-%d %H:%M:%S"),
        running=running,
        refresh_s=REFRESH_S,
        share=min(1.0, table.num_rows / max(1, description["cells"])),  # a plan may have shrunk
        grids=grids,
        data=_data(outcomes, table["seed"].to_numpy()),
    )
    file = folder / PAGE
    try:
        with replaced(file) as new:
            new.write_text(text, encoding="utf-8")
    except OSError as error:
        raise DeviceError(f"Cannot write {file}: {error.strerror}.") from None
    return file


@cache
def _template() -> Template:
    loader = FileSystemLoader(Path(__file__).resolve().parent)
    return Environment(loader=loader, autoescape=True).get_template("page.html.j2")


def _data(outcomes: Outcomes, seeds: np.ndarray[Any, np.dtype[np.int64]]) -> str:
    """Rows by column for the script of the page, as JSON that may stand in HTML."""
    statuses, status = np.unique(outcomes.status, return_inverse=True)
    plain = {
        "strategies": outcomes.strategies,
        "scenes": outcomes.scenes,
        "statuses": statuses.tolist(),
        "columns": {
            "strategy": _packed(outcomes.strategy_of, "<u2"),
            "scene": _packed(outcomes.scene_of, "<u4"),
            "seed": _packed(seeds, "<f8"),
            "status": _packed(status, "<u2"),
            "told": _packed(outcomes.told, "u1"),
            "images": _packed(np.nan_to_num(outcomes.columns["images"]), "<u2"),
            "rotation": _packed(outcomes.columns["rotation_deg"], "<f4"),
            "translation": _packed(100.0 * outcomes.columns["translation_fraction"], "<f4"),
            "seconds": _packed(outcomes.columns["seconds"], "<f4"),
        },
    }
    return json.dumps(plain).replace("<", "\\u003c")


def _packed(values: np.ndarray[Any, Any], kind: str) -> str:
    return base64.b64encode(values.astype(kind).tobytes()).decode("ascii")
