"""A target that is turned farther than it can be since it was last seen surely is a look-alike."""

from __future__ import annotations

import numpy as np
import pytest

from geometry.model import TARGETS, load_model
from geometry.pose import Pose
from vision_server.tracking.turning import AT_ONCE_DEG, RATE_DEG_S, Turning

SEEN = Pose(np.array([0.3, -0.2, 0.1]), np.array([0.0, 0.0, 1.0]))
HALF = Pose(np.array([0.0, np.pi, 0.0]), np.zeros(3))


def turned(degrees: float) -> Pose:
    return SEEN.stepped(np.radians([0.0, 0.0, degrees, 0.0, 0.0, 0.0]))


@pytest.mark.parametrize("seconds", [0.0, 0.5])
def test_it_can_have_turned_by_what_the_time_allows(seconds: float) -> None:
    turning = Turning(load_model(TARGETS / "satellite.cao"))
    turning.seen(SEEN)
    turning.passed(seconds)
    limit = AT_ONCE_DEG + RATE_DEG_S * seconds
    assert turning.allows(turned(limit - 1.0))
    assert not turning.allows(turned(limit + 1.0))
    assert not turning.allows(SEEN.compose(HALF))


def test_anything_may_be_before_it_was_seen_and_long_after() -> None:
    turning = Turning(load_model(TARGETS / "satellite.cao"))
    assert turning.allows(SEEN.compose(HALF))
    turning.seen(SEEN)
    turning.passed(2.0)
    assert turning.allows(SEEN.compose(HALF))


def test_a_turn_that_changes_nothing_is_none() -> None:
    turning = Turning(load_model(TARGETS / "cube.cao"))
    turning.seen(SEEN)
    assert turning.allows(SEEN.compose(HALF))
    assert not turning.allows(turned(40.0))
