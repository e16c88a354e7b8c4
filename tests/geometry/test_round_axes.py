"""A part is nearly round where every odd turn brings enough of it back, and none brings all."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.machined_parts import circle, drilled, surface_of
from geometry import round_axes
from geometry.model import TARGETS, Model, load_model
from geometry.near_symmetries import EXACT
from geometry.own_axes import TOLERANCE

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


@pytest.mark.parametrize("origin", [(0.0, 0.0, 0.0), (0.05, 0.05, 0.0), (0.03, -0.01, 0.06), (0.4, 0.0, 0.1)])
def test_the_axis_of_a_cup_is_that_of_its_rims_wherever_handle_and_origin_are(
    origin: tuple[float, float, float],
) -> None:
    handle = np.array([[0.045, -0.01], [0.09, -0.01], [0.09, 0.01], [0.045, 0.01]])
    solids = [drilled(circle(0.05, 48), [], 0.0, 0.1), drilled(handle, [], 0.03, 0.07)]
    cup = Model.of_surface("cup", surface_of(solids))
    moved = replace(cup, vertices=cup.vertices - np.array(origin))
    ((axis, centre),) = round_axes.round_axes(moved)
    np.testing.assert_array_equal(axis, [0.0, 0.0, 1.0])
    np.testing.assert_allclose((centre + origin)[:2], 0.0, atol=1e-6)
