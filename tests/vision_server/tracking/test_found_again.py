"""What was turned far in a gap of the film, or never believed, is found by searches of everything."""

from __future__ import annotations

import numpy as np
import pytest

from geometry.model import TARGETS, Model, load_model
from geometry.pose import Pose
from geometry.rotation import matrix_of
from tests.vision_server.synthetic import CAMERA, POSE
from tests.vision_server.tracking.films import filmed
from vision_server.matching.match import Anywhere
from vision_server.tracking.following import turned_about
from vision_server.tracking.searching import EVERYWHERE_FOLLOWED_AFTER, everywhere_is_due
from vision_server.tracking.tracker import LOOKED_AT_ANEW, Tracker
from vision_server.tracking.turning import AT_ONCE_DEG, Turning
from vision_server.trust.judgement import Estimate


def test_what_a_gap_has_turned_farther_than_a_target_turns_is_found_and_sure_when_seen_twice(
    model: Model,
) -> None:
    turned = turned_about(POSE, model.middle, np.radians([0.0, 0.0, 35.0]))
    tracker = Tracker(model, CAMERA, POSE)
    told = [tracker.step(frame) for frame in filmed(model, [*[POSE] * 3, *[turned] * 12])]
    right = [one.pose is not None and one.pose.error_to(turned).within(0.5, 0.005) for one in told]
    first = right.index(True)
    assert first <= 6
    assert told[first].state == "unsure"
    assert all(right[first:])
    assert told[first + 2 * LOOKED_AT_ANEW - 1].state == "sure" or told[-1].state == "sure"


@pytest.mark.parametrize(
    ("target", "turn", "alike"),
    [
        ("satellite.cao", np.array([0.0, np.pi, 0.0]), True),
        ("satellite.cao", np.radians([0.0, 0.0, 40.0]), False),
    ],
)
def test_a_look_alike_is_what_a_half_turn_or_a_near_symmetry_leads_to(
    target: str, turn: np.ndarray, alike: bool
) -> None:
    turning = Turning(load_model(TARGETS / target))
    turning.seen(POSE)
    pose = POSE.compose(Pose.from_matrix(matrix_of(turn), np.zeros(3)))
    assert not turning.allows(pose)
    assert turning.is_look_alike(pose) == alike
    assert AT_ONCE_DEG < 40.0


def test_what_does_not_stand_out_is_not_found_where_it_cannot_be(model: Model) -> None:
    turning = Turning(model)
    assert not turning.stands_out(Estimate())


def test_what_is_followed_and_never_believed_is_soon_looked_for_as_at_first(
    model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    starts: list[object] = []

    def doubted(*given: object, turn_known: bool) -> Estimate:
        assert turn_known
        starts.append(given[4])
        return Estimate(score=0.5)

    monkeypatch.setattr("vision_server.tracking.searching.estimate_pose", doubted)
    tracker, first = Tracker(model, CAMERA, Anywhere()), Anywhere()
    tracker._history.last = POSE
    for _ in range(EVERYWHERE_FOLLOWED_AFTER):
        tracker._searches.estimate(np.zeros((CAMERA.height, CAMERA.width), np.uint8))
    assert starts == [POSE] * EVERYWHERE_FOLLOWED_AFTER + [first]


def test_of_searches_in_vain_each_so_many_th_is_of_everything() -> None:
    assert [vain for vain in range(13) if everywhere_is_due(vain, lost=True)] == [6, 12]
    assert [vain for vain in range(10) if everywhere_is_due(vain, lost=False)] == [4, 8]
