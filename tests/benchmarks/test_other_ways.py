"""Models the other way round: of each scene the true one first, and what no image tells from it left out."""

import pytest

from benchmarks import other_ways
from benchmarks.other_ways import counted, rows
from vision_server.trust.other_hand import WAYS


@pytest.fixture(autouse=True)
def _one_scene_of_a_shape(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(other_ways, "SCENARIOS", ("nominal",))


def test_a_cube_is_the_same_every_way() -> None:
    (told,) = rows("cube", 1)
    assert (told["scene"], told["way"]) == ("nominal cube", [1, 1, 1])
    assert told["true"]
    assert told["right"]


def test_a_bracket_is_held_against_its_mirrors(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(other_ways, "WAYS", WAYS[2:4])  # of all, one mirrored and one turned
    true, *others = rows("angle", 1)
    assert true["true"]
    assert true["right"]
    assert others
    assert not any(one["true"] for one in others)
    assert all(one["way"] in ([1, 1, -1], [1, -1, -1]) for one in others)


@pytest.mark.parametrize(("right", "score", "what"), [
    (True, 0.95, "trusted and right"), (False, 0.95, "trusted and wrong"), (True, 0.9, "right"),
])  # fmt: skip
def test_what_is_trusted_is_counted_by_whether_it_is_right(right: bool, score: float, what: str) -> None:
    count = counted({"right": right, "score": score})
    assert count[what] == count["estimates"] == 1
    assert count["trusted and right"] + count["trusted and wrong"] == int(score > 0.94)
