"""Rows of the ablation: each leaves out something that is there."""

import pytest

from benchmarks.ablation import ROWS


@pytest.mark.parametrize("row", ROWS)
def test_a_row_leaves_out_what_is_there(row: str) -> None:
    assert all(hasattr(target, name) for target, name, _ in ROWS[row])
