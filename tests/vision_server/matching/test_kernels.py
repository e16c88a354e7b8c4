"""The matchers' kernels agree with plain statements of the same equations."""

from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.pose import Pose, disturbed
from numerics.arrays import Floats
from tests.geometry.boxes import box
from tests.vision_server.matching_scenes import CAMERA, CUBE, POSE, SATELLITE, segments_of
from vision_server.matching.draws import even_numbers, in_range, poses_around, poses_in_range
from vision_server.matching.icp import (
    CHANCE_SUPPORT,
    SIGNIFICANCE,
    SUM,
    SUPPORT_SINE,
    Lookup,
    Merit,
    align,
    normal_equations,
    score_poses,
)
from vision_server.matching.match import SearchRange, distinct, long_enough, short_enough
from vision_server.matching.nearest_edges import (
    AXIS_BINS,
    BIN_OVERLAP,
    NO_SEGMENT,
    PIECE_PX,
    bin_of,
    distance_transform,
    distance_transform_plainly,
    nearest_edges,
    offset,
)
from vision_server.matching.views import (
    Views,
    ViewTable,
)


def distance_to(segment: Floats, point: Floats) -> float:
    first, last = segment[:2], segment[2:]
    along = np.clip((point - first) @ (last - first) / ((last - first) @ (last - first)), 0, 1)
    return float(np.linalg.norm(point - first - along * (last - first)))


def axial_gap(first: float, second: float, period: float) -> float:
    gap = abs(first - second) % period
    return min(gap, period - gap)


@settings(deadline=None)  # the first call compiles
@given(st.floats(0.001, np.pi - 0.001), st.floats(0.01, 100.0), st.booleans())
def test_bins_of_directions(angle: float, length: float, turned: bool) -> None:
    bins = angle / np.pi * AXIS_BINS
    if abs(bins - round(bins)) < 1e-6:
        return
    sign = -1.0 if turned else 1.0
    assert bin_of(sign * length * np.cos(angle), sign * length * np.sin(angle)) == int(bins)


def test_the_labelled_segment_is_the_nearest_of_like_direction() -> None:
    segments = segments_of(SATELLITE, POSE, clutter=60)
    edges = nearest_edges(segments, CAMERA)
    steps = segments[:, 2:] - segments[:, :2]
    position = np.arctan2(steps[:, 1], steps[:, 0]) % np.pi / np.pi * AXIS_BINS
    random = np.random.default_rng(1)
    for _ in range(200):
        bin_, point = int(random.integers(AXIS_BINS)), random.uniform([0, 0], [639, 479])
        label = int(edges.label[bin_, int((point[1] + 0.5) / 2), int((point[0] + 0.5) / 2)])
        gaps = [axial_gap(one, bin_ + 0.5, AXIS_BINS) for one in position]
        like = [i for i in range(len(segments)) if gaps[i] <= 0.5 + BIN_OVERLAP]
        least = min(distance_to(segments[i], point) for i in like)
        assert label in like
        assert distance_to(segments[label], point) <= 1.03 * least + 4.0
        across, distance = offset(edges.segments, label, point[0], point[1])
        assert distance == pytest.approx(distance_to(segments[label], point))
        assert abs(across) <= distance + 1e-9


def test_the_distance_transform_is_that_of_the_definition() -> None:
    random = np.random.default_rng(3)
    painted = np.full((40, 50), NO_SEGMENT, dtype=np.int16)
    places = random.integers(0, [40, 50], (30, 2))
    painted[places[:, 0], places[:, 1]] = random.integers(0, 9, 30)
    distance, label = distance_transform(painted)
    plain_distance, plain_label = distance_transform_plainly(painted)
    np.testing.assert_allclose(distance, plain_distance, rtol=0.03)
    assert (label == plain_label).mean() > 0.95  # elsewhere two are nearly as near
    for row, column in np.argwhere(label != plain_label):
        own = np.argwhere(painted == label[row, column]) - [row, column]
        assert np.linalg.norm(own, axis=1).min() <= 1.05 * plain_distance[row, column]


