"""Search by coordinate ascent where the best knobs are known."""

import numpy as np

from numerics.arrays import Floats, Ints
from vision_server.prediction.search import climb


def hill(knobs: Ints) -> Floats:
    """Highest at 5, 2, 0."""
    return -np.abs(knobs - np.array([5, 2, 0])).sum(axis=1).astype(np.float64)


def test_the_top_of_a_hill_is_found_and_everything_looked_at_is_ranked() -> None:
    looked, scores = climb(hill, np.array([0, 7, 1]), [7, 7, 4], [(-2, -1, 1, 2)] * 2 + [(-1, 1)])
    assert looked[0].tolist() == [5, 2, 0]
    assert (np.diff(scores) <= 0.0).all()
    assert len(np.unique(looked, axis=0)) == len(looked)
    assert looked.min() >= 0
    assert (looked <= [7, 7, 4]).all()


def test_a_knob_without_steps_stays() -> None:
    looked, _ = climb(hill, np.array([0, 7, 1]), [7, 7, 4], [(), (-1, 1), (-1, 1)])
    assert set(looked[:, 0].tolist()) == {0}
    looked, scores = climb(hill, np.array([3]), [7], [()])
    assert looked.tolist() == [[3]]
    assert len(scores) == 1


def test_twenty_four_knobs_are_climbed_in_few_questions() -> None:
    wanted = np.arange(24) % 8
    asked = []

    def score(knobs: Ints) -> Floats:
        asked.append(len(knobs))
        return -(np.abs(knobs - wanted) > 2).sum(axis=1).astype(np.float64)

    climb(score, np.zeros(24, dtype=np.int64), [7] * 24, [(-2, -1, 1, 2)] * 24)
    assert sum(asked) <= 1 + 8 * 96
