"""The evidence of lines: what is seen speaks for a pose, what is missing hardly against it; rivals."""

import math

import numpy as np
import pytest

from geometry.visibility import Samples
from vision_server.pipeline import SURE_SCORE
from vision_server.trust.hidden_together import NOT_SEEN_NATS
from vision_server.trust.probability import (
    ERROR_OVER_SD,
    RIVAL_NATS,
    SETTLED_ODDS_POWER,
    SHARED,
    STRETCHED_NATS,
    LineAgreement,
    Misfit,
    ambiguity,
    belief,
    confidence,
    odds,
)
from vision_server.trust.rivals import TURNED_NATS
from vision_server.trust.support import PoseSupport

SPACING_PX, APART_PX = 2.0, 10.0


def support(*shares: float, length_px: float = 40.0, slack_px: float = 0.0) -> PoseSupport:
    """Of level lines of one length, one below the other, each seen along such a share of it."""
    count = int(length_px / SPACING_PX)
    line = np.repeat(np.arange(len(shares)), count)
    seen = np.concatenate([np.arange(count) < round(share * count) for share in shares])
    empty, along = np.zeros((len(line), 3)), SPACING_PX * np.tile(np.arange(count), len(shares))
    image, level = np.stack([along, APART_PX * line], axis=1), np.tile([1.0, 0.0], (len(line), 1))
    samples = Samples(empty, empty, line, image, level, np.full(len(line), SPACING_PX), line)
    return PoseSupport(
        rms_px=1.0, supported_fraction=float(seen.mean()), strength=0.5, clipped_fraction=0.0, names=["i1"],
        samples=samples, distance=np.where(seen, 0.1, 4.0), supports=seen[None],
        trust=np.ones((1, len(shares))), slack=np.full(len(line), slack_px),
    )  # fmt: skip


def test_a_line_that_is_not_seen_may_be_hidden() -> None:
    assert support(1.0, 1.0).evidence - support(1.0, 1.0, 0.0).evidence == pytest.approx(NOT_SEEN_NATS)
    assert support(1.0, 1.0).confirmed == support(1.0, 1.0, 0.0).confirmed
    assert support(1.0, 1.0, 0.0, 0.0).missing == 0.5


def test_edges_by_chance_are_no_evidence() -> None:
    assert support(0.5, 0.5).confirmed == 0.0
    assert support(0.9).confirmed > support(0.7).confirmed > 0.0


def test_a_rounded_crease_tells_less_as_any_of_some_parallels_may_be_its_edge() -> None:
    told = support(1.0).confirmed - support(1.0, slack_px=4.0).confirmed
    assert told == pytest.approx(np.log(5.0))


def test_a_long_line_is_one_line() -> None:
    assert support(1.0, length_px=400.0).confirmed == pytest.approx(support(1.0).confirmed)
    assert support(1.0, 1.0).confirmed == pytest.approx(2.0 * support(1.0).confirmed)


def test_a_rival_that_leaves_seen_lines_unexplained_is_none() -> None:
    """A dial turned by one of its twelve parts hides its lug: it misses nothing, but explains less."""
    right, turned = support(*[1.0] * 12, 0.9, 0.9, 0.9, 0.5), support(*[1.0] * 12)
    assert turned.supported_fraction > right.supported_fraction
    assert odds(turned.evidence - right.evidence) < 0.05


def test_of_poses_the_likeliest_is_the_doubt() -> None:
    assert odds(-RIVAL_NATS) == pytest.approx(math.exp(-1.0))
    assert odds(5.0) == 1.0
    assert odds(5.0, 2.0) == 2.0
    assert ambiguity([-20.0, -RIVAL_NATS]) == odds(-RIVAL_NATS)
    assert ambiguity([]) == 0.0


def test_a_turn_that_explains_as_much_leaves_trust_to_the_seed_pose() -> None:
    def score(confirmed: int, agreement: LineAgreement) -> float:
        own = support(*[1.0] * confirmed)
        return confidence(own, odds(-TURNED_NATS), 0.001, Misfit(0.0, 0.0), agreement)

    good, fair = LineAgreement(1.0, 0.05), LineAgreement(0.8, 0.3)
    assert score(3, fair) < SURE_SCORE < score(12, good) < 1.0 / (1.0 + math.exp(-TURNED_NATS / RIVAL_NATS))
    assert score(3, good._replace(contested=SHARED)) < SURE_SCORE < score(3, good)


def test_the_probability_falls_with_each_doubt() -> None:
    good = support(*[0.9] * 8)
    sure = confidence(good, 0.0, 0.001)
    assert sure > 0.93
    assert confidence(support(*[0.9] * 8, *[0.0] * 4), 0.0, 0.001) < sure
    assert confidence(support(*[0.9] * 3), 0.0, 0.001) < sure
    assert confidence(good, 0.0, 0.001, Misfit(30.0, 0.0)) < sure - 0.02
    assert confidence(good, 0.0, 0.001, Misfit(0.0, 1.0)) < sure - 0.02
    assert confidence(good, 1.0, 0.001) == pytest.approx(0.5 * sure)


