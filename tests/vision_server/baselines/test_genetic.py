"""The paper's genetic algorithm does what the paper says."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry.model import find_target, load_model
from geometry.pose import Pose, disturbed
from tests.vision_server.matching_scenes import CAMERA, segments_of
from vision_server.baselines.genetic import (
    CHILDREN_TRIED,
    POPULATION,
    SPACING_PX,
    crossed,
    decoded,
    first_generation,
    line_costs,
    line_table,
    match_genetic,
    next_generation,
)
from vision_server.matching.views import Views

POSE = Pose(np.array([0.5, 0.4, 0.2]), np.array([0.02, -0.01, 0.9]))
MODEL = load_model(find_target("cube"))
genomes = st.integers(0, 2**48 - 1)


def test_eight_bits_span_the_range_evenly() -> None:
    values = decoded(np.arange(256, dtype=np.int64))
    np.testing.assert_allclose(values[:, 0], np.linspace(-1, 1, 256))
    assert (values[:, 1:] == -1).all()
    assert (decoded(np.array([2**48 - 1])) == 1).all()
    np.testing.assert_allclose(decoded(np.array([255 << 40]))[0], [-1, -1, -1, -1, -1, 1])


@given(genomes, genomes, st.integers(1, 47), st.integers(0, 47))
def test_a_child_has_both_parents_bits_and_one_flipped(a: int, b: int, point: int, flipped: int) -> None:
    child = int(crossed(*np.array([[a], [b], [point], [flipped]]))[0])
    expected = [(a if k < point else b) >> k & 1 for k in range(48)]
    expected[flipped] ^= 1
    assert [child >> k & 1 for k in range(48)] == expected


def test_the_first_generation_is_all_different() -> None:
    first = first_generation(np.random.default_rng(0))
    assert len(np.unique(first)) == len(first) == POPULATION
    assert first.min() >= 0
    assert first.max() < 2**48


def test_the_next_generation_keeps_the_best_and_breeds_from_the_upper_third() -> None:
    random = np.random.default_rng(1)
    ranked = first_generation(random)
    numbers = random.integers(0, 2**31, (CHILDREN_TRIED * POPULATION, 4))
    following = next_generation(ranked, numbers)
    assert len(np.unique(following)) == len(following) == POPULATION
    np.testing.assert_array_equal(following[:10], ranked[:10])  # 5 %
    assert not set(following[10:].tolist()) & set(ranked[10:].tolist())
    others = next_generation(np.concatenate([ranked[:60], first_generation(random)[:140]]), numbers)
    np.testing.assert_array_equal(following, others)  # 30 %


def test_children_that_exist_do_not_enter() -> None:
    ranked = np.arange(200, dtype=np.int64)
    same = np.tile(np.array([[0, 0, 5, 3]]), (800, 1))
    assert next_generation(ranked, same).tolist() == list(range(10))  # 0 with bit 3 flipped is 8
    other = np.tile(np.array([[0, 0, 5, 20]]), (800, 1))
    assert next_generation(ranked, other).tolist() == [*range(10), 2**20]


def test_costs_agree_with_the_plain_sum() -> None:
    segments = segments_of(MODEL, POSE, clutter=30)
    views = Views(MODEL, CAMERA, POSE, SPACING_PX)
    random = np.random.default_rng(2)
    poses = [POSE, *(disturbed(POSE, random, 20, 30, CAMERA.fx) for _ in range(6))]
    rotations = np.array([pose.matrix for pose in poses])
    translations = np.array([pose.translation for pose in poses])
    view = views.of(rotations, translations)
    table = views.table()
    costs, supported = line_costs(
        line_table(segments), table, view, rotations, translations, CAMERA.intrinsics
    )
    for pose, index, cost in zip(poses, view, costs, strict=True):
        expected = 0.0
        for pair in table.ends[table.first[index] : table.first[index + 1]]:
            first, last = CAMERA.project(pose.apply(pair))
            normal = np.array([-(last - first)[1], (last - first)[0]]) / np.linalg.norm(last - first)
            distances = (segments.reshape(-1, 2, 2) - first) @ normal
            steps = segments[:, 2:] - segments[:, :2]
            turns = np.degrees(np.arctan2(steps[:, 1], steps[:, 0]) - np.arctan2(*(last - first)[::-1]))
            turns = np.abs((turns + 90) % 180 - 90)
            expected += ((distances**2).sum(axis=1) + turns**2).min()
        assert cost == pytest.approx(expected)
    assert costs[0] == costs.min()
    assert supported[0] == pytest.approx(1.0)


def test_evolution_makes_the_cost_smaller() -> None:
    segments = segments_of(MODEL, POSE, clutter=30)
    start = disturbed(POSE, np.random.default_rng(3), 25, 40, CAMERA.fx)
    before, after = (
        match_genetic(segments, MODEL, CAMERA, start, 0, generations=count)[0].score for count in (0, 10)
    )
    assert after > before


def test_it_finds_the_pose_from_a_fair_seed() -> None:
    segments = segments_of(MODEL, POSE)
    found = []
    for seed in range(5):
        start = disturbed(POSE, np.random.default_rng(seed), 8, 12, CAMERA.fx)
        match = match_genetic(segments, MODEL, CAMERA, start, seed)
        found.append(match[0].pose.error_to(POSE).within(8.0, 0.05))
    assert sum(found) >= 3
