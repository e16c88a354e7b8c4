"""Turns that nearly bring a wireframe back onto itself."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.cad_parts import CAD
from benchmarks.machined_parts import circle, drilled, machined, rounded, surface_of
from geometry.model import Model, find_target, load_model
from geometry.near_symmetries import near_symmetries
from geometry.own_axes import TOLERANCE_SHARE, middles_of_rings
from geometry.rotation import matrix_of
from tests.geometry.boxes import box, model_of


def test_a_turn_that_changes_nothing_is_none(tmp_path: Path) -> None:
    assert near_symmetries(box(tmp_path, 0.3, 0.2, 0.1)) == ()
    assert near_symmetries(load_model(find_target("cube"))) == ()


def test_turns_go_about_the_middle(tmp_path: Path) -> None:
    model = box(tmp_path, 0.3, 0.2, 0.1, slant=0.05)
    turns = near_symmetries(model)
    axes = {int(np.argmax(np.abs(turn.rotation_vector))) for turn in turns}
    assert axes == {0, 1, 2}
    for turn in turns:
        fixed = turn.apply(model.middle[None])[0] - model.middle
        assert np.linalg.norm(fixed) <= 0.1
        assert np.linalg.norm(turn.rotation_vector) == pytest.approx(np.pi)


def test_the_fixture_is_nearly_the_same_upside_down() -> None:
    model = load_model(find_target("fixture"))
    turn = near_symmetries(model)[0]
    assert np.degrees(turn.rotation_vector) == pytest.approx([0.0, 0.0, 180.0])
    assert turn.apply(turn.apply(model.vertices)) == pytest.approx(model.vertices, abs=1e-9)


def test_a_satellite_is_nearly_the_same_turned_over_about_the_long_axis_of_its_panels_too() -> None:
    """A few degrees more move hardly anything of what is that slender; half a turn is no small one."""
    turns = [turn.rotation_vector for turn in near_symmetries(load_model(find_target("satellite")))]
    half = [np.abs(np.degrees(turn)).round() for turn in turns if np.linalg.norm(turn) > 3.1]
    assert sorted(map(tuple, half)) == [(0.0, 0.0, 180.0), (0.0, 180.0, 0.0), (180.0, 0.0, 0.0)]


def test_a_square_side_is_turned_by_quarters(tmp_path: Path) -> None:
    turns = near_symmetries(box(tmp_path, 0.3, 0.3, 0.1, slant=0.03))
    angles = [round(float(np.degrees(np.linalg.norm(turn.rotation_vector)))) for turn in turns]
    assert 90 in angles


@pytest.mark.parametrize("teeth", [5, 12])
def test_a_dial_is_turned_by_each_of_its_marks(tmp_path: Path, teeth: int) -> None:
    angles = np.arange(4 * teeth) * 2 * np.pi / (4 * teeth)
    radius = np.tile([1.0, 1.0, 0.75, 0.75], teeth)
    radius[0] = 1.05  # the one mark that differs
    level = np.stack([radius * np.cos(angles), radius * np.sin(angles), 0 * angles], axis=1)
    around = len(angles)
    sides = [(k, (k + 1) % around, around + (k + 1) % around, around + k) for k in range(around)]
    model = model_of(tmp_path, np.concatenate([level, level + np.array([0.0, 0.0, 0.4])]), sides)
    about_z = [turn.rotation_vector for turn in near_symmetries(model) if abs(turn.rotation_vector[2]) > 0.01]
    degrees = sorted({round(float(np.degrees(np.linalg.norm(vector)))) for vector in about_z})
    assert degrees == sorted({round(360.0 * k / teeth) for k in range(1, teeth // 2 + 1)})


def wheel(folder: Path, sides: int, mark: float, missing: int = 0) -> Model:
    """A prism of this many sides about (0.2, 0.1), with a block of a size; some sides may be missing."""
    angle = 2.0 * np.pi * np.arange(sides) / sides
    ring = np.stack([np.cos(angle) + 0.2, np.sin(angle) + 0.1, 0.0 * angle], axis=1)
    corners = [np.array([x, y, z]) for z in (0.5, 0.5 + mark) for y in (0, mark) for x in (0.7, 0.7 + mark)]
    low, high = list(range(sides)), list(range(sides, 2 * sides))
    faces = [(low[k], low[(k + 1) % sides], high[(k + 1) % sides], high[k]) for k in range(sides - missing)]
    faces += [
        tuple(2 * sides + corner for corner in face) for face in ((0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4))
    ]
    return model_of(folder, np.concatenate([ring, ring + np.array([0.0, 0.0, 0.5]), corners]), faces)


@pytest.mark.parametrize("sides", [5, 6, 7, 9])
def test_a_wheel_with_a_block_is_turned_about_its_axis(tmp_path: Path, sides: int) -> None:
    """A ring of seven is not in the middle of its box, and the block moves the wireframe's centroid."""
    turns = [turn for turn in near_symmetries(wheel(tmp_path, sides, 0.6)) if abs(turn.matrix[2, 2]) > 0.99]
    degrees = {round(float(np.degrees(turn.rotation_vector[2]))) for turn in turns if turn.matrix[2, 2] > 0}
    assert {abs(angle) for angle in degrees} == {round(360.0 * k / sides) for k in range(1, sides // 2 + 1)}
    for turn in turns:
        assert turn.apply(np.array([[0.2, 0.1, 0.0]]))[0][:2] == pytest.approx([0.2, 0.1], abs=0.02)


def test_a_ring_has_its_middle_also_where_some_of_it_is_missing(tmp_path: Path) -> None:
    model = wheel(tmp_path, 9, 0.3, missing=4)
    ends = model.vertices[model.lines]
    first, *_ = middles_of_rings(ends, np.array([0.0, 0.0, 1.0]), TOLERANCE_SHARE * model.diameter)
    assert first[:2] == pytest.approx([0.2, 0.1], abs=0.01)


def drilled_plate(turn: np.ndarray, segments: int) -> Model:
    """A plate with a hole that is not in its middle, aslant in its file."""
    hole = circle(0.02, segments, (0.04, 0.01))
    vertices, triangles = drilled(rounded(0.2, 0.12, 0.01, 4), [hole], -0.01, 0.01)
    return Model.of_surface("plate", surface_of([(vertices @ matrix_of(turn).T, triangles)]))


@pytest.mark.parametrize("segments", [24, 300])
def test_a_plate_is_nearly_the_same_turned_over_however_fine_its_hole_is(segments: int) -> None:
    turns = near_symmetries(drilled_plate(np.zeros(3), segments))
    halves = {tuple(np.rint(np.abs(turn.rotation_vector / np.pi)).astype(int)) for turn in turns}
    assert halves == {(1, 0, 0), (0, 1, 0), (0, 0, 1)}


def test_a_plate_is_nearly_the_same_turned_over_whatever_stands_on_it() -> None:
    plate = Model.of_surface("plate", surface_of(machined(np.random.default_rng(90117), 40)))
    turns = near_symmetries(plate)
    halves = {tuple(np.rint(np.abs(turn.rotation_vector / np.pi)).astype(int)) for turn in turns}
    assert halves == {(1, 0, 0), (0, 1, 0), (0, 0, 1)}


def test_a_part_that_lies_aslant_in_its_file_has_the_same_turns() -> None:
    aslant = np.array([0.4, -0.7, 0.2])
    straight = {
        tuple(np.round(matrix_of(aslant) @ turn.matrix @ matrix_of(aslant).T, 2).ravel() + 0.0)
        for turn in near_symmetries(drilled_plate(np.zeros(3), 24))
    }
    found = near_symmetries(drilled_plate(aslant, 24))
    turned = {tuple(np.round(one.matrix, 2).ravel() + 0.0) for one in found}
    assert straight and straight <= turned


@pytest.mark.parametrize(("number", "teeth"), [(4, 27), (5, 40)])
def test_a_gear_is_turned_by_each_of_its_teeth_and_by_hardly_anything_else(number: int, teeth: int) -> None:
    model = Model.of_surface("gear", surface_of(CAD["gear"](np.random.default_rng((501, number)), 96)))
    about = [turn.rotation_vector[2] for turn in near_symmetries(model) if turn.matrix[2, 2] > 0.999]
    turned = np.array(about) * teeth / (2.0 * np.pi)
    by_teeth = np.abs(turned - np.rint(turned)) < 0.02
    assert set(np.rint(turned[by_teeth]).astype(int) % teeth) == set(range(1, teeth))
    assert np.sum(~by_teeth) <= 0.6 * teeth
