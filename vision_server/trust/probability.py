"""How sure an estimate is right: a calibrated probability from the evidence of its lines, and its rivals'.

Two logistic functions, fitted by `benchmarks.trust_fit` to estimates whose truth is known, give the belief in
a pose by itself; what its best rival explains divides it. docs/trust.md says how well both are calibrated.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

from geometry.pose import RIGHT
from vision_server.trust.support import NORMAL_FLOOR_PX, PoseSupport


class Coefficients(NamedTuple):
    """Of the two logistic functions: how much each input speaks for a pose's being right, as log odds.

    `benchmarks.trust_fit` fits them; docs/trust.md says to which estimates, and how well they are calibrated.
    """

    # By a pose's lines, as tracking believes it: fitted to 630 estimates of hard drawn scenes, a third with
    # wrong models.
    bias: float = -4.25
    log2_confirmed: float = 1.32  # of 1 + the evidence of the lines that are there, nats
    log2_missing: float = -1.25  # of 1 + the share of the visible length in missing lines over SOME_MISSING
    log_uncertainty: float = -1.07  # of the uncertainty over RIGHT_UNCERTAINTY
    log2_significance: float = -1.04  # of 1 + the squared stretch over USUAL_STRETCH_CHI2
    # Of a pose that has taken the last step: fitted to 2021 estimates of 310 drawn scenes. Missing lines do
    # not agree, and the uncertainty is in how far off the pose may be: neither counts twice.
    settled_bias: float = -6.53
    agreeing: float = 1.13  # of the log odds of the share of the visible length on lines that agree
    log_scatter: float = -1.01  # of how far lines are off, squared, over what was foreseen
    log2_stretch: float = -2.8  # in place of log2_significance
    # Of a target of many lines, in poor light, many agree and many are missing: what is confirmed beyond
    # MOST_CONFIRMED speaks for it, too. A fit to 300 estimates of docking gear has 0.6 to 0.75.
    log2_more: float = 0.66
    # Of the share of the visible length that is missing over MOSTLY_MISSING: an arm hides half of a part now
    # and then, a wrong model misses as much more often. By hand.
    mostly_missing: float = -10.0
    # Of how far from the pose its last step ends from beside it, over FAR_ASTRAY. By hand: 1653 drawn
    # estimates are the likelier the larger it is, up to 8 at least; one right one fewer is trusted.
    astray: float = -6.0


FITTED = Coefficients()
# Of what is confirmed more than so many nats is no further reason to believe, without and with the last step.
MOST_CONFIRMED, MOST_OF_ALL = 63.0, 255.0
SOME_MISSING, MOSTLY_MISSING = 0.1, 0.45  # shares of the visible length that are missing
AGREEMENT_ROOM, SCATTER_ROOM = 0.05, 0.02  # that keep the logarithms of agreement finite
FAR_ASTRAY = 0.3  # in what makes a pose wrong; of 742 right poses that are trusted five have more (by hand)
USUAL_STRETCH_CHI2 = 4.0  # squared stretch that true models hardly exceed
# Chance of another pose from which on lines that agree say nothing for this one: its rival shares them. By
# hand. Where the other is this one, turned onto a near symmetry, they speak for one of the two.
SHARED = 0.01
RIGHT_UNCERTAINTY = RIGHT[1]  # 1 % of the range or 1 degree, see `covariance.uncertainty`
LEAST_STRETCH = 0.01  # of an axis against another, for a fit to be of another part: what moves a pose by 1 %
# A model is wrong, not perhaps, from here on: of a true one, in 89 sets of two and five images of 45 scenes,
# the significance is 5.1 at most (benchmarks.wrong_models), and of 240 right poses of drawn scenes none
# leaves 20 nats to a stretched one.
SURELY_SIGNIFICANT, SURE_NATS = 10.0, 20.0
# Nats that a model is unlikely to be stretched. By hand: from 10 to 13 the likelihood of 534 drawn estimates,
# 329 of them with wrong models, hardly changes; stretched ones are looked for over two hundred ways.
STRETCHED_NATS = 12.0
# Nor is it so where lines that speak against the other model take back more than two fifths of what others
# speak for it: in poor light it fits what is there by chance. Of 19 ray-traced sessions with a wrong model
# 0.74 and more is left; of four with a true one, two of them at wrong poses, 0.46 at most.
LEAST_BORNE_OUT = 0.6
RIGHT_OF_WRONG_MODEL = 0.66  # share of such poses that are right: 23 of 35 with a model 2 % too long
# Of poses in hard light before the last step, over stated standard deviations: by their 90th percentile.
ERROR_OVER_SD = 1.3
RIVAL_NATS = 3.0  # of evidence between two poses, for odds of e: neighbouring lines speak together; by hand
# Doubts in the factors of a probability are often one doubt, which their product counts again. By hand: the
# likelihood of 1040 sessions on ray-traced scenes is largest at 1.2, of 618 drawn estimates at 1.2, of 513
# others at 1. More than this trusts more wrong models.
SETTLED_ODDS_POWER = 1.15
MOST_ODDS = 1000.0  # of another model; larger ones leave the pose no less belief
LEAST_UNCERTAINTY = 0.0005  # being surer than this is no further reason to believe
WORTH_DOUBTING = 0.05  # a less likely pose is not believed anyway
WORTH_TURNING = 0.8  # whether its model is the right way round; a less likely one is not trusted anyway


class Excess(NamedTuple):
    """A model that is too long along an axis by this share, beside the other two; less than 0: too short."""

    axis: int
    share: float


@dataclass(frozen=True)
class Misfit:
    """How much better another model would do: one that is stretched, or the other way round.

    Attributes
    ----------
    significance
        Squared stretch of the axes against each other in units of its covariance, where the lines are: of 2
        degrees of freedom for a true model.
    gain
        Evidence of the best stretched model beyond the model's own, nats; 0 for none.
    strain
        (6,), of that model, or of the lines where they are, see `stretch.stretched`.
    otherwise
        Chance of the model mirrored or turned by half over its own, see `other_hand`; may be over 1.
    borne_out
        Evidence of the better model over that of its confirmed lines: 1 where no line speaks against it.
    """

    significance: float
    gain: float
    strain: tuple[float, ...] = (0.0,) * 6
    otherwise: float = 0.0
    borne_out: float = 1.0

    @property
    def excess(self) -> Excess | None:
        """What is surely wrong with the model; None where nothing is, or much speaks against the other."""
        return self.suspected if self.borne_out >= LEAST_BORNE_OUT else None

    @property
    def suspected(self) -> Excess | None:
        """What is wrong with the model, by how much better another does, whatever speaks against that."""
        if self.significance < SURELY_SIGNIFICANT and self.gain < SURE_NATS:
            return None
        scales = self.strain[:3]
        beside = [1.5 * (scale - sum(scales) / 3.0) for scale in scales]  # against the mean of the other two
        axis = max(range(3), key=lambda one: abs(beside[one]))
        share = math.expm1(-beside[axis])
        return Excess(axis, share) if abs(share) >= LEAST_STRETCH else None


class LineAgreement(NamedTuple):
    """How well the lines of a pose agree on it: share of the length, and scatter, see `settling.Settled`.

    ``astray`` is how far from it its last step ends from beside it, see `restarts`; None where that was not
    looked at. ``contested`` is the chance of the likeliest other pose over it, turns of the target apart.
    """

    share: float
    scatter: float
    astray: float | None = None
    contested: float = 0.0


def quality(support: PoseSupport) -> float:
    """Normalised score times supported fraction over RMS; edges of saturated pixels count half."""
    discount = 1.0 - 0.5 * support.clipped_fraction
    normalised = max(0.0, (support.strength - 0.4) / 0.6)
    return discount * normalised * support.supported_fraction / max(support.rms_px, NORMAL_FLOOR_PX)


def confidence(
    support: PoseSupport,
    ambiguity: float,
    uncertainty: float,
    doubt: Misfit | None = None,
    agreement: LineAgreement | None = None,
    by: Coefficients = FITTED,
) -> float:
    """Probability, 0..1, that the pose is within 1 degree and 1 % of the range.

    That it is the right one by itself times that it is off by no more than it may be; after the last step,
    and where no other pose contests its lines, the odds of that to the power of SETTLED_ODDS_POWER. Its
    rivals then share it.
    """
    over = ERROR_OVER_SD if agreement is None else 1.0  # after the last step tails are in it, see `tails`
    within = math.erf(RIGHT_UNCERTAINTY / (math.sqrt(2.0) * over * max(uncertainty, 1e-9)))
    product = within * _by_itself(support, uncertainty, doubt, agreement, by)
    if _is_settled(agreement) and 0.0 < product < 1.0:
        product = 1.0 / (1.0 + math.pow(1.0 / product - 1.0, SETTLED_ODDS_POWER))
    return shared(product, _best_rival(ambiguity, doubt))


def belief(
    support: PoseSupport,
    ambiguity: float,
    uncertainty: float,
    doubt: Misfit | None = None,
    agreement: LineAgreement | None = None,
    by: Coefficients = FITTED,
) -> float:
    """Probability, 0..1, that the pose is the right one, however exact.

    That its lines are where they seem, times its share against its best rival, less where the model is surely
    wrong: its pose then is moved by what no line tells.

    Parameters
    ----------
    doubt
        What speaks against the model; None where the pose is not worth that look.
    agreement
        Of its lines; None where the last step was not taken.
    """
    return shared(_by_itself(support, uncertainty, doubt, agreement, by), _best_rival(ambiguity, doubt))


def _by_itself(
    support: PoseSupport,
    uncertainty: float,
    doubt: Misfit | None,
    agreement: LineAgreement | None,
    by: Coefficients,
) -> float:
    """Probability that the lines are where they seem, less where the model is surely wrong."""
    logit = _by_lines(support, uncertainty, doubt, by)
    if agreement is not None:
        settled = _settled(support, doubt, agreement, by)
        logit = settled if _is_settled(agreement) else min(settled, logit)
    right = 1.0 if doubt is None or doubt.suspected is None else RIGHT_OF_WRONG_MODEL
    return right / (1.0 + math.exp(-logit))


def _is_settled(agreement: LineAgreement | None) -> bool:
    """Whether lines that agree speak for a pose: it has taken the last step, and no other shares them."""
    return agreement is not None and agreement.contested < SHARED


def _best_rival(ambiguity: float, doubt: Misfit | None) -> float:
    """Chance of the likeliest other pose or other model over a pose's own."""
    return ambiguity if doubt is None else max(ambiguity, doubt.otherwise, stretched_odds(doubt))


