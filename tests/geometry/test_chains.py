"""Lines that continue each other are one chain, and short ones of a long chain are seen."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from geometry.camera import Camera
from geometry.chains import CURVE_DEG, arcs, chains
from geometry.model import Model, find_target, load_model
from geometry.pose import Pose
from geometry.surface import Surface
from geometry.visibility import visible_samples

CAMERA = Camera(640, 480, 800.0, 800.0, 319.5, 239.5)
RADIUS, HEIGHT = 0.05, 0.12


def cylinder(folder: Path, segments: int) -> Model:
    file = folder / f"cylinder{segments}.stl"
    trimesh.creation.cylinder(RADIUS, HEIGHT, sections=segments).export(file)
    return load_model(file)


def test_edges_of_a_box_are_chains_of_their_own() -> None:
    model = load_model(find_target("cube"))
    assert chains(model).tolist() == list(range(12))


def test_a_cylinder_has_two_rims_and_one_side(tmp_path: Path) -> None:
    model = cylinder(tmp_path, 64)
    found = chains(model)
    assert len(np.unique(found[~model.smooth])) == 2
    for chain in np.unique(found[~model.smooth]):
        heights = model.vertices[model.lines[(found == chain) & ~model.smooth]][..., 2]
        assert np.ptp(heights) == pytest.approx(0.0, abs=1e-6)
    assert not set(found[model.smooth].tolist()) & set(found[~model.smooth].tolist())


@pytest.mark.parametrize("segments", [16, 64, 1024])
def test_rims_are_cut_into_arcs_of_like_bend_whatever_the_mesh(tmp_path: Path, segments: int) -> None:
    model = cylinder(tmp_path, segments)
    found = arcs(model)
    assert (found.leader[model.smooth] == np.flatnonzero(model.smooth)).all()
    for leader in np.unique(found.leader[~model.smooth]):
        arc = np.flatnonzero(found.leader == leader)
        arc = arc[np.argsort(found.place[arc])]
        ends = np.where(found.backwards[arc, None], model.lines[arc, ::-1], model.lines[arc])
        assert (ends[1:, 0] == ends[:-1, 1]).all()  # each goes on where the one before ends
        assert (len(arc) - 1) * 360.0 / segments < CURVE_DEG
    arcs_a_rim = len(np.unique(found.leader[~model.smooth])) / 2
    assert arcs_a_rim == 16 if segments == 16 else 16 <= arcs_a_rim <= 20


@pytest.mark.parametrize("segments", [32, 128, 1024])
def test_rims_are_seen_however_fine_the_mesh(tmp_path: Path, segments: int) -> None:
    model = cylinder(tmp_path, segments)
    pose = Pose(np.array([2.2, 0.0, 0.0]), np.array([0.0, 0.0, 0.6]))
    seen = visible_samples(model, CAMERA, pose, 2.0)
    on_rim = ~model.smooth[seen.line]
    drawn = pose.apply(_circle(0.5 * HEIGHT)), pose.apply(_circle(-0.5 * HEIGHT))
    whole = max(float(np.linalg.norm(np.diff(CAMERA.project(rim), axis=0), axis=1).sum()) for rim in drawn)
    assert whole < seen.px[on_rim].sum() < 2.0 * whole  # one rim, and the near half of the other
    assert on_rim.sum() == pytest.approx(seen.px[on_rim].sum() / 2.0, rel=0.1)


def _circle(height: float) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    angle = np.linspace(0.0, 2.0 * np.pi, 721)
    return np.column_stack([RADIUS * np.cos(angle), RADIUS * np.sin(angle), np.full(721, height)])


def test_the_outline_of_a_ball_is_walked_in_arcs() -> None:
    ball = trimesh.creation.icosphere(4, 0.1)
    flat, sharp = 0.01, 30.0
    surface = Surface(
        ball.vertices, list(ball.faces), np.full(len(ball.faces), -1), np.empty((0, 2), int), flat, sharp
    )
    model = Model.of_surface("ball", surface)
    seen = visible_samples(model, CAMERA, Pose(np.array([0.3, 0.2, 0.1]), np.array([0.0, 0.0, 1.0])), 2.0)
    assert (np.diff(seen.line) >= 0).all()
    counts = np.bincount(seen.line)
    assert np.median(counts[counts > 0]) >= 5
    from_middle = seen.image - seen.image.mean(axis=0)
    across = np.abs((from_middle * seen.image_direction).sum(axis=1)) / np.linalg.norm(from_middle, axis=1)
    assert across.max() < 0.1  # the outline of a ball is a circle
    for line in np.flatnonzero(counts > 1):
        own = seen.image[seen.line == line]
        steps = np.linalg.norm(np.diff(own, axis=0), axis=1)
        assert steps.max() < 6.0  # in order, without jumps
