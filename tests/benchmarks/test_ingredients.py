"""What a row of an ingredient counts, and that what is to be left out is."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from unittest.mock import patch

import numpy as np
import pytest

from benchmarks.ingredients import MEASURES, ROWS, WHOLE, summary
from vision_server.prediction.belief import Belief
from vision_server.serve import prediction, surprises


def table(trusted: float) -> np.ndarray:
    """Outcomes of eight scenes with two seeds; one session has no fault that happened."""
    out = np.tile([1.0, 0.5, trusted, 0.0, 3.0], (8, 2, 1))
    out[3, 1] = np.nan
    return out


def test_a_row_says_what_the_whole_is_ahead_of_it() -> None:
    told = summary("surprise", table(1.0), table(0.25))
    assert told["sessions"] == 15
    assert told["trusted"] == 0.25
    assert told["trusted_ahead"] == [0.75, 0.75, 0.75]
    assert told["images_ahead"] == [0.0, 0.0, 0.0]
    assert summary("surprise", table(1.0)[:2], table(0.25)[:2])["trusted_ahead"] == [0.75, None, None]


def test_the_whole_is_compared_with_nothing() -> None:
    told = summary(WHOLE, table(1.0), table(1.0))
    assert not any(key.endswith("_ahead") for key in told)
    assert set(MEASURES) <= set(told)


@pytest.mark.parametrize("row", ROWS)
def test_a_row_names_a_strategy_and_parts_that_there_are(row: str) -> None:
    controller, patches = ROWS[row]
    assert controller == "informed" or Path(controller).is_file()
    assert row == WHOLE or controller != "informed" or patches
    with ExitStack() as patched:
        for place, name, instead in patches:
            assert callable(getattr(place, name))
            patched.enter_context(patch.object(place, name, instead))


def test_what_is_switched_off_says_nothing() -> None:
    instead = {place: what for _, patches in ROWS.values() for place, _, what in patches}
    assert instead[Belief](None, np.ones((3, 5))).tolist() == [0.0, 0.0, 0.0]
    assert instead[prediction](None, None, [], 0)[:32] == ()
    assert instead[surprises](None, "i2") == surprises.Surprise()
