"""Models the other way round: of each scene the true one first, and what no image tells from it left out."""

import numpy as np
import pytest

from benchmarks.other_ways import SCENARIOS, counted, rows


def test_a_cube_is_the_same_every_way() -> None:
    told = list(rows("cube", 1))
    assert [one["scene"] for one in told if one["true"]] == [f"{scenario} cube" for scenario in SCENARIOS]
    well_lit = [one for one in told if one["scene"] == "nominal cube"]
    assert [one["way"] for one in well_lit] == [[1, 1, 1]]


def test_a_bracket_is_held_against_its_mirrors() -> None:
    told = list(rows("angle", 1))
    true, others = [one for one in told if one["true"]], [one for one in told if not one["true"]]
    assert len(true) == len(SCENARIOS)
    assert all(one["right"] for one in true)
    assert others
    assert all(np.prod(one["way"]) in (-1, 1) and one["way"] != [1, 1, 1] for one in others)


@pytest.mark.parametrize(("right", "score", "what"), [
    (True, 0.95, "trusted and right"), (False, 0.95, "trusted and wrong"), (True, 0.9, "right"),
])  # fmt: skip
def test_what_is_trusted_is_counted_by_whether_it_is_right(right: bool, score: float, what: str) -> None:
    count = counted({"right": right, "score": score})
    assert count[what] == count["estimates"] == 1
    assert count["trusted and right"] + count["trusted and wrong"] == int(score > 0.94)
