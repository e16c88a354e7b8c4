"""How much of a target has to be seen for it to be followed, and to be found again."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from geometry.pose import Pose
from numerics.arrays import Floats
from vision_server.tracking.acceptance import (
    found_belief,
    is_exact,
    is_partly_whole,
    is_probable,
    is_sure,
    is_whole,
    keeps,
    whole_lines,
)
from vision_server.tracking.following import Found
from vision_server.tracking.motion import about
from vision_server.tracking.rivals import Rivals
from vision_server.trust.judgement import Estimate
from vision_server.trust.probability import Misfit, shared
from vision_server.trust.support import PoseSupport


def supported(*lines: tuple[float, float]) -> PoseSupport:
    """Lines of so many px and such support."""
    seen = [SimpleNamespace(visible_px=px, support=share) for px, share in lines]
    visible, share = np.array(lines).reshape(-1, 2).T
    return cast("PoseSupport", SimpleNamespace(lines=seen, by_line=(visible, share * visible)))


def believed(
    alone: float, pose: Pose | None = None, covariance: Floats | None = None, evidence: float = 20.0
) -> Found:
    """A pose that is believed so much without a rival, and explains what is seen by so many nats."""
    own = SimpleNamespace(
        pose=pose, covariance=covariance, evidence=evidence, belief=lambda ambiguity: shared(alone, ambiguity)
    )
    return cast("Found", own)


def alike(asked: float, unasked: float = 0.0) -> Rivals:
    """Rivals of such a chance."""
    told = SimpleNamespace(asked=asked, unasked=unasked, ambiguity=max(asked, unasked))
    return cast("Rivals", told)


@pytest.mark.parametrize(
    ("lines", "partly", "wholly"),
    [
        ([(100.0, 1.0)], True, True),
        ([(80.0, 0.5), (20.0, 0.75)], True, True),
        ([(81.0, 0.5), (19.0, 0.75)], False, True),
        ([(85.0, 0.3), (15.0, 0.29)], False, True),
        ([(84.0, 0.9), (16.0, 0.29)], True, False),
        ([], True, True),
    ],
)
def test_lines_count_by_their_length(lines: list[tuple[float, float]], partly: bool, wholly: bool) -> None:
    assert is_partly_whole(supported(*lines)) == partly
    assert is_whole(supported(*lines)) == wholly


def test_lines_that_were_seen_whole_are_kept_or_gone_by_their_length() -> None:
    before = whole_lines(supported((50.0, 1.0), (30.0, 0.8), (20.0, 0.2), (0.0, 0.0)))
    assert before.tolist() == [True, True, False, False]
    assert keeps(supported((50.0, 0.5), (12.0, 0.1), (20.0, 0.0), (9.0, 0.0)), before)  # 12 of 62
    assert not keeps(supported((50.0, 0.5), (13.0, 0.1), (20.0, 1.0), (9.0, 1.0)), before)  # 13 of 63
    assert keeps(supported((0.0, 0.0), (0.0, 0.0), (20.0, 0.0), (9.0, 0.0)), before)  # turned away


@pytest.mark.parametrize(
    ("misfit", "seen", "told"),
    [
        (Misfit(significance=5.0, gain=0.0), 1.0, 0.95),
        (Misfit(significance=5.0, gain=0.0), 0.2, 0.3),  # lines are missing
        (Misfit(significance=5.0, gain=0.1), 1.0, 0.3),  # a stretched model does better
        (Misfit(20.0, 0.0, (0.05, 0.0, 0.0, 0.0, 0.0, 0.0)), 1.0, 0.3),
        (None, 1.0, 0.3),
    ],
)
def test_whole_lines_make_up_for_a_low_score_where_no_other_model_does_better(
    misfit: Misfit | None, seen: float, told: float
) -> None:
    fitted = SimpleNamespace(belief=lambda _: 0.95, support=supported((80.0, 1.0), (20.0, seen)))
    assert found_belief(Estimate(score=0.3, misfit=misfit), cast("Found", fitted)) == told


def test_a_pose_that_explains_less_than_chance_does_is_not_probable() -> None:
    assert is_probable(believed(0.95, evidence=1.0), alike(0.0), stays=True)
    assert not is_probable(believed(0.95, evidence=-1.0), alike(0.0), stays=True)


def test_what_is_clearly_exact_is_so_by_draws_as_well(monkeypatch: pytest.MonkeyPatch) -> None:
    pose, rng = Pose(np.zeros(3), np.array([0.05, 0.0, 0.5])), np.random.default_rng(0)
    spreads = []
    for _ in range(60):
        half = rng.normal(size=(6, 6)) * np.repeat([0.01, 0.002], 3)[:, None] * 10.0 ** rng.uniform(-1, 0.3)
        spreads.append(about(-pose.translation, half @ half.T))
    quick = [is_exact(pose, spread) for spread in spreads]
    monkeypatch.setattr("vision_server.tracking.acceptance.EXACT_SIGMAS", np.inf)
    assert quick == [is_exact(pose, spread) for spread in spreads]
    assert 10 < sum(quick) < 50


def test_what_is_less_likely_is_sure_after_a_sure_frame_and_exact_for_all_its_doubt() -> None:
    pose = Pose(np.zeros(3), np.array([0.0, 0.0, 0.5]))
    turned = [np.diag(np.repeat([np.radians(deg), 0.001], 3) ** 2) for deg in (0.3, 0.9)]
    exact, barely = (about(-pose.translation, spread) for spread in turned)
    assert is_sure(believed(0.9, pose, barely), alike(0.0), stays=False)
    assert is_sure(believed(0.76, pose, exact), alike(0.0), stays=True)
    assert not is_sure(believed(0.76, pose, exact), alike(0.0), stays=False)
    assert not is_sure(believed(0.76, pose, barely), alike(0.0), stays=True)
    assert is_sure(believed(0.9 - 1e-6, pose, barely), alike(0.0), stays=True)
    assert is_sure(believed(0.95, pose, barely), alike(0.1), stays=False)
    assert not is_sure(believed(0.95, pose, exact), alike(0.3), stays=False)
    assert is_sure(believed(0.95, pose, exact), alike(0.3), stays=True)
    assert not is_sure(believed(0.95, pose, exact), alike(0.7), stays=True)


@pytest.mark.parametrize(
    ("alone", "ambiguity", "stays", "probable"),
    [
        (0.9, 0.1, False, True),
        (0.9, 0.12, False, False),
        (0.89, 0.0, False, False),
        (0.89, 0.7, True, True),
        (0.89, 0.9, True, False),
    ],
)
def test_lines_and_rivals_are_asked_each_for_itself_of_what_was_not_believed(
    alone: float, ambiguity: float, stays: bool, probable: bool
) -> None:
    assert is_probable(believed(alone), alike(ambiguity), stays) == probable


def test_rivals_that_no_frame_is_asked_about_lower_what_lines_tell() -> None:
    assert is_probable(believed(0.98), alike(0.0, 0.08), stays=False)
    assert not is_probable(believed(0.96), alike(0.0, 0.08), stays=False)
    assert is_probable(believed(0.96), alike(0.08, 0.0), stays=False)
