"""How far the rims and outlines of round parts lie outside of the mesh that stands for them."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from geometry.camera import Camera
from geometry.facets import beyond_mesh, roundness_of
from geometry.model import Model, find_target, load_model
from geometry.pose import Pose
from geometry.surface import Surface
from geometry.visibility import Samples, visible_samples
from numerics.arrays import Floats

CAMERA = Camera(640, 480, 800.0, 800.0, 319.5, 239.5)
POSES = [Pose([turn, 0.3, 0.1], [0.01, 0.02, 0.45]) for turn in np.linspace(0.4, 1.2, 6)]
RADIUS, HEIGHT = 0.05, 0.12


def loaded(folder: Path, mesh: trimesh.Trimesh) -> Model:
    mesh.export(folder / "part.stl")
    return load_model(folder / "part.stl")


def cylinder(folder: Path, segments: int) -> Model:
    return loaded(folder, trimesh.creation.cylinder(RADIUS, HEIGHT, sections=segments))


def prism(corners: Floats) -> Model:
    """A prism upon corners (N, 2), metres."""
    count = len(corners)
    low, high = (np.column_stack([corners, np.full(count, z)]) for z in (0.0, 0.05))
    sides = [np.array([i, (i + 1) % count, (i + 1) % count + count, i + count]) for i in range(count)]
    ends = [np.arange(count)[::-1], np.arange(count) + count]
    faces = [*sides, *ends]
    nothing = np.empty((0, 2), np.int64)
    surface = Surface(np.concatenate([low, high]), faces, np.full(len(faces), -1), nothing, 0.01, 30.0)
    return Model.of_surface("prism", surface)


def beyond(model: Model, pose: Pose, samples: Samples) -> Floats:
    found = beyond_mesh(model, pose, samples)
    assert found is not None
    return found


@pytest.mark.parametrize("segments", [24, 32])
def test_rims_of_a_cylinder_lie_so_far_outside_of_their_chords(tmp_path: Path, segments: int) -> None:
    model = cylinder(tmp_path, segments)
    sagitta = RADIUS * (1.0 - np.cos(np.pi / segments))
    for pose in POSES:
        samples = visible_samples(model, CAMERA, pose, 2.0)
        rim = ~model.smooth[samples.line]
        assert rim.sum() > 50
        chords = samples.points[rim]
        assert (RADIUS - np.hypot(*chords[:, :2].T)).max() > 0.9 * sagitta
        rims = chords + beyond(model, pose, samples)[rim]
        assert np.abs(np.hypot(*rims[:, :2].T) - RADIUS).max() < 0.1 * sagitta


def test_outlines_lie_where_those_of_a_fine_mesh_do(tmp_path: Path) -> None:
    coarse, fine = cylinder(tmp_path, 32), cylinder(tmp_path, 192)
    sagitta_px = RADIUS * (1.0 - np.cos(np.pi / 32)) * CAMERA.fx / POSES[0].translation[2]
    off, before = [], []
    for pose in POSES:
        true = visible_samples(fine, CAMERA, pose, 0.5)
        samples = visible_samples(coarse, CAMERA, pose, 2.0)
        smooth = coarse.smooth[samples.line]
        outlines = samples.points + beyond(coarse, pose, samples)
        for found, points in ((off, outlines), (before, samples.points)):
            image = CAMERA.project(pose.apply(points))
            nearest = np.linalg.norm(image[smooth][:, None] - true.image[None], axis=2).argmin(axis=1)
            found.append(np.abs(((image[smooth] - true.image[nearest]) * true.normal[nearest]).sum(axis=1)))
    assert np.concatenate(before).max() > 0.5 * sagitta_px
    assert np.concatenate(off).mean() < 0.25 * np.concatenate(before).mean()


def arch(bends: int) -> Floats:
    """A plate whose upper side is bent so many times by 15 degrees, with a corner where it begins."""
    ways = np.radians(180.0 + 15.0 * (np.arange(bends + 1) - 0.5 * bends))
    top = np.cumsum(np.column_stack([np.cos(ways), np.sin(ways)]), axis=0)
    return 0.02 * np.concatenate([[[0.0, -3.0], [0.0, 0.0]], top, [[top[-1, 0], -3.0]]])


def test_what_has_few_or_unequal_sides_keeps_its_corners() -> None:
    turns = np.radians(np.arange(6) * 60.0)
    nut = np.column_stack([np.cos(turns), np.sin(turns)])
    assert roundness_of(load_model(find_target("cube"))) is None
    assert roundness_of(prism(0.03 * nut)) is None
    assert roundness_of(prism(arch(2))) is None
    curved = roundness_of(prism(arch(5)))
    assert curved is not None
    assert (curved.rise != 0.0).any()


@pytest.mark.parametrize(("sides", "may_be_round"), [(12, False), (13, True), (16, True)])
def test_a_part_of_twelve_sides_keeps_them(tmp_path: Path, sides: int, may_be_round: bool) -> None:
    assert (roundness_of(cylinder(tmp_path, sides)) is not None) == may_be_round


def test_straight_sides_beside_a_round_corner_stay_straight() -> None:
    quarter = np.radians(np.linspace(0.0, 90.0, 7))
    corners = [
        0.01 * np.column_stack([np.cos(quarter + turn), np.sin(quarter + turn)]) + middle
        for turn, middle in zip(
            np.radians([0.0, 90.0, 180.0, 270.0]),
            0.05 * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]), strict=True,
        )
    ]  # fmt: skip
    model = prism(np.concatenate(corners))
    found = roundness_of(model)
    assert found is not None
    length = np.linalg.norm(np.diff(model.vertices[model.lines], axis=1)[:, 0], axis=1)
    rise = np.linalg.norm(found.rise, axis=1)
    assert (rise[length > 0.04] == 0.0).all()
    arc = 0.01 * (1.0 - np.cos(np.radians(7.5)))
    np.testing.assert_allclose(rise[length < 0.01], arc, rtol=0.05)
    np.testing.assert_allclose(found.radius[found.radius > 0.0], 0.01, rtol=0.05)


def test_a_wall_and_its_chamfer_do_not_bend_into_each_other() -> None:
    count = 64
    turns = 2.0 * np.pi * np.arange(count) / count
    around = np.column_stack([np.cos(turns), np.sin(turns)])
    levels = [(0.05, 0.0), (0.05, 0.03), (0.045, 0.035)]
    vertices = np.concatenate([np.column_stack([r * around, np.full(count, z)]) for r, z in levels])
    walls = [
        np.array([i, (i + 1) % count, (i + 1) % count + count, i + count]) + count * level
        for level in range(2)
        for i in range(count)
    ]
    faces = [*walls, np.arange(count)[::-1], np.arange(count) + 2 * count]
    nothing = np.empty((0, 2), np.int64)
    model = Model.of_surface("knob", Surface(vertices, faces, np.full(len(faces), -1), nothing, 0.01, 30.0))
    found = roundness_of(model)
    assert found is not None
    assert np.linalg.norm(found.rise, axis=1).max() < 1.01 * 0.05 * (1.0 - np.cos(np.pi / count))
    assert np.linalg.norm(found.rise[model.smooth], axis=1).max() < 1e-9
