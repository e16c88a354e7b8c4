"""Following a cuboid: sure while it is right, lost when it is gone, found again; and odd frames."""

import itertools
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.films import CAMERA as film_camera  # noqa: N811
from benchmarks.films import film
from benchmarks.printed_boxes import sharp
from bridge.errors import BadInput
from bridge.vision_messages import MOST_TIME
from geometry.model import Model
from geometry.pose import Pose
from geometry.rotation import matrix_of
from tests.vision_server.synthetic import CAMERA, POSE
from tests.vision_server.tracking.boxes import TURNS, pictured, plain_box, seen_at
from tests.vision_server.tracking.films import NEAR, filmed, moving
from vision_server.tracking import acceptance
from vision_server.tracking import tracker as tracking
from vision_server.tracking.acceptance import is_elsewhere, is_exact, is_likely, is_sure, told_covariance
from vision_server.tracking.fitting import Habits
from vision_server.tracking.following import Found, Sight, turned_about
from vision_server.tracking.frame import Tone
from vision_server.tracking.motion import about
from vision_server.tracking.rivals import Rivals
from vision_server.tracking.searching import Searches
from vision_server.tracking.tracked import Tracked
from vision_server.tracking.tracker import EXPECTED_CHI2, LOOKED_AT_ANEW, SURPRISING_CHI2, Tracker
from vision_server.tracking.usual import Usual
from vision_server.trust.judgement import Estimate
from vision_server.trust.probability import Misfit

BETTER = Misfit(significance=0.0, gain=1.0)  # another model than the given one does


def followed(model: Model, poses: list[Pose | None]) -> list[Tracked]:
    tracker = Tracker(model, CAMERA, NEAR)
    return [tracker.step(frame) for frame in filmed(model, poses)]


def test_a_moving_target_is_followed_surely(model: Model) -> None:
    poses = moving(20, still=3)
    told = followed(model, list(poses))
    for true, one in zip(poses, told, strict=True):
        assert one.pose is not None
        assert one.pose.error_to(true).within(0.3, 0.003)
    states = [one.state for one in told]
    assert states.count("sure") >= 18
    assert [one.frame for one in told] == list(range(20))


