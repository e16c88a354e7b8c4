"""Recursive polyline splitting."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from numerics.arrays import Floats
from vision_server.baselines.splitting import MAX_DEVIATION_RATIO, MIN_DEVIATION_PX, split_chains
from vision_server.segments.line_fit import Edgels


def chains_of(*lines: Floats) -> Edgels:
    points = np.concatenate(lines) if lines else np.zeros((0, 2))
    starts = np.concatenate([[0], np.cumsum([len(line) for line in lines])]).astype(np.int64)
    groups = np.stack([starts[:-1], starts[1:]], axis=1)
    return Edgels(points, np.zeros(len(points)), np.ones(len(points)), groups)


def split_plainly(points: Floats, first: int, last: int) -> list[tuple[int, int]]:
    """The rule of the paper, as it is written."""
    chord = points[last] - points[first]
    D = float(np.hypot(*chord))
    rest = points[first + 1 : last] - points[first]
    if len(rest):
        d = np.abs(rest[:, 0] * chord[1] - rest[:, 1] * chord[0]) / D if D > 1e-9 else np.hypot(*rest.T)
        worst = int(np.argmax(d))
        if d[worst] > MIN_DEVIATION_PX and d[worst] > MAX_DEVIATION_RATIO * D:
            middle = first + 1 + worst
            return split_plainly(points, first, middle) + split_plainly(points, middle, last)
    return [(first, last + 1)]


@settings(deadline=None, max_examples=50)
@given(st.integers(0, 10_000), st.integers(2, 60))
def test_it_is_the_rule_of_the_paper(seed: int, count: int) -> None:
    walk = np.cumsum(np.random.default_rng(seed).normal((0.7, 0.2), 1, (count, 2)), axis=0)
    pieces = split_chains(chains_of(walk))
    assert [tuple(piece) for piece in pieces.tolist()] == split_plainly(walk, 0, count - 1)


def test_corners_are_found() -> None:
    corner = np.array([[x, 0.0] for x in range(31)] + [[30.0, y] for y in range(1, 21)])
    assert split_chains(chains_of(corner)).tolist() == [[0, 31], [30, 51]]


def test_a_closed_chain_is_split_too() -> None:
    side = np.arange(20.0)
    square = np.concatenate(
        [
            np.stack([side, 0 * side], 1),
            np.stack([0 * side + 20, side], 1),
            np.stack([20 - side, 0 * side + 20], 1),
            np.stack([0 * side, 20 - side], 1),
            [[0.0, 0.0]],
        ]
    )
    assert len(split_chains(chains_of(square))) == 4


def test_noise_under_the_tolerance_is_left_alone() -> None:
    line = np.stack([np.arange(50.0), np.random.default_rng(0).uniform(-0.4, 0.4, 50)], axis=1)
    assert split_chains(chains_of(line)).tolist() == [[0, 50]]


def test_each_chain_is_split_alone() -> None:
    a, b = np.stack([np.arange(10.0), np.zeros(10)], 1), np.stack([np.zeros(12), np.arange(12.0)], 1)
    assert split_chains(chains_of(a, b)).tolist() == [[0, 10], [10, 22]]
    assert split_chains(chains_of()).shape == (0, 2)
