"""Lines that are not seen have one cause where they are together, and none where others are seen between."""

import numpy as np
import pytest

from numerics.arrays import Floats
from vision_server.trust.hidden_together import NOT_SEEN_NATS, ONE_CAUSE_PX, OWN_SHARE, evidence_of


def places(count: int, apart_px: float) -> Floats:
    return np.column_stack([apart_px * np.arange(count), np.zeros(count)])


@pytest.mark.parametrize("count", [1, 5, 40])
def test_lines_apart_count_as_if_each_stood_alone(count: int) -> None:
    nats = np.full(count, -2.0 * NOT_SEEN_NATS)
    assert evidence_of(nats, places(count, ONE_CAUSE_PX)) == pytest.approx(-NOT_SEEN_NATS * count)


@pytest.mark.parametrize("count", [2, 10, 50])
def test_lines_at_one_place_are_hidden_by_one_cause(count: int) -> None:
    nats = np.full(count, -2.0 * NOT_SEEN_NATS)
    told = evidence_of(nats, places(count, 0.0))
    assert told == pytest.approx(-NOT_SEEN_NATS * (1.0 - OWN_SHARE + OWN_SHARE * count))


def test_what_is_seen_between_them_says_that_nothing_hides_them() -> None:
    hidden, between = np.full(6, -NOT_SEEN_NATS), np.full(3, NOT_SEEN_NATS)
    together = evidence_of(np.concatenate([hidden, between]), places(9, 0.0))
    alone = evidence_of(between, places(3, 0.0)) - 6.0 * NOT_SEEN_NATS
    elsewhere = np.concatenate([places(6, 0.0), places(3, 0.0) + 1e3])
    apart = evidence_of(np.concatenate([hidden, between]), elsewhere)
    assert together == pytest.approx(alone)
    assert apart > together + 4.0


def test_what_is_seen_counts_in_full() -> None:
    nats = np.array([0.5, 3.0, 7.0])
    assert evidence_of(nats, places(3, 1.0)) == pytest.approx(10.5)