def test_what_the_motion_hardly_expects_does_not_stay_sure(
    model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    told = []

    def heard(found: Found, rivals: Rivals, stays: bool) -> bool:
        told.append(stays)
        return is_sure(found, rivals, stays)

    monkeypatch.setattr(acceptance, "is_sure", heard)
    tracker = Tracker(model, CAMERA, POSE)
    for number, frame in enumerate(filmed(model, [POSE] * 5)):
        monkeypatch.setattr(tracking, "EXPECTED_CHI2", -1.0 if number == 3 else EXPECTED_CHI2)
        tracker.step(frame)
    assert told[-3:] == [True, False, True]


def test_covariances_are_honest(model: Model) -> None:
    poses = moving(40, still=40)
    squares = []
    for one in followed(model, list(poses)):
        assert one.pose is not None
        assert one.covariance is not None
        step = POSE.step_from(one.pose)
        squares.append(step @ np.linalg.solve(one.covariance, step))
    assert np.mean(np.array(squares) <= 16.81) >= 0.97


def test_a_target_that_leaves_is_lost_at_once_and_found_again(model: Model) -> None:
    poses: list[Pose | None] = [*moving(6), *[None] * 6, *moving(6)]
    told = followed(model, poses)
    assert {one.state for one in told[7:12]} == {"lost"}
    assert told[8].pose is None
    assert told[8].covariance is None
    assert told[-1].state == "sure"
    assert told[-1].pose is not None
    assert poses[-1] is not None
    assert told[-1].pose.error_to(poses[-1]).within(0.3, 0.003)


def test_a_jump_that_no_motion_foresees_is_found(model: Model) -> None:
    far = Pose(POSE.rotation_vector, POSE.translation + np.array([0.025, 0.01, 0.0]))  # 27 px
    told = followed(model, [POSE, POSE, POSE, far, far, far])
    for one in told[3:]:
        assert one.pose is not None
        assert one.pose.error_to(far).within(0.3, 0.003)
    assert told[-1].state == "sure"


def test_a_pose_nearby_that_loses_lines_seen_before_is_not_taken_for_the_target() -> None:
    """From frame 19 on of this film, other lines of the satellite fit as well beside the foreseen pose."""
    satellite, shown = film(40002, "eighth", 120)
    tracker: Tracker | None = None
    for seen in itertools.islice(shown, 21):
        tracker = tracker or Tracker(satellite, film_camera, seen.pose)
        told = tracker.step(seen.pixels, seen.time_s)
        assert told.pose is not None
        assert told.pose.error_to(seen.pose).within(1.0, 0.01)


def test_from_a_pose_that_looks_nearly_the_same_a_turn_leads_to_the_right_one() -> None:
    model, shown = film(68001, "eighth", 120)
    seen = next(itertools.islice(shown, 40, None))
    sight, habits = Sight(model, film_camera, Tone.of(1.0, 0.01)), Habits.of(model, None)
    beside = turned_about(seen.pose, model.middle, np.radians([-8.9, 3.7, 0.3]))
    found = sight.near(seen.pixels, beside, habits)
    assert found is not None
    assert found.pose.error_to(seen.pose).rotation_deg > 9.0
    better = sight.turned(seen.pixels, [found], habits)
    assert better[-1].pose.error_to(seen.pose).rotation_deg < 0.3
    assert sight.turned(seen.pixels, [better[-1]], habits) == []


def test_another_thing_is_never_sure(model: Model) -> None:
    rng = np.random.default_rng(0)
    tracker = Tracker(model, CAMERA, NEAR)
    blocks = np.kron(rng.integers(20, 220, (6, 8)), np.ones((40, 40)))
    for _ in range(6):
        frame = np.clip(blocks + rng.normal(0, 2, blocks.shape), 0, 255).astype(np.uint8)
        assert tracker.step(frame).state != "sure"


def test_a_frozen_camera_and_a_clock_that_goes_back_are_said(model: Model) -> None:
    frame = next(filmed(model, [POSE]))
    tracker = Tracker(model, CAMERA, NEAR)
    assert tracker.step(frame, 1.0).note == ""
    assert "frozen" in tracker.step(frame, 1.1).note
    assert "goes back" in tracker.step(next(filmed(model, [POSE], 0.7)), 0.5).note


def test_a_frame_of_another_size_is_refused(model: Model) -> None:
    with pytest.raises(BadInput, match="Frame 0 has 100x80 px of uint8, the camera 320x240"):
        Tracker(model, CAMERA, NEAR).step(np.zeros((80, 100), np.uint8))


def test_a_frame_that_is_refused_moves_neither_number_nor_clock(model: Model) -> None:
    tracker, (frame,) = Tracker(model, CAMERA, NEAR), filmed(model, [NEAR])
    assert tracker.step(frame, 5.0).frame == 0
    with pytest.raises(BadInput, match="Frame 1 has 10x10"):
        tracker.step(np.zeros((10, 10), np.uint8), 9.0)
    told = tracker.step(frame, 6.0)
    assert (told.frame, "goes back" in told.note) == (1, False)


def test_after_the_longest_time_that_messages_tell_a_target_is_looked_for(model: Model) -> None:
    tracker, (frame,) = Tracker(model, CAMERA, NEAR), filmed(model, [NEAR])
    assert tracker.step(frame, -MOST_TIME).pose is not None
    assert tracker.step(frame, MOST_TIME).frame == 1


def test_what_a_search_finds_is_told_as_exactly_as_its_lines_are() -> None:
    """Rounded edges are off as whole lines; edge points alone would state a tenth of the error."""
    squares = []
    for number, turn in enumerate(TURNS):
        box, pose = plain_box(0.0015), seen_at(turn)
        told = Tracker(sharp(box), CAMERA, pose).step(pictured(box, pose, number))
        assert told.pose is not None
        assert told.covariance is not None
        step = pose.step_from(told.pose)
        squares.append(step @ np.linalg.solve(told.covariance, step))
    assert np.max(squares) < 16.81


def searches_say(monkeypatch: pytest.MonkeyPatch, said: Callable[[Estimate], Estimate]) -> None:
    """Make something else of what each search finds."""
    search = Searches.estimate
    monkeypatch.setattr(Searches, "estimate", lambda self, pixels: said(search(self, pixels)))


def test_a_pose_that_is_believed_but_not_exact_is_unsure_and_is_followed(
    model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    searches = list[Estimate]()

    def counted(found: Estimate) -> Estimate:
        searches.append(found)
        return found

    searches_say(monkeypatch, counted)
    monkeypatch.setattr("vision_server.tracking.acceptance.EXACT_SHARE", 1.1)
    monkeypatch.setattr("vision_server.tracking.acceptance.EXACT_SIGMAS", np.inf)
    poses = moving(12, still=3)
    told = followed(model, list(poses))
    assert {one.state for one in told} == {"unsure"}
    assert len(searches) == 1
    assert told[-1].pose is not None
    assert told[-1].pose.error_to(poses[-1]).within(0.3, 0.003)


@pytest.mark.parametrize(
    ("degrees", "percent", "exact"),
    [(0.5, 1.0, True), (0.5, 1.4, False), (1.1, 0.5, True), (2.0, 0.5, False)],
)
def test_a_sure_pose_is_known_to_three_degrees_and_two_percent(
    degrees: float, percent: float, exact: bool
) -> None:
    pose = Pose(np.zeros(3), np.array([0.0, 0.0, 0.5]))
    target = np.diag([np.radians(degrees) ** 2] * 3 + [1e-8, 1e-8, (0.005 * percent) ** 2])
    assert is_exact(pose, about(-pose.translation, target)) is exact


def test_what_searches_doubted_is_believed_when_as_many_believed_it(
    model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    scores = iter([0.4, 0.4, 0.95, 0.95])
    searches_say(monkeypatch, lambda found: replace(found, score=next(scores), misfit=BETTER))
    told = followed(model, list(moving(22, still=22)))
    first = next(k for k, one in enumerate(told) if one.state == "sure")
    assert first >= 3 * LOOKED_AT_ANEW
    assert next(scores, None) is None


def test_of_believed_poses_the_one_that_the_motion_foresees_is_taken(
    model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    tracker = Tracker(model, CAMERA, NEAR)
    frames = list(filmed(model, list(moving(4, still=4))))
    for frame in frames[:3]:
        tracker.step(frame)
    assert tracker._motion is not None
    expected = tracker._motion.after(1.0 / 30.0)
    right = tracker._sight.near(frames[3], expected.pose(model.middle), tracker._habits)
    assert right is not None
    turned = Pose.from_matrix(matrix_of(np.radians([0.0, 6.0, 0.0])) @ POSE.matrix, POSE.translation)
    spread = right.covariance + np.diag([4e-3] * 3 + [4e-6] * 3)
    other = replace(right, fit=replace(right.fit, pose=turned, covariance=spread))
    other.__dict__["quality"] = 1.2 * right.quality
    monkeypatch.setattr(Usual, "quality", right.quality / 0.4)
    assert tracker._motion is not None
    assert expected.innovation(turned, spread, model.middle).squared < SURPRISING_CHI2
    monkeypatch.setattr(Sight, "far", lambda *_: [other])
    monkeypatch.setattr(Sight, "near", lambda *_: right)
    assert tracker._followed(frames[3], expected) is right


def test_a_pose_that_is_followed_stays_where_a_search_finds_nothing_better(
    model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    first, later = iter([{"score": 0.5, "misfit": BETTER}]), {"pose": None, "score": 0.0}
    searches_say(monkeypatch, lambda found: replace(found, **next(first, later)))
    poses = moving(12, still=3)
    told = followed(model, list(poses))
    assert {one.state for one in told} == {"unsure"}
    for one, true in zip(told, poses, strict=True):
        assert one.pose is not None
        assert one.pose.error_to(true).within(0.3, 0.003)


def test_a_low_score_whose_lines_are_there_is_followed_and_never_sure(
    model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = list[Estimate]()

    def scored(found: Estimate) -> Estimate:
        seen.append(replace(found, score=0.1, misfit=BETTER))
        return seen[-1]

    searches_say(monkeypatch, scored)
    told = followed(model, list(moving(8, still=8)))
    assert {one.state for one in told} == {"unsure"}
    assert seen[0].support is not None
    assert is_likely(seen[0], known=True)
    monkeypatch.setattr("vision_server.tracking.acceptance.MISSING_SUPPORT", 1.1)  # as if no line were seen
    assert not is_likely(seen[0], known=True)
    assert is_likely(seen[0], known=False)
    assert not is_likely(replace(seen[0], pose=None), known=False)


def test_what_is_hardly_believed_is_stated_with_wide_tails(
    model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    own = np.diag(np.arange(1.0, 7.0))
    widened = [told_covariance(own, belief)[5, 5] / 6.0 for belief in (1.0, 0.9, 0.5, 0.1, 0.0)]
    assert widened == sorted(widened)
    assert 1.0 < widened[0] < 0.5 * widened[2] < 0.1 * widened[4] < np.inf
    frames = list(filmed(model, list(moving(3, still=3))))
    told = []
    for belief in (None, 0.5):
        if belief is not None:
            monkeypatch.setattr(Found, "belief", lambda *_: 0.5)
        tracker = Tracker(model, CAMERA, NEAR)
        told.append([tracker.step(frame) for frame in frames])
    for own_one, doubted in zip(*told, strict=True):
        assert own_one.covariance is not None
        assert doubted.covariance is not None
        assert np.trace(doubted.covariance[:3, :3]) > 2.0 * np.trace(own_one.covariance[:3, :3])


@pytest.mark.parametrize(("belief", "state"), [(0.89, "unsure"), (0.91, "sure")])
def test_what_has_lost_most_of_its_support_is_sure_only_where_it_is_believed_anew(
    model: Model, monkeypatch: pytest.MonkeyPatch, belief: float, state: str
) -> None:
    tracker = Tracker(model, CAMERA, NEAR)
    frames = list(filmed(model, list(moving(5, still=5))))
    assert [tracker.step(frame).state for frame in frames[:4]] == ["sure"] * 4
    monkeypatch.setattr(Usual, "quality", tracker._usual.quality / 0.3)
    monkeypatch.setattr(Found, "belief", lambda *_: belief)
    told = tracker.step(frames[4])
    assert told.state == state
    assert told.pose is not None
    assert told.pose.error_to(POSE).within(0.3, 0.003)
    assert tracker._history.believed


@pytest.mark.parametrize(("belief", "state"), [(0.65, "sure"), (0.55, "unsure"), (0.95, "sure")])
def test_what_is_hardly_believed_any_more_is_followed_and_not_sure(
    model: Model, monkeypatch: pytest.MonkeyPatch, belief: float, state: str
) -> None:
    frames = list(filmed(model, list(moving(4))))
    tracker = Tracker(model, CAMERA, POSE)
    assert [tracker.step(pixels).state for pixels in frames[:3]] == ["sure"] * 3
    monkeypatch.setattr(Found, "belief", lambda self, ambiguity: belief)
    told = tracker.step(frames[3])
    assert told.state == state
    assert told.pose is not None


def test_doubts_of_a_thing_elsewhere_do_not_count(model: Model) -> None:
    aside = np.array([1.2 * model.diameter, 0.0, 0.0])
    assert not is_elsewhere(POSE, NEAR, model)
    assert is_elsewhere(Pose(POSE.rotation_vector, POSE.translation + aside), NEAR, model)
