"""The longest straight run of lines, beside a plain search over all pairs."""

import numpy as np
import pytest

from geometry import straight_runs
from geometry.straight_runs import longest_run
from numerics.arrays import Floats

APART = 0.01


def plainly(lines: Floats) -> float:
    """Each line with all that lie on it, however far away."""
    longest = 0.0
    for start, end in lines:
        unit = (end - start) / np.linalg.norm(end - start)
        place = (lines - start) @ unit
        beside = np.linalg.norm(lines - start - place[..., None] * unit, axis=2).max(axis=1)
        longest = max(longest, float(np.ptp(place[beside < APART])))
    return longest


def pieces_of(rng: np.random.Generator, ends: Floats, count: int) -> Floats:
    """A line (2, 3) in so many pieces, some of them the other way round, with small gaps."""
    cuts = np.linspace(0.0, 1.0, count + 1)
    pieces = np.stack([cuts[:-1], cuts[1:] - 0.1 / count], axis=1)
    turned = rng.random(count) < 0.5
    pieces[turned] = pieces[turned][:, ::-1]
    return np.asarray(ends[0] + pieces[..., None] * (ends[1] - ends[0]))


@pytest.mark.parametrize("seed", range(8))
def test_it_is_that_of_a_plain_search(seed: int) -> None:
    rng = np.random.default_rng(seed)
    whole = rng.normal(size=(12, 2, 3))
    lines = np.concatenate([pieces_of(rng, ends, int(rng.integers(1, 6))) for ends in whole])
    assert longest_run(lines, APART, 0.0) == pytest.approx(plainly(lines), rel=1e-9)


def test_short_lines_far_from_each_other_are_no_run() -> None:
    line = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    lines = np.stack([line, line + np.array([1.5, 0.0, 0.0]), 0.1 * line + np.array([20.0, 0.0, 0.0])])
    assert longest_run(lines[:2], APART, 0.0) == pytest.approx(2.5)
    assert longest_run(lines, APART, 0.0) == pytest.approx(2.0 * 2.1)  # as much as these can cover


def test_of_many_parallel_lines_none_looks_longer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(straight_runs, "MANY_PARALLEL", 50)
    rng = np.random.default_rng(1)
    start = rng.uniform(0.0, 9.0, (60, 3))
    lines = np.stack([start, start + np.array([0.0, 0.0, 1.0])], axis=1)
    assert longest_run(lines, APART, 0.0) >= plainly(lines)
    assert longest_run(np.empty((0, 2, 3)), APART, 0.3) == 0.3
