"""How soft lines are is kept while a target moves as it did, and looked at again where it does not."""

from dataclasses import replace

import numpy as np
import pytest

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from tests.vision_server.synthetic import CAMERA, POSE
from tests.vision_server.tracking.films import filmed, moving
from tests.vision_server.tracking.framed import problem
from vision_server.channels.depth import Pixels
from vision_server.pose.observation import PoseProblem
from vision_server.tracking import following, softness
from vision_server.tracking.following import turned_about
from vision_server.tracking.frame import Window, window
from vision_server.tracking.softness import KEPT_FRAMES, STEADY_PX, Softness
from vision_server.tracking.tracked import Tracked
from vision_server.tracking.tracker import Tracker


def aside(px: float) -> Pose:
    """The pose so many px farther to the right."""
    shift = px * POSE.translation[2] / CAMERA.fx
    return Pose(POSE.rotation_vector, POSE.translation + np.array([shift, 0.0, 0.0]))


def looks(model: Model, poses: list[Pose], monkeypatch: pytest.MonkeyPatch) -> int:
    """In how many frames of a film the softness is measured, the first three left out."""
    found: list[int] = []
    measured = Softness.measured

    def counted(problem: PoseProblem, pose: Pose) -> Softness:
        found.append(len(told))
        return measured(problem, pose)

    monkeypatch.setattr(Softness, "measured", counted)
    tracker, told = Tracker(model, CAMERA, POSE), list[Tracked]()
    for frame in filmed(model, list(poses)):
        told.append(tracker.step(frame))
    assert {one.state for one in told} == {"sure"}
    return len({number for number in found if number > 2})


@pytest.mark.parametrize("still", [0, 3 + 2 * (KEPT_FRAMES + 1)])
def test_it_is_measured_now_and_then_of_what_stands_still_or_moves_steadily(
    model: Model, monkeypatch: pytest.MonkeyPatch, still: int
) -> None:
    assert looks(model, moving(3 + 2 * (KEPT_FRAMES + 1), still=still), monkeypatch) == 2


def test_it_is_measured_again_when_what_moved_stops(model: Model, monkeypatch: pytest.MonkeyPatch) -> None:
    steady = [aside(8.0 * k) for k in range(6)]
    stopped = steady[:4] + [steady[3]] * 2
    assert looks(model, stopped, monkeypatch) > looks(model, steady, monkeypatch)


def test_poses_are_the_same_with_what_was_kept(model: Model, monkeypatch: pytest.MonkeyPatch) -> None:
    frames = list(filmed(model, list(moving(6, still=6))))
    told = [Tracker(model, CAMERA, POSE) for _ in range(2)]
    kept = [told[0].step(frame).pose for frame in frames]
    monkeypatch.setattr(softness, "KEPT_FRAMES", 0)
    anew = [told[1].step(frame).pose for frame in frames]
    for one, other in zip(kept, anew, strict=True):
        assert one is not None
        assert other is not None
        assert one.error_to(other).within(0.01, 0.0001)


def test_it_holds_where_the_target_went_on_for_the_lines_that_were_seen(model: Model) -> None:
    first = Softness.measured(problem(model, printed=False), POSE)
    assert not first.holds(model, CAMERA, POSE)
    line = np.array([0, 1, 2])
    once = first.kept(model, CAMERA, POSE, line, None)
    assert not once.holds(model, CAMERA, POSE)  # whether it moved is not known
    kept = first.kept(model, CAMERA, aside(10.0), line, once)
    assert kept.holds(model, CAMERA, aside(20.0), line)
    assert kept.holds(model, CAMERA, aside(20.0 + 0.8 * STEADY_PX))
    assert not kept.holds(model, CAMERA, aside(20.0 + 1.2 * STEADY_PX))
    assert not kept.holds(model, CAMERA, aside(10.0))
    assert not kept.holds(model, CAMERA, aside(20.0), np.array([0, 1, 3]))
    for number in range(KEPT_FRAMES):
        assert kept.holds(model, CAMERA, aside(10.0 * (number + 2)))
        kept = kept.kept(model, CAMERA, aside(10.0 * (number + 2)), line, kept)
    assert not kept.holds(model, CAMERA, aside(10.0 * (KEPT_FRAMES + 2)))


def test_it_does_not_hold_where_lines_have_turned_against_the_way_they_go(model: Model) -> None:
    first = Softness.measured(problem(model, printed=False), POSE)
    line, fast = np.array([0, 1, 2]), 30.0
    once = first.kept(model, CAMERA, POSE, line, None)
    kept = first.kept(model, CAMERA, aside(fast), line, once)
    on = aside(2.0 * fast)
    assert kept.holds(model, CAMERA, on)
    turned = turned_about(on, model.middle, np.radians([0.0, 0.0, 10.0]))
    shift = CAMERA.project(turned.apply(model.vertices)) - CAMERA.project(on.apply(model.vertices))
    slow = first.kept(model, CAMERA, aside(fast), line, first.kept(model, CAMERA, aside(fast), line, None))
    assert np.abs(shift).max() > STEADY_PX and not slow.holds(model, CAMERA, turned)
    rest = replace(slow, pixels=CAMERA.project(turned.apply(model.vertices)))  # it turned there, slowly
    assert rest.holds(model, CAMERA, turned)
    gone = replace(kept, pixels=CAMERA.project(turned.apply(model.vertices)) - kept.step)
    assert not gone.holds(model, CAMERA, turned)


def test_what_no_longer_holds_is_measured_where_the_target_was_found(
    model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    poses = [aside(5.0 * k) for k in range(5)] + [aside(20.0)]  # it goes on, and then it stops
    tracker, measured, windows = Tracker(model, CAMERA, POSE), list[Pose](), list[Pose]()
    frames = list(filmed(model, poses))
    for frame in frames[:-1]:
        tracker.step(frame)
    own = Softness.measured

    def measured_at(seen: PoseProblem, pose: Pose) -> Softness:
        measured.append(pose)
        return own(seen, pose)

    def window_at(
        pixels: Pixels, model: Model, camera: Camera, pose: Pose, margin_px: float
    ) -> Window | None:
        windows.append(pose)
        return window(pixels, model, camera, pose, margin_px)

    monkeypatch.setattr(Softness, "measured", measured_at)
    monkeypatch.setattr(following, "window", window_at)
    assert tracker.step(frames[-1]).state == "sure"
    assert len(windows) == 1, "the frame was looked at anew"
    assert len(measured) == 1
    assert measured[0].error_to(poses[-1]).within(0.05, 0.0005)
