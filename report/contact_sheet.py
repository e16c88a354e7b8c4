"""Many pictures on one sheet with a label under each: worst cases of a benchmark at a glance."""

import math
import unicodedata
from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from report.errors import ReportError
from report.overlay import colour

Pixels = NDArray[np.uint8]

PAPER = (24, 20, 18)
INK = (235, 235, 235)
GAP_PX = 8
LINE_PX = 18
TEXT_PX = 14
DEFAULT_WIDTH_PX = 320


def contact_sheet(
    images: Sequence[Pixels],
    labels: Sequence[str],
    columns: int | None = None,
    width_px: int = DEFAULT_WIDTH_PX,
) -> Pixels:
    """Lay pictures out in rows, each scaled to one width, with its label below.

    Parameters
    ----------
    images : uint8 pictures, (H, W) grey or (H, W, 3) BGR, of any sizes.
    labels : one text each; a line break starts a new line.
    columns : pictures in a row; by default the sheet becomes about as wide as high.
    width_px : width of each picture on the sheet.

    Returns
    -------
    (H, W, 3) BGR, uint8.

    Raises
    ------
    ReportError : no pictures, another number of labels, a picture that is not uint8, a size below 1.
    """
    if len(images) == 0:
        raise ReportError("a contact sheet needs at least one picture")
    if len(images) != len(labels):
        raise ReportError(
            f"a contact sheet of {len(images)} pictures needs as many labels, got {len(labels)}"
        )
    if width_px < 1 or (columns is not None and columns < 1):
        raise ReportError("columns and width of a contact sheet must be at least 1")
    tiles = [_tile(colour(image), label, width_px) for image, label in zip(images, labels, strict=True)]
    across = columns or math.ceil(math.sqrt(len(tiles)))
    rows = [tiles[start : start + across] for start in range(0, len(tiles), across)]
    heights = [max(len(tile) for tile in row) for row in rows]
    across = max(len(row) for row in rows)
    sheet = np.empty(
        (sum(heights) + GAP_PX * (len(rows) + 1), across * (width_px + GAP_PX) + GAP_PX, 3), np.uint8
    )
    sheet[:] = PAPER
    top = GAP_PX
    for row, height in zip(rows, heights, strict=True):
        for column, tile in enumerate(row):
            left = GAP_PX + column * (width_px + GAP_PX)
            sheet[top : top + len(tile), left : left + width_px] = tile
        top += height + GAP_PX
    return sheet


def _tile(image: Pixels, label: str, width_px: int) -> Pixels:
    height = max(1, round(image.shape[0] * width_px / image.shape[1]))
    way = cv2.INTER_AREA if width_px < image.shape[1] else cv2.INTER_CUBIC
    lines = label.splitlines() or [""]
    tile = np.empty((height + 6 + LINE_PX * len(lines), width_px, 3), np.uint8)
    tile[:] = PAPER
    tile[:height] = cv2.resize(image, (width_px, height), interpolation=way)
    for number, line in enumerate(lines):
        _write(tile, line, height + LINE_PX * (number + 1) - 2)
    return tile


def _write(tile: Pixels, text: str, baseline: int) -> None:
    """Write a line of text; OpenCV before version 5 knows ASCII only."""
    if hasattr(cv2, "FontFace"):
        cv2.putText(tile, text, (4, baseline), INK, cv2.FontFace("sans"), TEXT_PX)
        return
    words = {"°": " deg", "±": "+-", "µ": "u", "×": "x", "·": "-", "–": "-"}
    plain = unicodedata.normalize("NFKD", "".join(words.get(letter, letter) for letter in text))
    ascii_only = plain.encode("ascii", "ignore").decode()
    cv2.putText(tile, ascii_only, (4, baseline), cv2.FONT_HERSHEY_SIMPLEX, 0.42, INK, 1, cv2.LINE_AA)
