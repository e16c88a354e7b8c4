"""Turns that bring a regular or round part of a target back onto itself, though hardly the whole."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.machined_parts import circle, drilled, surface_of
from geometry.model import TARGETS, Model, find_target, load_model
from geometry.near_symmetries import UNCHANGED_SHARE, near_symmetries
from geometry.own_axes import TOLERANCE_SHARE
from geometry.rotation import matrix_of
from geometry.symmetries import symmetry_of
from geometry.turns import RIGHT_TURNS_DEG, ROUND_SHARE, right_turns, round_axes, turns_about_round_axes

ENOUGH, MOST = ROUND_SHARE, UNCHANGED_SHARE
LESS = 0.5 * ENOUGH
LUG = np.array([[0.02, -0.01], [0.04, -0.01], [0.04, 0.01], [0.02, 0.01]])


def turned(model: Model, angle_deg: float, place: tuple[float, float]) -> bool:
    """Whether a turn about the z axis through a place (x, y) is among those of a model."""
    point = np.array([[*place, 0.0]])
    return any(
        one.rotation_vector == pytest.approx([0.0, 0.0, np.radians(angle_deg)], abs=1e-9)
        and np.abs(one.apply(point) - point).max() < 1e-3
        for one in right_turns(model)
    )


def test_an_eight_sided_body_is_turned_by_an_eighth_about_its_own_middle() -> None:
    beam = np.array([[0.03, -0.004], [0.3, -0.004], [0.3, 0.004], [0.03, 0.004]])
    solids = [drilled(circle(0.05, 8), [], 0.0, 0.06), drilled(beam, [], 0.02, 0.03)]
    model = Model.of_surface("probe", surface_of(solids))
    assert all(turned(model, angle, (0.0, 0.0)) for angle in (45.0, 90.0, 135.0, 180.0))


def test_what_changes_nothing_is_no_turn_and_each_is_there_once() -> None:
    cube = load_model(find_target("cube"))
    turns = right_turns(cube)
    assert 0 < len(turns) < 3 * len(RIGHT_TURNS_DEG)
    every = [*symmetry_of(cube).turns, *turns]
    apart = [
        np.abs(one.matrix - other.matrix).max() for k, one in enumerate(every) for other in every[k + 1 :]
    ]
    assert min(apart) > 0.05


def test_a_disc_is_not_turned_about_its_axis() -> None:
    disc = Model.of_surface("disc", surface_of([drilled(circle(0.05, 96), [], 0.0, 0.02)]))
    assert not any(turned(disc, angle, (0.0, 0.0)) for angle in RIGHT_TURNS_DEG)
    assert right_turns(disc)


def test_turns_are_small_and_large_ones_and_those_onto_lugs_that_look_alike() -> None:
    thirds = [matrix_of(np.radians([0.0, 0.0, 120.0 * k]))[:2, :2] for k in range(3)]
    lugs = [*[LUG @ third.T for third in thirds], 0.3 * LUG - [0.02, 0.0]]
    solids = [drilled(circle(0.05, 48), [], -0.02, 0.0), *[drilled(lug, [], 0.0, 0.03) for lug in lugs]]
    model = Model.of_surface("disc", surface_of(solids))
    alike = [one for one in near_symmetries(model) if abs(one.rotation_vector[2]) > 1.0]
    turns = turns_about_round_axes(model)
    angles = np.abs(np.degrees([one.rotation_vector[2] for one in turns]))
    assert len(alike) == 2
    assert all(any(one is turn for turn in turns) for one in alike)
    assert (angles.min(), angles.max()) == pytest.approx((3.0, 180.0))


def test_parts_that_are_not_round_have_none() -> None:
    assert turns_about_round_axes(load_model(find_target("satellite"))) == ()


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
    loosely = TOLERANCE_SHARE * model.diameter
    turns: dict[float, Iterator[float]] = {}

    def share(_points: object, _cloud: object, reach: float) -> float:
        told = nearly if reach == loosely else exactly
        one = next(turns.setdefault(reach, iter(())), None)
        if one is None:
            turns[reach] = iter(told)
            one = next(turns[reach])
        return one

    monkeypatch.setattr("geometry.turns._share", share)
    monkeypatch.setattr("geometry.turns._share_by_chance", lambda *_: 0.0)
    axes = round_axes.__wrapped__(model)
    assert bool(axes) == found


@pytest.mark.parametrize("origin", [(0.0, 0.0, 0.0), (0.05, 0.05, 0.0), (0.03, -0.01, 0.06), (0.4, 0.0, 0.1)])
def test_the_axis_of_a_cup_is_that_of_its_rims_wherever_handle_and_origin_are(
    origin: tuple[float, float, float],
) -> None:
    handle = np.array([[0.045, -0.01], [0.09, -0.01], [0.09, 0.01], [0.045, 0.01]])
    solids = [drilled(circle(0.05, 48), [], 0.0, 0.1), drilled(handle, [], 0.03, 0.07)]
    cup = Model.of_surface("cup", surface_of(solids))
    moved = replace(cup, vertices=cup.vertices - np.array(origin))
    ((axis, centre),) = round_axes(moved)
    np.testing.assert_array_equal(axis, [0.0, 0.0, 1.0])
    np.testing.assert_allclose((centre + origin)[:2], 0.0, atol=1e-6)


def test_a_plate_full_of_small_blocks_is_not_round() -> None:
    """Turned by any angle most of its lines come to lie near some line, as they do wherever they are."""
    places = [(x, y) for x in np.linspace(-0.095, 0.095, 20) for y in np.linspace(-0.07, 0.07, 15)]
    block = 0.003 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    solids = [drilled(block + place, [], 0.0, 0.005) for place in places]
    model = Model.of_surface("heat sink", surface_of(solids))
    points = model.vertices @ matrix_of(np.array([0.0, 0.0, 0.37])).T
    away = np.linalg.norm(points[:, None] - model.vertices, axis=2).min(axis=1)
    assert (away < TOLERANCE_SHARE * model.diameter).mean() > ROUND_SHARE
    assert round_axes(model) == ()
