"""Contact sheets hold every picture and its label."""

import numpy as np
import pytest

from report.contact_sheet import contact_sheet
from report.errors import ReportError


def test_pictures_of_any_size_in_rows() -> None:
    images = [
        np.full((90, 120), 200, np.uint8),
        np.full((60, 30, 3), 100, np.uint8),
        np.zeros((90, 120), np.uint8),
    ]
    sheet = contact_sheet(images, ["a", "b\nc", "0.12 mm ± 3°"], columns=2, width_px=60)
    assert sheet.dtype == np.uint8
    assert sheet.shape[1] == 2 * 60 + 3 * 8
    assert (sheet[8 : 8 + 45, 8 : 8 + 60] == 200).all()
    assert (sheet[8 : 8 + 120, 76 : 76 + 60] == 100).all()


def test_labels_are_written_below() -> None:
    image = np.zeros((40, 200), np.uint8)
    with_text = contact_sheet([image], ["worst case"], width_px=200)
    without = contact_sheet([image], [""], width_px=200)
    assert with_text.shape == without.shape
    below = slice(8 + 40, None)
    assert (with_text[below] != without[below]).any()
    assert (with_text[: 8 + 40] == without[: 8 + 40]).all()


@pytest.mark.parametrize(
    ("count", "labels", "words"),
    [(0, [], "at least one"), (2, ["a"], "as many labels"), (1, ["a", "b"], "as many labels")],
)
def test_bad_sheets_are_refused(count: int, labels: list[str], words: str) -> None:
    with pytest.raises(ReportError, match=words):
        contact_sheet([np.zeros((4, 4), np.uint8)] * count, labels)


def test_sizes_below_one_are_refused() -> None:
    with pytest.raises(ReportError, match="at least 1"):
        contact_sheet([np.zeros((4, 4), np.uint8)], ["a"], columns=0)