def test_lines_that_are_seen_but_beside_their_place_are_doubted() -> None:
    good = support(*[0.9] * 8)
    shares = (0.0, 0.4, 0.7, 0.9, 1.0)
    believed = [confidence(good, 0.0, 0.001, None, LineAgreement(share, 0.3)) for share in shares]
    assert believed == sorted(believed)
    assert believed[0] < 0.3
    assert believed[-1] > 0.95


def test_lines_that_are_farther_off_than_was_foreseen_are_doubted() -> None:
    good = support(*[0.9] * 8)
    believed = [
        confidence(good, 0.0, 0.001, None, LineAgreement(0.8, scatter)) for scatter in (2.0, 0.5, 0.1)
    ]
    assert believed == sorted(believed)
    assert believed[0] < 0.9 < believed[-1]


def test_a_missing_line_counts_once() -> None:
    """It does not agree; that it is missing, besides, says no more."""
    agreement = LineAgreement(0.8, 0.3)
    some, more = support(*[0.9] * 8, 0.0), support(*[0.9] * 8, 0.0, 0.0, 0.0)
    assert confidence(more, 0.0, 0.001) < confidence(some, 0.0, 0.001)
    assert confidence(more, 0.0, 0.001, None, agreement) == confidence(some, 0.0, 0.001, None, agreement)


def test_a_pose_of_which_most_is_missing_is_not_trusted_however_well_the_rest_agrees() -> None:
    agreement = LineAgreement(0.4, 0.03)
    some, most = support(*[1.0] * 12, *[0.0] * 9), support(*[1.0] * 12, *[0.0] * 24)
    assert confidence(some, 0.0, 0.001, None, agreement) > 0.98
    assert confidence(most, 0.0, 0.001, None, agreement) < 0.93


def test_a_target_of_many_lines_is_believed_by_those_that_are_seen() -> None:
    """Of a truss in grazing sun half of the bars are dark, or in front of dark ones."""
    agreement = LineAgreement(0.5, 0.5)
    some, many = support(*[1.0] * 12, *[0.0] * 9), support(*[1.0] * 36, *[0.0] * 27)
    assert confidence(some, 0.0, 0.001, None, agreement) < SURE_SCORE
    assert confidence(many, 0.0, 0.001, None, agreement) > SURE_SCORE


def test_lines_that_another_pose_shares_do_not_speak_for_a_pose() -> None:
    good = support(*[0.9] * 8)
    alone = belief(good, 0.036, 0.001)
    assert belief(good, 0.036, 0.001, None, LineAgreement(1.0, 0.1, contested=0.036)) == alone
    assert belief(good, 0.036, 0.001, None, LineAgreement(0.4, 0.3, contested=0.036)) < alone


def test_lines_that_a_turn_of_the_target_shares_speak_for_one_of_the_two() -> None:
    good, agreed = support(*[0.9] * 8), LineAgreement(1.0, 0.1)
    alone = belief(good, 0.0, 0.001, None, agreed)
    assert belief(good, 0.036, 0.001, None, agreed) == pytest.approx(alone / 1.036)


def test_a_pose_that_may_be_off_by_a_degree_is_right_in_six_of_ten_cases_at_most() -> None:
    within = math.erf(1.0 / (math.sqrt(2.0) * ERROR_OVER_SD))
    assert confidence(support(*[1.0] * 20), 0.0, 0.01) <= within < 0.6


def test_a_stretched_model_is_a_rival_by_its_evidence() -> None:
    good, agreed = support(*[1.0] * 20), LineAgreement(1.0, 0.1)
    alone = belief(good, 0.0, 0.001, None, agreed)
    assert belief(good, 0.0, 0.001, Misfit(0.0, STRETCHED_NATS), agreed) == pytest.approx(0.5 * alone)
    assert belief(good, 0.0, 0.001, Misfit(0.0, STRETCHED_NATS + RIVAL_NATS), agreed) < 0.3 * alone
    assert belief(good, 0.0, 0.001, Misfit(0.0, STRETCHED_NATS, borne_out=0.5), agreed) == alone


def test_after_the_last_step_doubts_that_are_one_count_less() -> None:
    """What is likely is likelier, what is unlikely less likely, and what is even stays even."""
    for many, agreement in ((12, LineAgreement(1.0, 0.2)), (6, LineAgreement(0.5, 2.0))):
        seen, within = support(*[1.0] * many), math.erf(2.0 / math.sqrt(2.0))
        product = within * belief(seen, 0.0, 0.005, None, agreement)
        told = confidence(seen, 0.0, 0.005, None, agreement)
        assert math.log(told / (1.0 - told)) == pytest.approx(
            SETTLED_ODDS_POWER * math.log(product / (1.0 - product))
        )
