"""Least-squares lines and the test against chance."""

from __future__ import annotations

import numpy as np
import pytest

from numerics.arrays import Flags
from vision_server.edges.edge_map import EdgeMap
from vision_server.segments.extraction import MAX_LOG_CHANCE
from vision_server.segments.line_fit import Edgels, FittedLines, fit_lines, log_chance


def noisy_lines(count: int, points: int, sd: float, angle: float, seed: int = 0) -> Edgels:
    rng = np.random.default_rng(seed)
    along = np.tile(np.arange(points) - (points - 1) / 2, count)
    across = rng.normal(0, sd, count * points)
    c, s = np.cos(angle), np.sin(angle)
    xy = np.stack([50 + along * c - across * s, 40 + along * s + across * c], axis=1)
    starts = np.arange(count) * points
    groups = np.stack([starts, starts + points], axis=1)
    normals = np.full(len(xy), angle + np.pi / 2)
    return Edgels(xy, normals, np.full(len(xy), 7.0), groups)


def edges_at(mask: Flags) -> EdgeMap:
    zero = np.zeros(mask.shape, np.float32)
    return EdgeMap.from_fields(mask.astype(np.float32), zero, zero, 0.0)


def chance(lines: FittedLines, mask: Flags) -> float:
    """Of the first line, among edgels at the pixels of a mask."""
    edges = edges_at(mask)
    return float(log_chance(lines, edges, np.ones(len(edges), np.bool_))[0])


def test_a_clean_line_is_returned() -> None:
    lines = fit_lines(noisy_lines(1, 31, 0.0, 0.4))
    x0, y0, x1, y1 = lines.endpoints[0]
    assert np.hypot(x1 - x0, y1 - y0) == pytest.approx(30.0)
    assert np.arctan2(y1 - y0, x1 - x0) % np.pi == pytest.approx(0.4)
    assert (0.5 * (x0 + x1), 0.5 * (y0 + y1)) == pytest.approx((50.0, 40.0))
    assert lines.strength[0] == 7.0
    assert lines.rms_axis_rad[0] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(("points", "sd"), [(12, 0.3), (40, 0.5), (100, 0.2)])
def test_the_stated_uncertainty_is_the_true_one(points: int, sd: float) -> None:
    lines = fit_lines(noisy_lines(3000, points, sd, 1.1, seed=2))
    ends = lines.endpoints
    normal = np.array([-np.sin(1.1), np.cos(1.1)])
    middle = (0.5 * (ends[:, :2] + ends[:, 2:]) - [50, 40]) @ normal
    turn = np.arctan2(ends[:, 3] - ends[:, 1], ends[:, 2] - ends[:, 0]) - 1.1
    turn = (turn + np.pi / 2) % np.pi - np.pi / 2
    assert np.mean((middle / lines.normal_sd[:, 0]) ** 2) == pytest.approx(1.0, rel=0.4)
    assert np.mean((turn / lines.normal_sd[:, 1]) ** 2) == pytest.approx(1.0, rel=0.4)


def test_no_groups_no_lines() -> None:
    none = Edgels(np.zeros((0, 2)), np.zeros(0), np.zeros(0), np.zeros((0, 2), np.int64))
    assert len(fit_lines(none).endpoints) == 0
    nowhere = edges_at(np.zeros((20, 20), np.bool_))
    assert len(log_chance(fit_lines(none), nowhere, np.zeros(0, np.bool_))) == 0


def test_longer_straighter_and_lonelier_lines_are_less_likely_by_chance() -> None:
    quiet = np.zeros((80, 100), np.bool_)
    quiet[40, 20:80] = True
    busy = np.random.default_rng(0).random((80, 100)) < 0.4
    short, long = (fit_lines(noisy_lines(1, n, 0.1, 0.0)) for n in (8, 40))
    wavy = fit_lines(noisy_lines(1, 40, 0.8, 0.0))
    assert chance(long, quiet) < -20
    assert chance(long, quiet) < chance(short, quiet)
    assert chance(long, quiet) < chance(wavy, quiet)
    assert chance(long, quiet) < chance(long, busy)
    assert chance(short, busy) > MAX_LOG_CHANCE
