"""How soft lines are is kept while a target hardly moves, and looked at again where it does."""

import numpy as np
import pytest

from geometry.model import Model
from geometry.pose import Pose
from tests.vision_server.synthetic import CAMERA, POSE
from tests.vision_server.tracking.films import filmed, moving
from tests.vision_server.tracking.framed import problem
from vision_server.pose.observation import PoseProblem
from vision_server.tracking import softness
from vision_server.tracking.softness import KEPT_FRAMES, STILL_PX, Softness
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


def test_it_is_measured_now_and_then_of_what_stands_still_and_in_each_frame_of_what_moves(
    model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    count = 3 + 2 * (KEPT_FRAMES + 1)
    assert looks(model, moving(count, still=count), monkeypatch) == 2
    assert looks(model, moving(8), monkeypatch) == 5


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


def test_it_holds_near_where_it_was_for_the_lines_that_were_seen(model: Model) -> None:
    first = Softness.measured(problem(model, printed=False), POSE)
    assert not first.holds(model, CAMERA, POSE)
    line = np.array([0, 1, 2])
    once = first.kept(model, CAMERA, POSE, line, None)
    assert not once.holds(model, CAMERA, POSE)  # whether it moved is not known
    kept = first.kept(model, CAMERA, aside(1.0), line, once)
    assert kept.holds(model, CAMERA, POSE, line)
    assert not kept.holds(model, CAMERA, POSE, np.array([3]))
    assert not kept.holds(model, CAMERA, aside(1.0 + 1.2 * STILL_PX))
    for _ in range(KEPT_FRAMES):
        assert kept.holds(model, CAMERA, POSE)
        kept = kept.kept(model, CAMERA, POSE, line, kept)
    assert not kept.holds(model, CAMERA, POSE)


def test_what_was_measured_of_a_target_that_moved_is_not_kept(model: Model) -> None:
    first = Softness.measured(problem(model, printed=False), POSE)
    line = np.array([0, 1, 2])
    once = first.kept(model, CAMERA, POSE, line, None)
    blurred = first.kept(model, CAMERA, aside(1.2 * STILL_PX), line, once)
    assert not blurred.holds(model, CAMERA, aside(1.2 * STILL_PX))
