"""How far a frame is looked at: near, farther, everywhere."""

import numpy as np
import pytest

from geometry.model import Model
from geometry.pose import Pose
from tests.vision_server.synthetic import CAMERA
from tests.vision_server.tracking.films import NEAR, filmed, moving
from vision_server.channels.depth import Pixels
from vision_server.matching.match import Anywhere
from vision_server.tracking.fitting import Habits
from vision_server.tracking.following import Foreseen, Found, Sight
from vision_server.tracking.searching import EVERYWHERE_AFTER
from vision_server.tracking.tracker import OUTER_ASKED_FRAMES, Tracker
from vision_server.tracking.usual import Usual
from vision_server.trust.judgement import Estimate


@pytest.fixture
def looks(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """From how many poses each look farther around began."""
    looks, far = list[int](), Sight.far

    def counted(self: Sight, pixels: Pixels, expected: list[Pose], habits: Habits) -> list[Found]:
        looks.append(len(expected))
        return far(self, pixels, expected, habits)

    monkeypatch.setattr(Sight, "far", counted)
    return looks


def test_after_a_frame_that_was_not_followed_surely_other_poses_are_looked_at(
    model: Model, looks: list[int]
) -> None:
    tracker = Tracker(model, CAMERA, NEAR)
    counts = []
    for frame in filmed(model, list(moving(4, still=4))):
        tracker.step(frame)
        counts.append(len(looks))
    assert counts == [0, 1, 1, 1]


def test_where_the_motion_foresees_less_than_a_small_search_reaches_other_poses_are_looked_at(
    model: Model, looks: list[int]
) -> None:
    tracker = Tracker(model, CAMERA, NEAR)
    times = (0.0, 0.033, 0.067, 0.1, 0.133, 0.633)  # the last one half a second later
    counts = []
    for frame, time_s in zip(filmed(model, list(moving(6, still=6))), times, strict=True):
        assert tracker.step(frame, time_s).state == "sure"
        counts.append(len(looks))
    assert counts == [0, 1, 1, 1, 1, 2]


def test_where_a_steady_pose_is_believed_and_dim_the_last_one_is_not_looked_at(
    model: Model, looks: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    tracker, frames = Tracker(model, CAMERA, NEAR), list(filmed(model, list(moving(7))))
    for frame in frames[:5]:
        assert tracker.step(frame).state == "sure"
    looks.clear()
    monkeypatch.setattr(Usual, "shows", lambda *_: False)
    assert tracker.step(frames[5]).state == "sure"
    monkeypatch.setattr(Usual, "is_like_before", lambda *_: False)
    tracker.step(frames[6])
    assert looks == [1, 2]


def test_edges_outside_are_asked_about_now_and_then_while_frames_are_sure(
    model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked, near = list[bool](), Sight.near

    def noted(
        self: Sight, pixels: Pixels, expected: Pose, habits: Habits, foreseen: Foreseen | None = None
    ) -> Found | None:
        asked.append(foreseen is None or foreseen.outer)
        return near(self, pixels, expected, habits, foreseen)

    monkeypatch.setattr(Sight, "near", noted)
    tracker = Tracker(model, CAMERA, NEAR)
    for number, frame in enumerate(filmed(model, list(moving(5 + 2 * OUTER_ASKED_FRAMES)))):
        assert tracker.step(frame).state == "sure"
        if number < 5:
            asked.clear()
    assert asked.count(True) == 2 and len(asked) == 2 * OUTER_ASKED_FRAMES


def test_what_is_believed_and_hardly_seen_does_not_keep_it_from_looking_everywhere(
    model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    starts = []

    def elsewhere(*given: object, turn_known: bool) -> Estimate:
        assert turn_known
        starts.append(given[4])
        return Estimate(score=0.95)

    monkeypatch.setattr("vision_server.tracking.searching.estimate_pose", elsewhere)
    tracker = Tracker(model, CAMERA, NEAR)
    tracker._history.lost = 1  # it is lost
    for _ in range(EVERYWHERE_AFTER):
        tracker._searches.estimate(np.zeros((CAMERA.height, CAMERA.width), np.uint8))
    assert [isinstance(start, Anywhere) for start in starts] == [False] * EVERYWHERE_AFTER + [True]
