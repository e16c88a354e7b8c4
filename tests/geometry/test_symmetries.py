"""Turns that leave a target as it looks: none, a few, or all about an axis."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from benchmarks.machined_parts import ROUND, circle, drilled, surface_of
from geometry.model import Model, find_target, load_model
from geometry.pose import Pose
from geometry.rotation import matrix_of
from geometry.symmetries import if_round, symmetry_of, turned_towards
from tests.geometry.boxes import box


@pytest.mark.parametrize(
    ("sides", "count"), [((0.3, 0.2, 0.1), 4), ((0.2, 0.2, 0.1), 8), ((0.2, 0.2, 0.2), 24)]
)
def test_a_box_has_the_turns_of_its_sides(tmp_path: Path, sides: tuple[float, ...], count: int) -> None:
    model = box(tmp_path, *sides)
    found = symmetry_of(model)
    assert len(found.turns) == count
    assert found.free_axis is None
    for turn in found.turns:  # corners come to corners
        distance = np.linalg.norm(turn.apply(model.vertices)[:, None] - model.vertices, axis=2)
        assert distance.min(axis=1).max() < 0.01 * model.diameter


def test_a_slanted_side_or_a_mark_leaves_none(tmp_path: Path) -> None:
    assert len(symmetry_of(box(tmp_path, 0.3, 0.2, 0.1, slant=0.05)).turns) == 1
    for name in ("satellite", "fixture"):
        assert len(symmetry_of(load_model(find_target(name))).turns) == 1


@pytest.mark.parametrize("segments", [16, 64, 512])
def test_a_cylinder_may_be_turned_about_its_axis_and_upside_down(tmp_path: Path, segments: int) -> None:
    file = tmp_path / "cylinder.stl"
    turned = np.eye(4)
    turned[:3, :3] = matrix_of(np.array([0.7, 0.0, 0.0]))
    trimesh.creation.cylinder(0.03, 0.1, sections=segments, transform=turned).export(file)
    found = symmetry_of(load_model(file))
    assert found.free_axis is not None
    assert abs(found.free_axis @ turned[:3, 2]) > 0.9999
    assert len(found.turns) == 2


@pytest.mark.parametrize("shape", ["cone", "dome"])
def test_what_has_one_rim_is_not_turned_upside_down(tmp_path: Path, shape: str) -> None:
    """A half turn leaves the rim as it is."""
    mesh = trimesh.creation.cone(0.1, 0.2, sections=64)
    if shape == "dome":
        mesh = trimesh.creation.uv_sphere(0.1, count=[33, 64])
        mesh.update_faces(mesh.triangles_center[:, 2] > 0.0)
    mesh.export(tmp_path / "part.stl")
    symmetry = symmetry_of(load_model(tmp_path / "part.stl"))
    assert all(turn.matrix[2, 2] > 0.9 for turn in symmetry.turns)
    assert symmetry.free_axis is not None and np.allclose(np.abs(symmetry.free_axis), [0, 0, 1])


def test_of_round_parts_the_pose_is_meant_that_is_turned_as_another_one(tmp_path: Path) -> None:
    cone = trimesh.creation.cone(0.1, 0.2, sections=64)
    cone.apply_translation([0.3, 0.0, 0.1])
    cone.export(tmp_path / "part.stl")
    model = load_model(tmp_path / "part.stl")
    symmetry = if_round(model)
    assert symmetry.free_axis is not None
    true = Pose(np.array([0.3, -0.2, 0.1]), np.array([0.1, 0.0, 2.0]))
    for angle in (0.0, 0.7, -3.0):
        turn = Pose.turn_about(symmetry.centre, matrix_of(angle * symmetry.free_axis))
        error = true.compose(turn).error_to(turned_towards(true, true.compose(turn), symmetry))
        assert error.rotation_deg < 1e-5 and error.translation_m < 1e-9
    off = true.compose(turn).stepped([0.02, 0.0, 0.0, 0.0, 0.0, 0.01])
    error = off.error_to(turned_towards(true, off, symmetry))
    assert error.rotation_deg <= np.degrees(0.02) and error.translation_m < 0.06
    assert turned_towards(true, off, if_round(box(tmp_path, 0.1, 0.2, 0.3))) is true


@pytest.mark.parametrize("segments", [96, 258, 512])
def test_a_flange_is_turned_by_each_of_its_bolts_however_fine(segments: int) -> None:
    found = symmetry_of(Model.of_surface("flange", surface_of(ROUND["flange"](segments))))
    assert found.free_axis is None
    angles = sorted(round(float(np.degrees(np.linalg.norm(turn.rotation_vector)))) for turn in found.turns)
    assert angles == [0, 60, 60, 120, 120, 180]


def test_a_thin_rod_has_no_turns_but_those_of_its_sides(tmp_path: Path) -> None:
    assert len(symmetry_of(box(tmp_path, 1.0, 0.12, 0.12)).turns) == 8
    assert len(symmetry_of(box(tmp_path, 1.0, 0.1, 0.06)).turns) == 4


@pytest.mark.parametrize("segments", [32, 64, 90])
def test_a_nut_with_a_hole_of_other_segments_has_all_turns_of_its_sides(segments: int) -> None:
    nut = drilled(circle(0.03, 6), [circle(0.015, segments)], 0.0, 0.02)
    assert len(symmetry_of(Model.of_surface("nut", surface_of([nut]))).turns) == 12
