"""Outlines of curved surfaces lie where the surface ends, not where its shading is steepest."""

import cv2
import numpy as np
import pytest

from benchmarks.machined_parts import ROUND, surface_of
from benchmarks.synthetic_parts import estimated, random_view, rendered
from geometry.camera import Camera
from geometry.model import Model
from geometry.visibility import visible_samples
from tests.vision_server.whole_tiles import deep_channel
from vision_server.channels.gradients import SCALES_PX, Normals
from vision_server.pose.edge_points import PREPARED_BEYOND_PX, Channel, search
from vision_server.pose.observation import FILTER_OF_SOFTNESS
from vision_server.pose.outline_shading import FLANK_SCALES, inside_of, way_back

CAMERA = Camera(640, 480, 768.0, 768.0, 319.5, 239.5)
SIZE, SCALE, SEED = 81, 0, 71


def test_a_shaded_body_is_found_to_a_third_of_a_degree() -> None:
    for number in (1, 5):
        rng = np.random.default_rng((SEED, 64, number))
        model = Model.of_surface("body", surface_of(ROUND["body"](64)))
        true = random_view(rng, model, CAMERA)
        found = estimated(rendered(model, CAMERA, true, rng), model, CAMERA, true)
        assert found.pose is not None
        assert found.pose.error_to(true).rotation_deg < 0.4


def test_inside_is_where_the_part_is() -> None:
    model = Model.of_surface("body", surface_of(ROUND["body"](32)))
    pose = random_view(np.random.default_rng(3), model, CAMERA)
    samples = visible_samples(model, CAMERA, pose, 3.0)
    inside = inside_of(model, CAMERA, pose, samples)
    assert set(np.abs(inside).tolist()) == {1.0}
    covered = np.zeros((480, 640), np.uint8)
    points = CAMERA.project(pose.apply(model.vertices))
    for triangle in model.triangles:
        cv2.fillConvexPoly(covered, np.round(points[triangle] * 16).astype(np.int32), 1, cv2.LINE_8, 4)
    x, y = np.rint(samples.image + 4.0 * inside[:, None] * samples.normal).astype(int).T
    assert covered[y, x].mean() > 0.97
    x, y = np.rint(samples.image - 4.0 * inside[:, None] * samples.normal).astype(int).T
    assert covered[y, x].mean() < 0.03


def test_inside_is_where_the_normals_of_an_outlines_faces_do_not_point() -> None:
    model = Model.of_surface("rounded", surface_of(ROUND["body"](16) + ROUND["ring"](6)))
    rng = np.random.default_rng(4)
    for _ in range(4):
        pose = random_view(rng, model, CAMERA)
        samples = visible_samples(model, CAMERA, pose, 3.0)
        faces = model.line_faces[samples.line]
        outwards = model.face_normals[faces].sum(axis=1) @ pose.matrix.T
        away = np.sign((outwards[:, :2] * samples.normal / [CAMERA.fx, CAMERA.fy]).sum(axis=1))
        outline = model.smooth[samples.line] & (faces >= 0).all(axis=1)
        assert outline.any() and not outline.all()
        assert (inside_of(model, CAMERA, pose, samples) == np.where(outline, -away, 0.0)).all()


def test_lines_of_a_box_are_no_outlines() -> None:
    model = Model.of_surface("ring", surface_of(ROUND["ring"](6)))
    pose = random_view(np.random.default_rng(3), model, CAMERA)
    samples = visible_samples(model, CAMERA, pose, 3.0)
    assert not inside_of(model, CAMERA, pose, samples).any()


def moved(shading: float, inside: float) -> tuple[float, float, float]:
    """Where the edge of a step at 0 is seen, by how much it is moved, and the standard deviation of that.

    Inside, the surface grows brighter as the root of the distance.
    """
    x = inside * (np.arange(SIZE * 8) / 8.0 - SIZE // 2)
    fine = 30.0 + 60.0 * (x > 0) + shading * np.sqrt(np.maximum(x, 0.0))
    row = cv2.GaussianBlur(fine[None], (0, 0), 8 * 0.7)[0].reshape(SIZE, 8).mean(axis=1)
    channel = deep_channel(np.tile(row, (SIZE, 1)).astype(np.float32), 1.0)
    middle, tiles = float(SIZE // 2), channel.tiles
    normals = Normals(np.full((1, 2), middle), np.array([[1.0, 0.0]]), np.array([4.0]))
    points = search([channel], np.full((1, 1), SCALE), normals)
    best = int(points.snr[0, 0].argmax())
    place, slope = float(points.offset[0, 0, best]), float(points.strength[0, 0, best])
    made = Channel(tiles.number[SCALE], tiles.gradient[SCALE], tiles.near_clipped[SCALE], 1.0)
    back, sd = way_back(channel.frame, made, (middle + place, middle), (1.0, 0.0), slope, inside)
    return inside * (place + 7.0 / 16.0), inside * back, sd


@pytest.mark.parametrize("inside", [1.0, -1.0])
def test_shading_draws_an_edge_in_and_it_is_moved_back(inside: float) -> None:
    plain, back, sd = moved(0.0, inside)
    assert abs(back) < 0.02 and sd < 0.02
    before, shift, sd = moved(40.0, inside)
    assert before - plain > 0.1
    assert abs(before - plain + shift) < 0.5 * (before - plain)
    assert sd == pytest.approx(0.5 * abs(shift))


def test_flanks_are_on_tiles_that_are_there() -> None:
    assert FLANK_SCALES * SCALES_PX[int(FILTER_OF_SOFTNESS.max())] <= PREPARED_BEYOND_PX
