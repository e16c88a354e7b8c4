"""A nearly round part's turn about its own axis is seen where its lug is."""

import numpy as np
import pytest

from benchmarks.machined_parts import circle, drilled, surface_of
from benchmarks.synthetic_parts import rendered
from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import RIGHT, Pose
from geometry.rotation import matrix_of
from geometry.turns import turns_about_round_axes
from vision_server.pose.observation import PoseProblem
from vision_server.tracking import round_parts
from vision_server.tracking.fitting import Habits
from vision_server.tracking.following import Found, Sight
from vision_server.tracking.frame import Tone
from vision_server.tracking.round_parts import RoundTurns
from vision_server.trust.support import PoseSupport, support_at

CAMERA = Camera(640, 480, 768.0, 768.0, 319.5, 239.5)
LUG = np.array([[0.02, -0.01], [0.04, -0.01], [0.04, 0.01], [0.02, 0.01]])


def disc() -> Model:
    """A disc of 100 mm; a lug stands on its far side."""
    solids = [drilled(circle(0.05, 48), [], -0.02, 0.0), drilled(LUG, [], 0.0, 0.03)]
    return Model.of_surface("disc", surface_of(solids))


def at(tilt_deg: float, turn_deg: float, model: Model) -> Pose:
    """Turned about its axis, which is tilted to the line of sight."""
    turn = matrix_of(np.radians([0.0, tilt_deg, 0.0])) @ matrix_of(np.radians([0.0, 0.0, turn_deg]))
    return Pose.from_matrix(turn, np.array([0.0, 0.0, 0.3]) - turn @ model.middle)


def found_at(model: Model, true: Pose, start: Pose) -> Found:
    pixels = rendered(model, CAMERA, true, np.random.default_rng(2))
    found = Sight(model, CAMERA, Tone.of(1.0, 0.01)).near(pixels, start, Habits.of(model))
    assert found is not None
    return found


@pytest.mark.parametrize(("tilt_deg", "seen"), [(30.0, False), (150.0, True)])
def test_a_turn_is_seen_where_the_lug_is(tilt_deg: float, seen: bool) -> None:
    model = disc()
    pose = at(tilt_deg, 40.0, model)
    found = found_at(model, pose, pose)
    assert RoundTurns(model).is_seen(found) == seen
    assert RoundTurns(model).asked(found, Habits.of(model), 0) == (seen, None)


@pytest.mark.parametrize("off_deg", [15.0, -40.0])
def test_where_no_frame_was_sure_lately_a_turn_that_is_seen_better_takes_the_place(off_deg: float) -> None:
    model = disc()
    true, habits = at(150.0, 40.0, model), Habits.of(model)
    slipped = found_at(model, true, at(150.0, 40.0 + off_deg, model))
    assert slipped.pose.error_to(true).rotation_deg > 8.0
    seen, better = RoundTurns(model).asked(slipped, habits, 0)
    assert not seen and better is not None
    assert better.pose.error_to(true).within(*RIGHT)


def test_after_a_sure_frame_few_turns_are_asked_about(monkeypatch: pytest.MonkeyPatch) -> None:
    model, asked = disc(), list[Pose]()

    def counted(problem: PoseProblem, pose: Pose, spacing_px: float, pulls: bool) -> PoseSupport | None:
        asked.append(pose)
        return support_at(problem, pose, spacing_px, pulls)

    monkeypatch.setattr(round_parts, "support_at", counted)
    pose, turns = at(150.0, 40.0, model), RoundTurns(model)
    found, counts = found_at(model, pose, pose), []
    for frame in (0, 1, 2, 5):  # frames 3 and 4 were not sure
        assert turns.asked(found, Habits.of(model), frame) == (True, None)
        counts.append(len(asked))
        asked.clear()
    assert counts[0] == counts[3] == 1 + len(turns_about_round_axes(model))
    assert max(counts[1:3]) <= 4


def test_a_turn_that_was_not_seen_has_to_be_seen_more_clearly_before_it_is_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    model = disc()
    habits, turns = Habits.of(model), RoundTurns(model)
    clear, hidden = (found_at(model, pose, pose) for pose in (at(150.0, 40.0, model), at(30.0, 40.0, model)))
    assert turns.asked(clear, habits, 0) == (True, None)
    least = float(turns._ahead.min())
    for ahead, seen in ((least - 1.0, True), (least + 1.0, False)):
        monkeypatch.setattr(round_parts, "SEEN_AGAIN_NATS", ahead)
        again = RoundTurns(model)
        frames = ((0, clear), (2, hidden), (3, clear), (4, clear))  # after frame 1 all turns are asked about
        told = [again.asked(found, habits, frame)[0] for frame, found in frames]
        assert told == [True, False, seen, seen]