def test_a_direction_without_segments_has_no_label() -> None:
    edges = nearest_edges(np.array([[100.0, 100.0, 300.0, 100.0]]), CAMERA)
    assert (edges.label[4] == -1).all()
    assert (edges.label[0] == 0).all()
    assert (edges.gain[4] == 0).all()
    assert edges.gain[0, 50, 100] == 255


def plain_score(segments: Floats, label: Floats, pose: Pose, reach: float, merit: Merit) -> float:
    total, length, left = 0.0, 0.0, defaultdict[tuple[int, int], float](lambda: PIECE_PX)
    for point, direction, px in zip(*_plain_samples(pose), strict=True):
        angle = np.arctan2(direction[1], direction[0]) % np.pi
        bin_ = min(AXIS_BINS - 1, int(angle / np.pi * AXIS_BINS))
        support = 0.0
        segment = int(label[bin_, int((point[1] + 0.5) / 2), int((point[0] + 0.5) / 2)])
        if segment >= 0:
            step = segments[segment, 2:] - segments[segment, :2]
            turn = abs(np.sin(np.arctan2(step[1], step[0]) - angle))
            near = max(0, 1 - distance_to(segments[segment], point) / reach)
            support = px * near * max(0, 1 - turn / SUPPORT_SINE)
            if merit.once:
                whole = float(np.linalg.norm(step))
                along = float(np.clip((point - segments[segment, :2]) @ step / whole, 0.0, whole))
                piece = (segment, int(along / PIECE_PX))
                support = min(support, left[piece])
                left[piece] -= support
        total += support - px * CHANCE_SUPPORT
        length += px
    return float(total / length**merit.power)


def _plain_samples(pose: Pose) -> tuple[Floats, Floats, Floats]:
    """The samples that the view of a pose has, projected from it."""
    views = Views(SATELLITE, CAMERA, POSE, 8.0)
    view = int(views.of(pose.matrix[None], pose.translation[None])[0])
    table = views.table()
    runs = range(table.first[view], table.first[view + 1])
    of_sample = np.concatenate([np.full(table.run[q + 1] - table.run[q], q) for q in runs])
    chosen = np.concatenate([np.arange(table.run[q], table.run[q + 1]) for q in runs])
    ends = [CAMERA.project(pose.apply(table.ends[of_sample, k])) for k in (0, 1)]
    return CAMERA.project(pose.apply(table.points[chosen])), ends[1] - ends[0], table.px[chosen]


@pytest.mark.parametrize("merit", [SUM, SIGNIFICANCE])
@pytest.mark.parametrize("reach", [24.0, 5.0])
def test_scores_agree_with_the_plain_sum(reach: float, merit: Merit) -> None:
    segments = segments_of(SATELLITE, POSE, clutter=40)
    edges = nearest_edges(segments, CAMERA)
    random = np.random.default_rng(2)
    poses = [POSE, *(disturbed(POSE, random, 10, 15, CAMERA.fx) for _ in range(5))]
    rotations = np.array([pose.matrix for pose in poses])
    translations = np.array([pose.translation for pose in poses])
    views = Views(SATELLITE, CAMERA, POSE, 8.0)
    view = views.of(rotations, translations)
    lookup = Lookup(edges, views.table(), CAMERA.intrinsics)
    scores = score_poses(lookup, view, rotations, translations, reach, 1, merit)
    expected = [plain_score(segments, edges.label, pose, reach, merit) for pose in poses]
    np.testing.assert_allclose(scores, expected, atol=1e-6)
    assert scores[0] == scores.max()


