"""Lines that bend are cut, straight ones stay whole."""

from __future__ import annotations

import numpy as np
import pytest

from vision_server.segments.bending import LEAST_PIECE_PX, MAX_BEND_RAD, cut_bent
from vision_server.segments.line_fit import Edgels, fit_lines


def arc(radius: float, turn_rad: float, sd: float = 0.0, seed: int = 0) -> Edgels:
    """One group of edgels a pixel apart along an arc about (200, 100), in no order."""
    rng = np.random.default_rng(seed)
    angle = 0.4 + np.linspace(0.0, turn_rad, max(int(radius * turn_rad), 2))
    rng.shuffle(angle)
    reach = radius + rng.normal(0.0, sd, len(angle))
    points = np.column_stack([200.0 + reach * np.cos(angle), 100.0 + reach * np.sin(angle)])
    return Edgels(points, angle % np.pi, np.full(len(angle), 9.0), np.array([[0, len(angle)]]))


@pytest.mark.parametrize(("radius", "turn_rad"), [(40.0, 1.0), (150.0, 0.5), (12.0, 1.5)])
def test_pieces_of_an_arc_run_as_it_does(radius: float, turn_rad: float) -> None:
    cut = cut_bent(arc(radius, turn_rad, sd=0.1))
    lines = fit_lines(cut)
    assert len(lines.count) > 1
    assert lines.length.min() > 0.7 * LEAST_PIECE_PX
    assert sorted(cut.groups.ravel())[1:-1:2] == sorted(cut.groups.ravel())[2::2]  # one goes on from another
    for (x0, y0, x1, y1), (first, stop) in zip(lines.endpoints, cut.groups, strict=True):
        off = (np.arctan2(y1 - y0, x1 - x0) - 0.5 * np.pi - cut.normals[first:stop]) % np.pi
        most = max(MAX_BEND_RAD, 1.3 * LEAST_PIECE_PX / radius)
        assert np.minimum(off, np.pi - off).max() < 0.5 * most + 0.1
    whole = fit_lines(arc(radius, turn_rad))
    assert whole.rms_axis_rad[0] > 2.0 * lines.rms_axis_rad.mean()


def test_no_edgel_is_lost_or_doubled() -> None:
    before = arc(60.0, 0.9, sd=0.2)
    cut = cut_bent(before)
    np.testing.assert_array_equal(np.sort(cut.points, axis=0), np.sort(before.points, axis=0))
    covered = np.concatenate([np.arange(*group) for group in cut.groups])
    np.testing.assert_array_equal(np.sort(covered), np.arange(len(before.points)))


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("length", [9.0, 30.0, 200.0])
def test_a_straight_line_stays_whole_whatever_its_noise(length: float, seed: int) -> None:
    line = arc(1e6, length / 1e6, sd=0.4, seed=seed)
    assert cut_bent(line) is line


def test_few_edgels_and_none_stay() -> None:
    few = arc(4.0, 1.0)
    assert cut_bent(few) is few
    none = Edgels(np.zeros((0, 2)), np.zeros(0), np.zeros(0), np.zeros((0, 2), np.int64))
    assert cut_bent(none) is none