def shared(belief: float, ambiguity: float) -> float:
    """What is left of a belief in a pose by itself, where a rival has such a chance over it."""
    return belief / (1.0 + ambiguity)


def _by_lines(support: PoseSupport, uncertainty: float, doubt: Misfit | None, by: Coefficients) -> float:
    """Log odds that the lines are where they seem."""
    logit = (
        by.bias
        + by.log2_confirmed * math.log2(1.0 + min(support.confirmed, MOST_CONFIRMED))
        + by.log2_missing * math.log2(1.0 + support.missing / SOME_MISSING)
        + by.log_uncertainty * math.log(max(uncertainty, LEAST_UNCERTAINTY) / RIGHT_UNCERTAINTY)
    )
    return logit + (0.0 if doubt is None else _of_stretch(doubt, by.log2_significance))


def _settled(support: PoseSupport, doubt: Misfit | None, agreement: LineAgreement, by: Coefficients) -> float:
    """The same, of a pose that has taken the last step."""
    share = agreement.share
    more = max(MOST_CONFIRMED, min(support.confirmed, MOST_OF_ALL))
    logit = (
        by.settled_bias
        + by.log2_confirmed * math.log2(1.0 + min(support.confirmed, MOST_CONFIRMED))
        + by.log2_more * math.log2((1.0 + more) / (1.0 + MOST_CONFIRMED))
        + by.agreeing * math.log((share + AGREEMENT_ROOM) / (1.0 + AGREEMENT_ROOM - share))
        + by.log_scatter * math.log(agreement.scatter + SCATTER_ROOM)
        + by.mostly_missing * max(0.0, support.missing - MOSTLY_MISSING)
    )
    if agreement.astray is not None:
        logit += by.astray * max(0.0, agreement.astray - FAR_ASTRAY)
    return logit + (0.0 if doubt is None else _of_stretch(doubt, by.log2_stretch))


def _of_stretch(doubt: Misfit, per_log2: float) -> float:
    """What edge points that ask for other axes speak against a pose, as log odds."""
    return per_log2 * math.log2(1.0 + doubt.significance / USUAL_STRETCH_CHI2)


def stretched_odds(doubt: Misfit) -> float:
    """Chance of a stretched model over a pose's own, at most MOST_ODDS; 0 where too little bears it out."""
    if doubt.gain <= 0.0 or doubt.borne_out < LEAST_BORNE_OUT:
        return 0.0
    return odds(doubt.gain - STRETCHED_NATS, MOST_ODDS)


def odds(nats: float, most: float = 1.0) -> float:
    """Chance of another pose over one that it explains so many nats more than, at most ``most``."""
    return math.exp(min(math.log(most), nats / RIVAL_NATS))


def ambiguity(rivals: Iterable[float]) -> float:
    """Chance of the likeliest of other poses, nats each, over one's own, 0 (unique) to 1 (as good)."""
    return max(map(odds, rivals), default=0.0)