def test_lines_that_share_an_image_edge_share_its_support() -> None:
    edges = nearest_edges(np.array([[100.0, 200.0, 420.0, 200.0]]), CAMERA)
    ends = np.column_stack(
        [
            (np.array([100.0, 420.0]) - CAMERA.cx) / CAMERA.fx,
            np.full(2, 200.0 - CAMERA.cy) / CAMERA.fy,
            np.ones(2),
        ]
    )
    points = np.linspace(ends[0], ends[1], 80)

    def score(lines: int, merit: Merit) -> float:
        run, first = 80 * np.arange(lines + 1), np.array([0, lines])
        table = ViewTable(
            first, run, np.tile(ends, (lines, 1, 1)), np.tile(points, (lines, 1)), np.full(80 * lines, 4.0)
        )
        lookup, straight = Lookup(edges, table, CAMERA.intrinsics), np.eye(3)[None]
        return float(score_poses(lookup, np.zeros(1, np.int64), straight, np.zeros((1, 3)), 5.0, 1, merit)[0])

    assert score(2, SUM) == pytest.approx(2.0 * score(1, SUM))
    assert score(2, SIGNIFICANCE) < score(1, SIGNIFICANCE)


def test_coarse_scores_rank_like_the_exact_ones() -> None:
    segments = segments_of(SATELLITE, POSE)
    edges = nearest_edges(segments, CAMERA)
    rotations, translations = poses_in_range(POSE, CAMERA, SearchRange(8.0, 12.0), even_numbers(200, 0))
    views = Views(SATELLITE, CAMERA, POSE, 8.0)
    view = views.of(rotations, translations)
    coarse, exact = (
        score_poses(
            Lookup(edges, views.table(), CAMERA.intrinsics), view, rotations, translations, reach, 1, SUM
        )
        for reach in (0.0, 24.0)
    )
    assert np.corrcoef(coarse, exact)[0, 1] > 0.9


def test_aligning_ends_at_the_pose_that_made_the_segments() -> None:
    segments = segments_of(SATELLITE, POSE, noise_px=0.0)
    edges = nearest_edges(segments, CAMERA)
    start = disturbed(POSE, np.random.default_rng(0), 3, 5, CAMERA.fx)
    views = Views(SATELLITE, CAMERA, POSE, 4.0)
    view = int(views.of(POSE.matrix[None], POSE.translation[None])[0])
    rotation, translation = start.matrix.copy(), start.translation.copy()
    for reach in (20.0, 12.0, 6.0, 6.0):
        lookup = Lookup(edges, views.table(), CAMERA.intrinsics)
        align(lookup, view, rotation, translation, reach, 4)
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-9)
    assert Pose.from_matrix(rotation, translation).error_to(POSE).within(0.05, 0.0005)


def test_aligning_takes_no_step_after_which_less_fits(tmp_path: Path) -> None:
    """Along a slender part little holds the pose: of steps alone many of these run away from their edges."""
    bar = box(tmp_path, 1.2, 0.05, 0.04)
    turned = Pose(np.array([0.5, 0.4, 0.2]), np.array([0.02, -0.01, 2.0]))
    pose = turned.compose(Pose(np.zeros(3), -bar.middle))
    segments = segments_of(bar, pose, clutter=40)
    views = Views(bar, CAMERA, pose, 4.0)
    edges, room, lost = nearest_edges(segments, CAMERA), (np.empty((6, 6)), np.empty(6)), 0
    for number in range(100):
        start = disturbed(pose, np.random.default_rng(number), 6, 8, CAMERA.fx)
        view = int(views.of(start.matrix[None], start.translation[None])[0])
        lookup = Lookup(edges, views.table(), CAMERA.intrinsics)
        rotation, translation = start.matrix.copy(), start.translation.copy()
        before = normal_equations(lookup, view, rotation, translation, 12.0, *room)
        align(lookup, view, rotation, translation, 12.0, 3)
        lost += normal_equations(lookup, view, rotation, translation, 12.0, *room) < before
    assert lost == 0, lost


def test_even_numbers_fill_every_part_of_the_range() -> None:
    numbers = even_numbers(4096, 5)
    assert (np.abs(numbers) <= 1).all()
    for axis in range(6):
        counts, _ = np.histogram(numbers[:, axis], bins=16, range=(-1, 1))
        assert counts.min() > 230
    halves = (numbers > 0) @ (1 << np.arange(6))
    counts = np.bincount(halves, minlength=64)
    assert counts.min() > 0.7 * 64
    np.testing.assert_array_equal(numbers, even_numbers(4096, 5))
    assert (numbers != even_numbers(4096, 6)).any()


