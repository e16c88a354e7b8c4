"""Rows of the ablation: each leaves out something that is there."""

from inspect import Parameter, signature

import pytest

from benchmarks.ablation import ROWS


@pytest.mark.parametrize("row", ROWS)
def test_a_row_leaves_out_what_is_there(row: str) -> None:
    assert all(hasattr(target, name) for target, name, _ in ROWS[row])


@pytest.mark.parametrize("row", ROWS)
def test_what_a_row_has_instead_is_called_alike(row: str) -> None:
    for target, name, instead in ROWS[row]:
        there = getattr(target, name)
        if callable(there):
            takes = [one.kind for one in signature(instead).parameters.values()]
            assert Parameter.VAR_POSITIONAL in takes or len(takes) == len(signature(there).parameters)
