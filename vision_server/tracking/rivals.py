"""Rivals of the followed pose: what a search could not rule out, each later frame is asked about again."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from geometry.pose import Pose
from vision_server.tracking.following import Found
from vision_server.trust.alternatives import EQUIVALENT_WITHIN
from vision_server.trust.judgement import Estimate
from vision_server.trust.probability import RIVAL_NATS, SHARED
from vision_server.trust.support import support_at

# By hand. A target that has turned so far shows another side; a frame in which it has turned less tells the
# less of its rivals.
ANOTHER_VIEW_DEG = 15.0
# By hand: by the first, poses that show the same differ; one frame may tell the second at most; and below the
# third a rival is refined before it is taken for so unlikely.
CHANCE_NATS, MOST_NATS, BEHIND_NATS = 0.5, 5.5, -2.0


@dataclass
class _Rival:
    """Where it is in the target's frame as it is followed, and the logarithm of its odds against that."""

    turn: Pose
    log_odds: float

    @property
    def lives(self) -> bool:
        """Whether it is still asked about."""
        return self.log_odds >= math.log(SHARED)


class Rivals:
    """Of one followed pose.

    Attributes
    ----------
    unasked : chance over it of those that only searches weigh: other models, and poses beside it, which print
        shows in all frames alike.
    """

    def __init__(self) -> None:
        self._rivals: list[_Rival] = []
        self.unasked = 0.0
        self._seen: Pose | None = None  # the last pose that was asked about

    @property
    def ambiguity(self) -> float:
        """Chance of the likeliest rival over the followed pose's, 0 (unique) to 1 (as good)."""
        return max(self.asked, self.unasked)

    @property
    def asked(self) -> float:
        """That of those that frames are asked about: look-alikes."""
        return max((math.exp(one.log_odds) for one in self._rivals if one.lives), default=0.0)

    def found(self, estimate: Estimate, goes_on: bool) -> None:
        """What a search found; if its pose ``goes_on`` from the one that was followed, so do known rivals."""
        known = self._rivals if goes_on else []
        self._rivals, self.unasked = list(known), 0.0
        if estimate.pose is None:
            return
        self._seen = estimate.pose
        for rival in estimate.rivals:
            if rival.pose.error_to(estimate.pose).within(*EQUIVALENT_WITHIN):
                self.unasked = max(self.unasked, rival.share)
                continue
            if rival.share < SHARED:
                continue
            told = math.log(rival.share)
            same = [
                one
                for one in known
                if estimate.pose.compose(one.turn).error_to(rival.pose).within(*EQUIVALENT_WITHIN)
            ]
            for one in same:
                one.log_odds = min(one.log_odds, told)
            if not same:
                self._rivals.append(_Rival(estimate.pose.inverse().compose(rival.pose), told))
        if estimate.misfit is not None:
            self.unasked = max(self.unasked, min(estimate.misfit.otherwise, 1.0))

    def weigh(self, followed: Found, refined: Callable[[Pose], Found | None]) -> None:
        """Ask a frame about each that lives: it supports the ``followed`` pose so much, and the rival?

        What the frame makes of a pose, ``refined`` tells.
        """
        if self._seen is None:
            return
        another = min(followed.pose.error_to(self._seen).rotation_deg / ANOTHER_VIEW_DEG, 1.0)
        self._seen = followed.pose
        for rival in self._rivals:
            if rival.lives:
                told = _told(rival, followed, refined)
                beyond = min(max(abs(told) - CHANCE_NATS, 0.0), MOST_NATS - CHANCE_NATS)
                rival.log_odds = min(rival.log_odds + another * math.copysign(beyond, told), 0.0)


def _told(rival: _Rival, followed: Found, refined: Callable[[Pose], Found | None]) -> float:
    """Log odds of a rival by one frame; where it has moved against the followed pose, it is followed, too."""
    pose = followed.pose.compose(rival.turn)
    support = support_at(followed.problem, pose, followed.softness.spacing_px)
    told = -math.inf if support is None else _log_odds(support.evidence, followed)
    if told >= BEHIND_NATS:
        return told
    again = refined(pose)
    if again is None or again.is_at(followed.pose):
        return told
    rival.turn = followed.pose.inverse().compose(again.pose)
    return max(told, _log_odds(again.evidence, followed))


def _log_odds(evidence: float, followed: Found) -> float:
    return (evidence - followed.evidence) / RIVAL_NATS
