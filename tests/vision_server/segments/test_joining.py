"""Joining collinear lines."""

from __future__ import annotations

import numpy as np
import pytest

from vision_server.segments.joining import MAX_GAP_PX, join_collinear
from vision_server.segments.line_fit import Edgels, fit_lines


def lines_along(*stretches: tuple[float, float, float, float, float]) -> Edgels:
    """Groups of edgels a pixel apart: first and last place, shift across, turn in rad, strength."""
    points, strengths, groups = [], [], []
    for first, last, shift, turn, strength in stretches:
        t = np.arange(first, last + 1)
        middle = 0.5 * (first + last)
        x = middle + (t - middle) * np.cos(turn)
        y = 50.0 + shift + (t - middle) * np.sin(turn)
        groups.append((len(strengths), len(strengths) + len(t)))
        points += list(zip(x, y, strict=True))
        strengths += [strength] * len(t)
    return Edgels(np.array(points), np.full(len(points), 0.5 * np.pi), np.array(strengths), np.array(groups))


def joined(*stretches: tuple[float, float, float, float, float]) -> list[float]:
    """Lengths of the lines after joining, longest first."""
    edgels = lines_along(*stretches)
    return sorted(fit_lines(join_collinear(edgels, fit_lines(edgels))).length, reverse=True)


def test_pieces_of_a_line_become_one() -> None:
    assert joined(
        (0, 30, 0.0, 0.0, 9.0), (40, 80, 0.3, 0.0, 8.0), (92, 120, 0.1, 0.01, 7.0)
    ) == pytest.approx([120.0], abs=0.2)


def test_the_order_of_the_pieces_does_not_matter() -> None:
    pieces = [(0, 30, 0.0, 0.0, 9.0), (40, 80, 0.0, 0.0, 8.0), (92, 120, 0.0, 0.0, 7.0)]
    assert joined(*pieces) == joined(*pieces[::-1]) == [120.0]


@pytest.mark.parametrize(
    "other",
    [
        (45 + MAX_GAP_PX, 140, 0.0, 0.0, 9.0),  # too far away
        (45, 53, 0.0, 0.0, 9.0),  # gap too long for so short a piece
        (45, 80, 2.5, 0.0, 9.0),  # beside the line
        (45, 80, 0.0, 0.2, 9.0),  # turned
        (45, 80, 0.0, 0.0, 40.0),  # another edge by its strength
        (10, 35, 0.9, 0.0, 9.0),  # side by side
    ],
)
def test_other_lines_stay_alone(other: tuple[float, float, float, float, float]) -> None:
    assert len(joined((0, 40, 0.0, 0.0, 9.0), other)) == 2


def test_nothing_to_join() -> None:
    none = Edgels(np.zeros((0, 2)), np.zeros(0), np.zeros(0), np.zeros((0, 2), np.int64))
    assert len(join_collinear(none, fit_lines(none)).groups) == 0
    one = lines_along((0, 30, 0.0, 0.0, 9.0))
    assert join_collinear(one, fit_lines(one)) is one
