"""Intervals: known values, what they cover, and when they say nothing."""

import numpy as np
import pytest

from experiments.statistics import LEAST_SCENES, cells_needed, exact_interval, mcnemar, paired, resampled


def test_exact_intervals_are_those_of_the_tables() -> None:
    assert exact_interval(0, 10) == pytest.approx((0.0, 0.3085), abs=1e-4)
    assert exact_interval(7, 10) == pytest.approx((0.3475, 0.9333), abs=1e-4)
    assert exact_interval(10, 10) == pytest.approx((0.6915, 1.0), abs=1e-4)


def drawn(rng: np.random.Generator, scenes: int, seeds: int) -> np.ndarray:
    """Outcomes with a part of the scene, one of the seed and one of the cell; mean 0.3."""
    of_scenes, of_seeds = rng.normal(0, 0.3, (scenes, 1)), rng.normal(0, 0.1, (1, seeds))
    return 0.3 + of_scenes + of_seeds + rng.normal(0, 0.3, (scenes, seeds))


def test_intervals_cover_the_truth_over_scenes_and_seeds() -> None:
    rng = np.random.default_rng(5)
    found = [resampled(drawn(rng, 20, 5)) for _ in range(300)]
    covered = np.mean([estimate.low <= 0.3 <= estimate.high for estimate in found])
    assert covered >= 0.92
    naive = [1.96 * drawn(rng, 20, 5).std() / 10 for _ in range(300)]
    width = np.mean([estimate.high - estimate.low for estimate in found])
    assert width > 1.5 * 2 * np.mean(naive)  # of cells taken as independent: far too narrow


def test_the_closed_form_agrees_with_resampling(monkeypatch: pytest.MonkeyPatch) -> None:
    outcomes = drawn(np.random.default_rng(3), 150, 8)
    slow = resampled(outcomes)
    monkeypatch.setattr("experiments.statistics.MOST_RESAMPLED", 10)
    quick = resampled(outcomes)
    assert quick.standard_error == pytest.approx(slow.standard_error, rel=0.12)


def test_a_seed_of_each_scene_is_not_resampled_on_its_own() -> None:
    outcomes = np.full((40, 40), np.nan)
    outcomes[np.diag_indices(40)] = np.arange(40) % 2
    one_column = (np.arange(40.0) % 2)[:, None]
    assert resampled(outcomes).standard_error == pytest.approx(resampled(one_column).standard_error, rel=1e-9)


def test_few_scenes_show_no_difference() -> None:
    few, enough = np.ones((LEAST_SCENES - 1, 4)), np.ones((LEAST_SCENES, 4))
    assert not paired(few, 0 * few).differs_from_zero
    assert paired(enough, 0 * enough).differs_from_zero


def test_pairs_are_the_cells_that_both_have() -> None:
    ours, theirs = np.ones((8, 2)), np.zeros((8, 2))
    theirs[3:, 1] = np.nan
    assert paired(ours, theirs).n == 11
    assert mcnemar(ours, theirs) == (11, 0, pytest.approx(2 / 2**11))


def test_cells_needed_grow_with_the_square_of_the_error() -> None:
    rng = np.random.default_rng(1)
    difference = paired((rng.random((50, 4)) < 0.6).astype(float), (rng.random((50, 4)) < 0.5).astype(float))
    five, ten = cells_needed(difference, 0.05), cells_needed(difference, 0.10)
    assert five is not None
    assert ten is not None
    assert five == pytest.approx(4 * ten, rel=0.01)
    assert cells_needed(paired(np.ones((8, 2)), np.ones((8, 2)))) is None
