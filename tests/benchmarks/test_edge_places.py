"""Places of edges beside the truth: which lines have others beside them."""

from __future__ import annotations

import numpy as np

from benchmarks.edge_places import ALONE_PX, alone


def line(y: float, turn: float, number: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    along = np.array([np.cos(turn), np.sin(turn)])
    points = np.array([0.0, y]) + np.arange(0.0, 40.0, 2.0)[:, None] * along
    return points, np.tile(along, (len(points), 1)), np.full(len(points), number)


def test_a_line_is_alone_unless_another_runs_beside_it() -> None:
    near, far, crossing = 0.5 * ALONE_PX, 0.5 * ALONE_PX + 1.1 * ALONE_PX, 1.2
    lines = [line(0.0, 0.0, 0), line(near, 0.0, 1), line(far, 0.0, 2), line(far, crossing, 3)]
    points, along, number = (np.concatenate(parts) for parts in zip(*lines, strict=True))
    free = alone(points, along, number)
    assert [bool(free[number == n].all()) for n in range(4)] == [False, False, True, True]
    assert not free[number < 2].any()
