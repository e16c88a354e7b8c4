"""Rivals that a search could not rule out: each later frame says more of them."""

from __future__ import annotations

import itertools
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from benchmarks.films import CAMERA as film_camera  # noqa: N811
from benchmarks.films import film
from geometry.pose import Pose
from geometry.rotation import matrix_of
from vision_server.tracking import rivals
from vision_server.tracking.following import Found
from vision_server.tracking.rivals import Rivals
from vision_server.tracking.tracker import Tracker
from vision_server.trust.judgement import Estimate, Rival
from vision_server.trust.probability import SHARED, Misfit

POSE = Pose(np.zeros(3), np.array([0.0, 0.0, 1.0]))
HALF = Pose(np.array([0.0, np.pi, 0.0]), np.zeros(3))
TURNED = POSE.compose(HALF)
MOVED = TURNED.stepped(np.array([0.0, 0.0, 0.2, 0.0, 0.0, 0.0]))


def turned(degrees: float) -> Pose:
    """The target, turned before the camera."""
    return Pose.from_matrix(matrix_of(np.radians([0.0, 0.0, degrees])), POSE.translation)


def seen(evidence: float, pose: Pose = POSE) -> Found:
    softness = SimpleNamespace(spacing_px=2.0)
    one = SimpleNamespace(pose=pose, evidence=evidence, problem=None, softness=softness)
    one.is_at = lambda other: Found.is_at(cast("Found", one), other)
    return cast("Found", one)


def nothing(_pose: Pose) -> Found | None:
    return None


def searched(share: float = 0.1, otherwise: float = 0.0) -> Estimate:
    doubt = Misfit(significance=0.0, gain=0.0, otherwise=otherwise)
    return Estimate(POSE, rivals=(Rival(TURNED, share),), misfit=doubt)


def supporting(monkeypatch: pytest.MonkeyPatch, evidence: float) -> list[Pose]:
    asked: list[Pose] = []

    def support_at(_problem: object, pose: Pose, _spacing: float) -> object:
        asked.append(pose)
        return SimpleNamespace(evidence=evidence)

    monkeypatch.setattr(rivals, "support_at", support_at)
    return asked


@pytest.mark.parametrize(
    ("evidence", "after"),
    [
        (40.0, 0.1),  # the same
        (39.0, 0.1),  # hardly less: by chance
        (34.0, 0.1 * np.exp(-1.5)),  # 2 log odds less, of which a half is by chance
        (0.0, 0.1 * np.exp(-5.0)),  # one look tells only so much
        (44.5, 0.1 * np.exp(1.0)),
        (99.0, 1.0),  # as likely as the followed pose, at most
    ],
)
def test_what_another_side_shows_weighs_a_rival_anew(
    monkeypatch: pytest.MonkeyPatch, evidence: float, after: float
) -> None:
    asked = supporting(monkeypatch, evidence)
    own = Rivals()
    own.found(searched(), goes_on=False)
    for degrees in (5.0, 10.0, 15.0):  # a look in three frames
        own.weigh(seen(40.0, turned(degrees)), nothing)
    assert own.ambiguity == pytest.approx(after if after > SHARED else 0.0)
    assert asked[0].error_to(turned(5.0).compose(HALF)).within(0.01, 1e-4)
    own.weigh(seen(40.0, turned(15.0)), nothing)  # the same once more
    assert own.ambiguity == pytest.approx(after if after > SHARED else 0.0)


def test_searches_of_the_followed_pose_only_speak_against_rivals_that_are_known(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    own = Rivals()
    own.found(searched(0.3), goes_on=False)
    own.found(searched(0.1), goes_on=True)
    assert own.ambiguity == pytest.approx(0.1)
    own.found(searched(0.3), goes_on=True)
    assert own.ambiguity == pytest.approx(0.1)
    asked = supporting(monkeypatch, 0.0)
    own.weigh(seen(40.0, turned(20.0)), nothing)
    own.found(searched(0.3), goes_on=True)
    assert own.ambiguity == 0.0
    own.weigh(seen(40.0, turned(40.0)), nothing)
    assert len(asked) == 1  # what has gone is not asked about
    own.found(searched(0.3), goes_on=False)
    assert own.ambiguity == pytest.approx(0.3)


def test_a_rival_that_turns_otherwise_than_the_followed_pose_is_followed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked = supporting(monkeypatch, 0.0)
    own = Rivals()
    own.found(searched(), goes_on=False)
    own.weigh(seen(40.0, turned(3.0)), lambda _pose: seen(39.0, MOVED))
    assert own.ambiguity == pytest.approx(0.1)  # refined, it is as good
    own.weigh(seen(40.0, turned(3.0)), nothing)
    assert asked[1].error_to(MOVED).within(0.01, 1e-4)


def test_a_pose_beside_is_no_look_alike(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = supporting(monkeypatch, 0.0)
    own = Rivals()
    own.found(Estimate(POSE, rivals=(Rival(turned(2.0), 0.2),)), goes_on=False)
    own.weigh(seen(40.0, turned(20.0)), nothing)
    assert asked == []
    assert (own.asked, own.unasked, own.ambiguity) == (0.0, 0.2, 0.2)


def test_other_models_are_looked_at_by_searches_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    supporting(monkeypatch, 0.0)
    own = Rivals()
    own.found(searched(otherwise=0.3), goes_on=False)
    own.weigh(seen(40.0), nothing)
    assert own.ambiguity == pytest.approx(0.3)
    own.found(Estimate(), goes_on=False)
    assert own.ambiguity == 0.0


def test_a_first_pose_with_a_rival_does_not_keep_frames_from_being_sure() -> None:
    """This part looks the same when it is turned by half, until other faces come into sight."""
    model, shown = film(67011, "lights", 120)
    tracker: Tracker | None = None
    states = []
    for one in itertools.islice(shown, 12):
        tracker = tracker or Tracker(model, film_camera, one.pose)
        states.append(tracker.step(one.pixels, one.time_s).state)
    assert states.count("sure") >= 11
