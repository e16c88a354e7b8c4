"""Which pose of a first sight is likely the right one: it has evidence, and it is exact.

Evidence says how many lines lie on edges. A pose that few lines hold can be moved until they do, and then has
as much of it as the right one, which is held by all; but by itself it would hardly be believed.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from geometry.symmetries import Symmetry
from vision_server.pose.covariance import pose_covariance, uncertainty
from vision_server.trust.alternatives import distinct_of, shares, without_free_turn
from vision_server.trust.places import apart
from vision_server.trust.probability import confidence
from vision_server.trust.ranking import Refined
from vision_server.trust.settling import Settled, settled

# Chosen by hand: what less evidence or a later place makes likely is under what an estimate lists.
LEAST_EVIDENCE_SHARE = 1e-3  # of all poses' evidence; with less, a pose is not looked at
MOST_SETTLED = 6  # poses that are taken the last step


class Likely(NamedTuple):
    """A refined pose, what the last step makes of it, and the probability that it is the right one."""

    refined: Refined
    last: Settled
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
    that it would be right with no other beside it.
    """
    if not found:
        return []
    out: list[Likely] = []
    distinct = [found[index] for index in distinct_of([one.pose for one in found], symmetry)]
    model, camera = found[0].problem.model, found[0].problem.camera
    elsewhere = apart(model, camera, [one.pose for one in distinct])
    nats = np.array([one.support.evidence_together for one in distinct])
    for one, share in zip(distinct, shares(nats, elsewhere), strict=True):
        if share >= LEAST_EVIDENCE_SHARE:
            last = last_step(one) if len(out) < MOST_SETTLED else _as_refined(one)
            pose = last.best.pose
            spread = uncertainty(without_free_turn(last.covariance, pose, symmetry), pose.translation)
            out.append(Likely(one, last, share * confidence(last.best.support, 0.0, spread)))
    return sorted(out, key=lambda one: -one.probability)
