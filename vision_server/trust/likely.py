"""Which pose of a first sight is likely the right one: it has evidence, and it is exact.

Evidence says how many lines lie on edges. A pose that few lines hold can be moved until they do, and then has
as much of it as the right one, which is held by all; but by itself it would hardly be believed.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from geometry.symmetries import Symmetry
from numerics.two_cores import each
from vision_server.pose.covariance import pose_covariance, uncertainty
from vision_server.trust.alternatives import distinct_of, shares, without_free_turn
from vision_server.trust.equal_parts import apart
from vision_server.trust.probability import confidence
from vision_server.trust.ranking import Refined
from vision_server.trust.settling import Settled, settled

# Chosen by hand: what less evidence or a later place makes likely is under what an estimate lists.
LEAST_EVIDENCE_SHARE = 1e-3  # of all poses' evidence; with less, a pose is not looked at
MOST_SETTLED = 6  # poses that are taken the last step


class Likely(NamedTuple):
    """A refined pose, after the last step too, its evidence then, and the probability that it is right."""

    refined: Refined
    last: Settled
    nats: float
    probability: float


def last_step(one: Refined) -> Settled:
    """A pose after the last step, or, where too little holds it for that, as it was refined."""
    return settled(one) or _as_refined(one)


def _as_refined(one: Refined) -> Settled:
    """A pose without the last step."""
    return Settled(one, pose_covariance(one.solution))


def likely_of(found: Sequence[Refined], symmetry: Symmetry) -> list[Likely]:
    """The distinct ones of some poses, most evidence first, by the probability that they are right.

    That is the share of the evidence that a pose has among its rivals, see `shares`, times the probability
    that it would be right with no other beside it. The evidence is that after the last step, which may bring
    a pose that was left beside its edges as much as the first has; those that do not take it are held to gain
    as much as the first.
    """
    if not found:
        return []
    distinct = [found[index] for index in distinct_of([one.pose for one in found], symmetry)]
    model, camera = found[0].problem.model, found[0].problem.camera
    elsewhere = apart(model, camera, [one.pose for one in distinct])
    before = np.array([one.support.evidence_together for one in distinct])
    worth = np.flatnonzero(np.array(shares(before, elsewhere)) >= LEAST_EVIDENCE_SHARE)
    lasts = each(lambda index: last_step(distinct[index]), worth[:MOST_SETTLED].tolist())
    lasts += [_as_refined(distinct[index]) for index in worth[MOST_SETTLED:]]
    nats = np.array([last.best.support.evidence_together for last in lasts])
    nats[MOST_SETTLED:] += nats[0] - before[worth[0]]
    out = []
    after = shares(nats, elsewhere[np.ix_(worth, worth)])
    for index, last, own, share in zip(worth, lasts, nats, after, strict=True):
        pose = last.best.pose
        spread = uncertainty(without_free_turn(last.covariance, pose, symmetry), pose.translation)
        right = confidence(last.best.support, 0.0, spread)
        out.append(Likely(distinct[index], last, float(own), share * right))
    return sorted(out, key=lambda one: -one.probability)
