"""A pose is not sure where the target, tilted a little, explains the frame as well."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.films import CAMERA as film_camera  # noqa: N811
from benchmarks.films import film
from geometry.model import Model
from geometry.pose import Pose
from tests.vision_server.synthetic import CAMERA, POSE
from tests.vision_server.tracking.films import filmed
from vision_server.tracking import tilted
from vision_server.tracking.fitting import Habits
from vision_server.tracking.following import Found, Sight, turned_about
from vision_server.tracking.frame import Tone
from vision_server.tracking.tilted import KEPT, MOST_FRAMES, TURNED_DEG, Tilt
from vision_server.tracking.tracker import Tracker

BESIDE = Pose(POSE.rotation_vector, 1.02 * POSE.translation)


def seen(model: Model) -> Found:
    """The cuboid where it is."""
    found = Sight(model, CAMERA, Tone.of(1.0, 0.01)).near(next(filmed(model, [POSE])), POSE, Habits.of(model))
    assert found is not None
    return found


def turned(found: Found, degrees: float) -> Found:
    """The same, as if the target were turned."""
    pose = turned_about(found.pose, found.problem.model.middle, np.radians([0.0, 0.0, degrees]))
    return replace(found, fit=replace(found.fit, pose=pose))


def squared(found: Found, pose: Pose) -> float:
    """How far a pose is from the found one, in units of its covariance."""
    step = pose.step_from(found.pose)
    return float(step @ np.linalg.solve(found.covariance, step))


def test_the_other_edges_of_a_thin_plate_are_another_pose_that_the_covariance_allows() -> None:
    model, shown = film(80078, "fast", 120)
    frame = next(itertools.islice(shown, 103, None))
    start = turned_about(frame.pose, model.middle, np.radians([0.6, 2.0, 0.6]))
    found = Sight(model, film_camera, Tone.of(1.0, 0.01)).near(frame.pixels, start, Habits.of(model))
    assert found is not None
    assert found.pose.error_to(frame.pose).rotation_deg > 2.0
    assert squared(found, frame.pose) > 20.0
    tilt = Tilt()
    told = tilt.asked(found, sure=True, at_once=True)
    assert tilt.is_likely
    assert squared(told, frame.pose) < 2.0


def test_a_cuboid_that_shows_three_sides_has_no_other_pose(
    model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tilted, "EXACT", 0.0)
    found, tilt = seen(model), Tilt()
    assert tilt.asked(found, sure=True, at_once=True) is found
    assert not tilt.is_likely


def test_it_is_looked_for_now_and_then_and_in_each_frame_after_it_was_found(
    model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    looks: list[bool] = []
    others: list[tuple[Pose, float]] = []

    def found_others(found: Found) -> list[tuple[Pose, float]]:
        looks.append(bool(others))
        return others

    monkeypatch.setattr(tilted, "EXACT", 0.0)
    monkeypatch.setattr(tilted, "_others", found_others)
    found, tilt = seen(model), Tilt()
    for _ in range(2 * MOST_FRAMES):
        tilt.asked(found, sure=False, at_once=True)
    assert looks == []
    for _ in range(1 + MOST_FRAMES):
        tilt.asked(found, sure=True, at_once=False)
    assert looks == [False, False]
    tilt.asked(turned(found, 0.9 * TURNED_DEG), sure=True, at_once=False)
    assert len(looks) == 2
    tilt.asked(turned(found, 1.1 * TURNED_DEG), sure=True, at_once=False)
    assert len(looks) == 3
    others.append((BESIDE, 0.0))
    assert squared(tilt.asked(found, sure=True, at_once=True), BESIDE) < 2.1
    others.clear()
    for _ in range(KEPT):
        assert tilt.is_likely
        tilt.asked(found, sure=False, at_once=False)
    assert not tilt.is_likely


def test_a_satellite_that_turns_its_thin_side_into_sight_is_never_sure_and_off() -> None:
    model, shown = film(80054, "fast", 120)
    tracker: Tracker | None = None
    states = []
    for frame in itertools.islice(shown, 80):
        tracker = tracker or Tracker(model, film_camera, frame.pose)
        told = tracker.step(frame.pixels, frame.time_s)
        states.append(told.state)
        if told.state == "sure":
            assert told.pose is not None
            assert told.pose.error_to(frame.pose).within(3.0, 0.02)
    assert states.count("sure") >= 20
    assert states[-1] == "sure"
