"""How far off a pose may be where many lines hold it, and where one does."""

import numpy as np
import pytest

from numerics.arrays import Floats
from vision_server.trust.tails import Held, with_tails

FREEDOM = 1.5
SD_PX = 0.05  # of a line's place
LIMITS = np.array([0.0175, 0.0175, 0.0175, 0.005, 0.005, 0.005])  # a degree, and 1 % of half a metre
UNKNOWNS = 9


def held(lines_of: list[int], places: dict[int, float] | None = None) -> Held:
    """So many lines hold each of the six unknowns of a step; some of the first one's lie elsewhere, px."""
    of_unknown = np.repeat(np.arange(6), lines_of)
    motion = np.zeros((len(of_unknown), 2, UNKNOWNS))
    per_px = LIMITS[of_unknown]  # 1 px by a degree or 1 %
    motion[np.arange(len(of_unknown)), 0, of_unknown] = 1.0 / (SD_PX * per_px)
    place = np.zeros((len(of_unknown), 2))
    for line, px in (places or {}).items():
        place[line, 0] = px / SD_PX
    return Held(place, motion, np.ones(len(of_unknown)), np.full(UNKNOWNS, 1e-6), FREEDOM)


def curvature(of: Held) -> Floats:
    """Covariance (6, 6) as reweighted least squares has it where every line is in its place."""
    weight = (FREEDOM + 2.0) / FREEDOM
    normal = weight * np.einsum("mik,mil->kl", of.motion, of.motion) + np.diag(of.prior)
    return np.asarray(np.linalg.inv(normal)[:6, :6])


def test_where_many_lines_hold_a_pose_its_curvature_tells_how_far_off_it_is() -> None:
    many = held([40] * 6)
    covariance = curvature(many)
    wide = with_tails(covariance, LIMITS, many, np.zeros(UNKNOWNS), 1.0)
    assert np.sqrt(np.diag(wide)) == pytest.approx(np.sqrt(np.diag(covariance)), rel=0.05)


def test_what_one_line_holds_may_be_off_by_several_times_as_much() -> None:
    """And the others by what they were."""
    few = held([1, 40, 40, 40, 40, 40])
    covariance = curvature(few)
    wide = with_tails(covariance, LIMITS, few, np.zeros(UNKNOWNS), 1.0)
    ratio = np.sqrt(np.diag(wide) / np.diag(covariance))
    assert ratio[0] > 2.0
    assert ratio[1:] == pytest.approx(1.0)


def test_a_line_elsewhere_widens_what_two_others_hold() -> None:
    alike, contrary = held([3, 40, 40, 40, 40, 40]), held([3, 40, 40, 40, 40, 40], {0: 0.6})
    covariance = curvature(alike)
    by_three, by_two = (
        with_tails(covariance, LIMITS, one, np.zeros(UNKNOWNS), 1.0)[0, 0] for one in (alike, contrary)
    )
    assert by_two > 1.5 * by_three


def test_more_scatter_is_no_more_tail() -> None:
    """As much wider as the lines scatter, and the tails with it."""
    many = held([40] * 6)
    covariance = curvature(many)
    wide = with_tails(4.0 * covariance, LIMITS, many, np.zeros(UNKNOWNS), 4.0)
    assert np.sqrt(np.diag(wide) / np.diag(covariance)) == pytest.approx(2.0, rel=0.1)
