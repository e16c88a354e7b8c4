"""Which lines of a model are seen from a direction, and which of very many are looked for."""

from dataclasses import replace

import numpy as np
import pytest

from geometry.model import Model
from geometry.pose import Pose
from geometry.visibility import MIN_LINE_PX, image_bounds, visible_samples
from numerics.arrays import Floats
from tests.vision_server.matching_scenes import CAMERA, CUBE, POSE, SATELLITE
from vision_server.matching.search import exact_view
from vision_server.matching.views import (
    LEAST_SEARCHED_LINE_PX,
    MOST_SEARCHED_CURVES,
    VIEW_CELL_DEG,
    Views,
    cells_of,
    frame_towards,
    least_line_px,
    longest_straight_m,
    middle_of_cell,
    sparse_solid,
)


def test_a_view_shows_the_lines_that_are_visible_from_its_direction() -> None:
    views = Views(SATELLITE, CAMERA, POSE, 4.0)
    view = int(views.of(POSE.matrix[None], POSE.translation[None])[0])
    table = views.table()
    ends = table.ends[table.first[view] : table.first[view + 1]]
    shown = {tuple(np.round(pair, 9).ravel()) for pair in ends}
    samples = visible_samples(SATELLITE, CAMERA, POSE, 4.0)
    exact = {
        tuple(np.round(SATELLITE.vertices[SATELLITE.lines[i]], 9).ravel()) for i in np.unique(samples.line)
    }
    assert len(shown ^ exact) <= 2


def test_poses_that_look_alike_share_a_view() -> None:
    views = Views(CUBE, CAMERA, POSE, 8.0)
    spun = POSE.stepped([0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    tilted = POSE.compose(Pose(np.array([np.radians(3 * VIEW_CELL_DEG), 0.0, 0.0]), np.zeros(3)))
    poses = [POSE, spun, tilted]
    index = views.of(np.array([p.matrix for p in poses]), np.array([p.translation for p in poses]))
    assert index[0] == index[1] != index[2]
    assert len(views) == 2
    again = views.of(POSE.matrix[None], POSE.translation[None])
    assert again[0] == index[0]
    assert len(views) == 2


@pytest.mark.parametrize("towards", np.random.default_rng(8).normal(size=(40, 3)))
def test_a_view_is_seen_from_near_the_direction_asked_for(towards: Floats) -> None:
    away = frame_towards(-towards / np.linalg.norm(towards))
    frame = frame_towards(POSE.matrix[2])
    cell = cells_of(away[None], np.array([[0.0, 0.0, 1.0]]), np.zeros(3), frame)[0]
    middle = middle_of_cell(cell, frame)
    off = np.degrees(np.arccos(middle @ towards / np.linalg.norm(towards)))
    assert off < 0.5 * np.sqrt(2.0) * VIEW_CELL_DEG
    again = frame_towards(-middle)
    assert cells_of(again[None], np.array([[0.0, 0.0, 1.0]]), np.zeros(3), frame)[0] == cell


def of_many_lines() -> Model:
    """The satellite with each of its lines many times."""
    many = 3 * MOST_SEARCHED_CURVES
    lines = np.tile(SATELLITE.lines, (many // len(SATELLITE.lines) + 1, 1))
    repeated = len(lines) // len(SATELLITE.lines)
    faces = np.tile(SATELLITE.line_faces, (repeated, 1))
    return replace(SATELLITE, lines=lines, line_faces=faces, smooth=np.zeros(len(lines), dtype=bool))


def test_of_a_big_model_lines_that_are_short_in_the_image_are_not_looked_for() -> None:
    big, afar = of_many_lines(), Pose(POSE.rotation_vector, np.array([0.0, 0.0, 12.0 * SATELLITE.diameter]))
    shortest = []
    for model in (SATELLITE, big):
        seen = exact_view(
            sparse_solid(big),
            afar.matrix,
            afar.translation.copy(),  # which may be written to, as those of a search
            CAMERA.intrinsics,
            image_bounds(CAMERA),
            least_line_px(model),
        )
        ends = CAMERA.project(afar.apply(seen.ends.reshape(-1, 3))).reshape(-1, 2, 2)
        shortest.append(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).min())
    assert MIN_LINE_PX <= shortest[0] < LEAST_SEARCHED_LINE_PX <= shortest[1]


def test_a_big_model_keeps_its_longest_lines_and_all_that_hides() -> None:
    assert len(sparse_solid(SATELLITE).lines) == len(SATELLITE.lines)
    big = of_many_lines()
    solid = sparse_solid(big)
    assert len(solid.lines) == MOST_SEARCHED_CURVES
    assert len(solid.tree.triangle) == len(SATELLITE.triangles)
    length = np.linalg.norm(np.diff(SATELLITE.vertices[SATELLITE.lines], axis=1)[:, 0], axis=1)
    kept = np.linalg.norm(np.diff(solid.vertices[solid.lines], axis=1)[:, 0], axis=1)
    assert kept.min() > length.min()


def test_lines_that_continue_each_other_are_one_straight_run() -> None:
    wings = float(np.ptp(SATELLITE.vertices[SATELLITE.lines].reshape(-1, 3), axis=0).max())
    single = np.linalg.norm(np.diff(SATELLITE.vertices[SATELLITE.lines], axis=1)[:, 0], axis=1).max()
    assert longest_straight_m(SATELLITE) == pytest.approx(wings, rel=0.02)
    assert longest_straight_m(SATELLITE) > 2.0 * single