def test_numbers_mean_turns_about_the_targets_axes_and_pixels_at_its_depth() -> None:
    numbers = np.array([[1.0, 0, 0, 0, 0, 0], [0, 0, 0, 0.5, 0, -1.0]])
    rotations, translations = poses_in_range(POSE, CAMERA, SearchRange(25.0, 40.0), numbers)
    turned = POSE.compose(Pose(np.array([np.radians(25.0), 0, 0]), np.zeros(3)))
    np.testing.assert_allclose(rotations[0], turned.matrix, atol=1e-12)
    np.testing.assert_allclose(translations[0], POSE.translation)
    reach = 40.0 * 1.0 / 700.0
    np.testing.assert_allclose(translations[1] - POSE.translation, [0.5 * reach, 0, -reach], atol=1e-12)


def test_the_search_covers_where_a_disturbed_seed_came_from() -> None:
    random, wide = np.random.default_rng(6), SearchRange(25.0, 40.0)
    for _ in range(200):
        seed = disturbed(POSE, random, 25.0, 40.0, CAMERA.fx)
        assert in_range(seed, CAMERA, wide, POSE.matrix[None], POSE.translation[None])[0]
    rotations, translations = poses_around(POSE, CAMERA, wide, even_numbers(500, 0))
    assert in_range(POSE, CAMERA, wide, rotations, translations).all()
    assert not in_range(POSE, CAMERA, SearchRange(5.0, 40.0), rotations, translations).all()
    far = POSE.translation + np.array([0.1, 0.0, 0.0])
    assert not in_range(POSE, CAMERA, wide, POSE.matrix[None], far[None])[0]


def test_distinct_poses_come_best_first() -> None:
    near = POSE.stepped([0.005, 0, 0, 0.001, 0, 0])
    apart = POSE.stepped([0.0, 0.1, 0, 0, 0, 0])
    poses = [POSE, near, apart, POSE.stepped([0, 0, 0, 0, 0, 0.05])]
    rotations = np.array([p.matrix for p in poses])
    translations = np.array([p.translation for p in poses])
    assert distinct(rotations, translations, np.array([1.0, 2.0, 3.0, -np.inf]), 4) == [2, 1]
    assert distinct(rotations, translations, np.array([1.0, 2.0, 3.0, 0.0]), 2) == [2, 1]


def test_segments_worth_matching_scale_with_the_target() -> None:
    segments = np.array([[0, 0, n, 0] for n in (5.0, 8.0, 13.0, 20.0)])
    assert long_enough(segments, 300.0).tolist() == [False, False, False, True]
    assert long_enough(segments, 100.0).tolist() == [False, False, True, True]
    assert long_enough(segments, 10.0).tolist() == [False, True, True, True]
    assert long_enough(np.tile(segments, (2000, 1)), 10.0).sum() < 6001


def test_segments_longer_than_any_straight_run_of_the_model_are_not_its() -> None:
    edge_m = float(np.linalg.norm(np.diff(CUBE.vertices[CUBE.lines[0]], axis=0)))
    edge_px = CAMERA.fx * edge_m / POSE.translation[2]
    segments = np.array([[0, 0, n * edge_px, 0] for n in (0.5, 1.0, 1.05, 2.0, 5.0)])
    reach = 0.05 * POSE.translation[2]
    assert short_enough(segments, CUBE, CAMERA, POSE, reach).tolist() == [True, True, True, False, False]
    close = Pose(POSE.rotation_vector, np.array([0.0, 0.0, 0.5 * CUBE.diameter]))  # any length may be seen
    assert short_enough(segments, CUBE, CAMERA, close, 0.0).all()
    half = 0.5 * POSE.translation[2]  # nearer by so much it looks twice as long and more
    assert short_enough(segments, CUBE, CAMERA, POSE, half).tolist() == [True, True, True, True, False]
