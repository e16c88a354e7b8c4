"""Of the poses of a first sight that one is first which is likely right, not that of most evidence."""

from dataclasses import replace

import numpy as np
import pytest

from geometry.model import Model
from geometry.pose import Pose
from geometry.symmetries import ASYMMETRIC, Symmetry
from tests.vision_server.refined_poses import channels_of, scaled
from tests.vision_server.synthetic import CAMERA, POSE, linear_picture, photographed
from vision_server.pose.observation import PoseProblem
from vision_server.trust import likely, rivals
from vision_server.trust.alternatives import LEAST_LISTED_CHANCE, distinct_of, listed, shares
from vision_server.trust.equal_parts import A_PART_NATS
from vision_server.trust.likely import likely_of
from vision_server.trust.probability import RIVAL_NATS
from vision_server.trust.ranking import Refined, refined
from vision_server.trust.rivals import rivals_at_first_sight
from vision_server.trust.settling import Settled

UNMOVED = Pose(np.zeros(3), np.zeros(3))
QUARTER, HALF = (Pose(np.array([0.0, 0.0, angle]), np.zeros(3)) for angle in (np.pi / 2.0, np.pi))
TWO_SIDES = Symmetry((UNMOVED, HALF), None, np.zeros(3))
EXACT_RAD, VAGUE_RAD = 0.001, 0.1


@pytest.fixture(scope="module")
def right(model: Model) -> Refined:
    pixels = photographed(linear_picture(model, CAMERA, POSE))
    problem = PoseProblem.at_scale(channels_of(pixels), model, CAMERA)
    found = refined(scaled(problem, POSE), POSE, (4.0, 3.0), 2.0)
    assert found is not None
    return found


def without_a_line(one: Refined) -> Refined:
    """The same, its first visible line unseen."""
    samples = one.support.samples
    supports = one.support.supports & (samples.line != samples.line[0])
    return replace(one, support=replace(one.support, supports=supports))


def turned(one: Refined, turn: Pose) -> Refined:
    return replace(one, solution=replace(one.solution, pose=one.pose.compose(turn)))


@pytest.mark.parametrize("wrong_sd_rad", [EXACT_RAD, VAGUE_RAD])
def test_a_vague_pose_of_more_evidence_is_not_first(
    right: Refined, wrong_sd_rad: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    wrong, right = turned(right, QUARTER), without_a_line(right)
    assert wrong.support.evidence > right.support.evidence
    sds = {id(wrong): wrong_sd_rad, id(right): EXACT_RAD}
    monkeypatch.setattr(likely, "last_step", lambda one: Settled(one, sds[id(one)] ** 2 * np.eye(6) * 0.1))
    found = likely_of([wrong, right], ASYMMETRIC)
    assert found[0].refined is (right if wrong_sd_rad == VAGUE_RAD else wrong)
    assert found[0].probability >= found[1].probability
    assert found[0].probability + found[1].probability < 1.0


def test_the_last_step_is_done_for_each(right: Refined) -> None:
    (found,) = likely_of([right], ASYMMETRIC)
    assert found.last.best.pose.error_to(POSE).within(0.1, 0.001)
    assert found.probability > 0.9
    assert likely_of([], ASYMMETRIC) == []


def test_evidence_is_that_after_the_last_step(right: Refined, monkeypatch: pytest.MonkeyPatch) -> None:
    """One that was left beside its edges may come to explain as much as the first, which is not sure then."""
    left, wrong = without_a_line(right), turned(right, QUARTER)
    ends = {id(left): right, id(wrong): wrong}
    monkeypatch.setattr(likely, "last_step", lambda one: Settled(ends[id(one)], EXACT_RAD**2 * np.eye(6)))
    found = likely_of([wrong, left], ASYMMETRIC)
    assert found[0].nats == found[1].nats == right.support.evidence_together
    assert found[0].probability == pytest.approx(found[1].probability)
    assert [one.nats for one in rivals_at_first_sight(found, ASYMMETRIC)] == [0.0]


def test_poses_without_the_last_step_are_held_to_gain_as_much(
    right: Refined, monkeypatch: pytest.MonkeyPatch
) -> None:
    left = without_a_line(right)
    monkeypatch.setattr(likely, "MOST_SETTLED", 1)
    monkeypatch.setattr(likely, "last_step", lambda _one: Settled(right, EXACT_RAD**2 * np.eye(6)))
    found = likely_of([left, turned(left, QUARTER)], ASYMMETRIC)
    assert found[0].nats == found[1].nats == right.support.evidence_together


def test_nothing_speaks_against_a_turn_where_there_is_no_seed_pose(
    right: Refined, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rivals, "turned", lambda best: [(best.pose.compose(HALF), best.support)])
    found = likely_of([right], ASYMMETRIC)
    assert [(one.nats, one.turned) for one in rivals_at_first_sight(found, ASYMMETRIC)] == [(0.0, True)]
    assert rivals_at_first_sight(found, TWO_SIDES) == []


def test_images_of_a_pose_by_a_symmetry_are_not_distinct() -> None:
    assert distinct_of([POSE, POSE.compose(HALF), POSE.compose(QUARTER)], TWO_SIDES) == [0, 2]


def test_poses_at_one_place_share_what_there_is() -> None:
    first, second = shares(np.array([RIVAL_NATS, 0.0]), np.zeros((2, 2), dtype=bool))
    assert first + second == pytest.approx(1.0)
    assert first / second == pytest.approx(np.e)


def test_convincing_poses_elsewhere_share_nothing() -> None:
    elsewhere = ~np.eye(2, dtype=bool)
    assert min(shares(A_PART_NATS * np.array([3.0, 2.0]), elsewhere)) > 0.99
    weak = shares(A_PART_NATS * np.array([0.5, 0.5]), elsewhere)
    assert weak == pytest.approx([0.5, 0.5])


def test_of_many_poses_those_are_listed_that_noise_may_have_put_last() -> None:
    turned = [POSE.compose(Pose(np.array([0.0, 0.0, 0.2 * k]), np.zeros(3))) for k in range(30)]
    assert len(listed([(one, 0.005) for one in turned], ASYMMETRIC)) == 30
    assert len(listed([(one, 0.003) for one in turned], ASYMMETRIC)) == 0


def test_images_by_a_symmetry_share_a_probability() -> None:
    other = POSE.compose(QUARTER)
    poses = listed([(POSE, 0.8), (other, 0.9 * LEAST_LISTED_CHANCE)], TWO_SIDES)
    assert [one.probability for one in poses] == [0.4, 0.4]
    assert poses[1].pose.error_to(POSE.compose(HALF)).within(1e-6, 1e-6)
    allowed = listed([(POSE, 0.8)], TWO_SIDES, lambda pose: pose is POSE)
    assert [one.probability for one in allowed] == [0.8]
