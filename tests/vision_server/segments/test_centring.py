"""Lines moved to the middle of blurred edges."""

from __future__ import annotations

import numpy as np
import pytest

from vision_server.segments.centring import centre_lines


def plateau(half_width: float, angle: float = 0.4) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A straight band of constant gradient through the middle, with its direction and normal."""
    y, x = np.mgrid[:80, :120].astype(np.float64)
    normal = np.array([-np.sin(angle), np.cos(angle)])
    across = (x - 60) * normal[0] + (y - 40) * normal[1]
    mass = 1.0 / (1.0 + np.exp((np.abs(across) - half_width) * 3.0))
    return mass.astype(np.float32), np.array([np.cos(angle), np.sin(angle)]), normal


@pytest.mark.parametrize("half_width", [1.5, 4.0, 7.0])
@pytest.mark.parametrize("shift", [-2.0, 0.0, 1.5])
def test_a_line_off_the_middle_is_brought_back(half_width: float, shift: float) -> None:
    mass, along, normal = plateau(half_width)
    shift = np.clip(shift, -half_width, half_width)
    middle = np.array([60.0, 40.0])
    ends = np.concatenate([middle - 25 * along + shift * normal, middle + 25 * along + 0.5 * shift * normal])
    moved = centre_lines(ends[None], [(mass, np.ones_like(mass))], 12.0)[0]
    for point in (moved[:2], moved[2:]):
        assert abs((point - middle) @ normal) < 0.2


def test_lines_on_endless_slopes_and_short_ones_are_left_in_place() -> None:
    flat = np.ones((60, 60), np.float32)
    ends = np.array([[10.0, 30.0, 50.0, 30.0], [20.0, 20.0, 20.2, 20.0]])
    np.testing.assert_array_equal(centre_lines(ends, [(flat, flat)], 6.0), ends)


def test_short_lines_keep_their_direction() -> None:
    mass, along, normal = plateau(4.0)
    middle = np.array([60.0, 40.0]) + 1.5 * normal
    ends = np.concatenate([middle - 6 * along, middle + 6 * along])
    moved = centre_lines(ends[None], [(mass, np.ones_like(mass))], 12.0)[0]
    np.testing.assert_allclose(moved[2:] - moved[:2], 12 * along, atol=1e-9)
    assert abs((moved[:2] - [60.0, 40.0]) @ normal) < 0.2


def test_none_stay_none() -> None:
    assert centre_lines(np.zeros((0, 4)), [], 5.0).shape == (0, 4)


def test_weights_that_change_across_the_edge_do_not_move_it() -> None:
    mass, along, normal = plateau(5.0)
    y, x = np.mgrid[:80, :120].astype(np.float64)
    across = (x - 60) * normal[0] + (y - 40) * normal[1]
    rising = np.exp2(np.clip(2.0 * across, -20, 20)).astype(np.float32)
    ends = np.concatenate([[60.0, 40.0] - 25 * along + normal, [60.0, 40.0] + 25 * along + normal])
    moved = centre_lines(ends[None], [(mass, rising), (mass, 1.0 / rising)], 12.0)[0]
    assert abs((moved[:2] - [60.0, 40.0]) @ normal) < 0.2
    assert abs((moved[2:] - [60.0, 40.0]) @ normal) < 0.2
