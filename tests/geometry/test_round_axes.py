"""A part is nearly round where every odd turn brings enough of it back, and none brings all."""

from collections.abc import Iterator

import pytest

from geometry import round_axes
from geometry.model import TARGETS, load_model
from geometry.near_symmetries import EXACT, TOLERANCE

ENOUGH, MOST = round_axes.ROUND, EXACT
LESS = 0.5 * ENOUGH


@pytest.mark.parametrize(
    ("nearly", "exactly", "found"),
    [
        ([ENOUGH, ENOUGH, ENOUGH], [LESS, LESS, LESS], True),
        ([ENOUGH, ENOUGH, LESS], [LESS, LESS, LESS], False),
        ([LESS, ENOUGH, ENOUGH], [LESS, LESS, LESS], False),
        ([ENOUGH, ENOUGH, ENOUGH], [LESS, LESS, MOST], False),
        ([ENOUGH, ENOUGH, ENOUGH], [MOST, LESS, LESS], False),
    ],
)
def test_every_turn_counts(
    nearly: list[float], exactly: list[float], found: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = load_model(TARGETS / "cube.cao")
    loosely = TOLERANCE * model.diameter
    turns: dict[float, Iterator[float]] = {}

    def share(_points: object, _cloud: object, reach: float) -> float:
        told = nearly if reach == loosely else exactly
        one = next(turns.setdefault(reach, iter(())), None)
        if one is None:
            turns[reach] = iter(told)
            one = next(turns[reach])
        return one

    monkeypatch.setattr(round_axes, "_share", share)
    axes = round_axes.round_axes.__wrapped__(model)
    assert bool(axes) == found
