"""Tables and pictures of a plan, renewed in a page that is written by hand.

A page holds ``<!-- PLAN: TITLE -->`` before each table and ``<!-- end -->`` after it; ``TITLE, WORDS`` keeps
the rows that begin with these words. The plan's pictures are those it shows as ``FOLDER/PLAN-NAME.png``.
"""

from __future__ import annotations

import re
import shutil
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from bridge.errors import BadInput, DeviceError
from experiments.comparison import Grid

TABLE = r"(<!-- {plan}: ([^\n]*?) -->\n).*?(<!-- end -->)"
PICTURE = r"\]\(((?:[^)\s]*/)?{plan}-([\w-]+)\.png)\)"


def renew(page: Path, plan: str, grids: Sequence[Grid], caption: str, pictures: Path) -> None:
    """Put the tables of a plan into a page, and the pictures beside it.

    Parameters
    ----------
    pictures : folder with NAME.png.

    Raises
    ------
    BadInput : the page cannot be read, has no place for the plan, or asks for what there is not.
    DeviceError : the page or a picture cannot be written.
    """
    try:
        text = page.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise BadInput(f"Cannot read the page {page}: {error}.") from None
    titles = {grid.title: grid for grid in grids}

    def table(place: re.Match[str]) -> str:
        title, _, beginning = place[2].partition(", ")
        if title not in titles:
            raise BadInput(f"{page} asks for a table {title!r}.", f"There are {', '.join(titles)}.")
        grid = titles[title]
        kept = replace(grid, rows=[row for row in grid.rows if row[0].startswith(beginning)])
        return f"{place[1]}\n{kept.table()}\n\n{caption}\n\n{place[3]}"

    found, count = re.subn(TABLE.format(plan=re.escape(plan)), table, text, flags=re.DOTALL)
    if count == 0:
        raise BadInput(
            f"{page} has no place for tables of {plan}.", f"Mark one: <!-- {plan}: Strategies -->."
        )
    try:
        for target, name in re.findall(PICTURE.format(plan=re.escape(plan)), found):
            if not (pictures / f"{name}.png").is_file():
                raise BadInput(f"{page} shows a picture {name!r}, which a comparison does not draw.")
            shutil.copyfile(pictures / f"{name}.png", page.parent / target)
        page.write_text(found, encoding="utf-8")
    except OSError as error:
        raise DeviceError(f"Cannot write {error.filename}: {error.strerror}.") from None
