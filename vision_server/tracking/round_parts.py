"""Nearly round parts in a frame: is their turn about their own axis seen?

Rims fit at any such turn, and only bolts, a hatch or a lug tell. Where these are out of sight, noise holds
the pose as exactly as if they were seen, and from frame to frame it slips around. Where an arm hid them, it
may be held at other edges that are where theirs should be.

A frame that may be sure is asked about a few turns where the frame before was sure, and about all of them
where it was not; where none was sure for a while, whether any turn at all is seen better.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from geometry.model import Model
from geometry.pose import RIGHT
from geometry.turns import spin_rad, turns_about_round_axes
from numerics.arrays import Floats
from vision_server.tracking.acceptance import HELD
from vision_server.tracking.fitting import Habits
from vision_server.tracking.following import Found, looked_again
from vision_server.trust.probability import RIVAL_NATS
from vision_server.trust.spun import all_around
from vision_server.trust.support import support_at

TURNED_COARSENING = 2.0  # samples are so much sparser, as turns are many (by hand)
# After a sure frame so many turns are asked about that were the likeliest when last asked about, and one
# more, in each frame another. Of 288 frames of six films ten to twelve turns leave 23 unsure, these three 22.
LIKELIEST_TURNS = 2
TURNS_REFINED = 3  # of all around, those that most speaks for (by hand)
# By which a pose has to be ahead of all turns then: right ones mostly were by 16 nats and more; one that was
# held at other edges after an arm had passed, off by 16 degrees, by 6 and less.
CLEAR_NATS = 10.0
# By which it is ahead of them after a frame whose turn was not seen: one that had slipped by 2.6 degrees was
# by 3, right ones mostly by more.
SEEN_AGAIN_NATS = 6.0
SURE_LATELY_FRAMES = 5  # after a sure frame; later a turn has to be looked for all around (by hand)


class RoundTurns:
    """Of one target, from frame to frame: what was seen of its turns about its own axes."""

    def __init__(self, model: Model) -> None:
        self._model, self._turns = model, turns_about_round_axes(model)
        self._ahead: Floats = np.zeros(len(self._turns))  # by how many nats of each turn, when last asked
        self._slips = False  # whether the turn was not seen when a frame was last asked
        self._sure_at: int | None = None  # the last frame whose turn was seen

    def asked(self, found: Found, habits: Habits, frame: int) -> tuple[bool, Found | None]:
        """Whether the turn of a pose is seen that is sure else, and another pose if that is seen better."""
        if not self._turns:
            return True, None
        ago = None if self._sure_at is None else frame - self._sure_at
        if ago is None or ago > SURE_LATELY_FRAMES:
            other = self._elsewhere(found, habits)
            if other is not None and other.evidence > found.evidence - CLEAR_NATS:
                better = other.evidence > found.evidence + RIVAL_NATS and other.belief(0.0) >= HELD
                return False, other if better else None
        count = len(self._turns)
        few = {*np.argsort(self._ahead)[:LIKELIEST_TURNS].tolist(), frame % count}
        least = SEEN_AGAIN_NATS if self._slips else RIVAL_NATS
        seen = self._are_less(found, few if ago == 1 else range(count), least)
        self._sure_at, self._slips = frame if seen else self._sure_at, not seen
        return seen, None

    def is_seen(self, found: Found) -> bool:
        """Whether a frame supports a pose more than those turned about an axis of a nearly round model."""
        return self._are_less(found, range(len(self._turns)))

    def _are_less(self, found: Found, some: Collection[int], least: float = RIVAL_NATS) -> bool:
        """Whether each of some turns is supported less than a pose, by so many nats at ``least``."""
        if not some:
            return True
        spacing_px = TURNED_COARSENING * found.softness.spacing_px
        own = support_at(found.problem, found.pose, spacing_px, pulls=False)  # as its fit has offsets
        if own is None:
            return False
        for number in some:
            pose = found.pose.compose(self._turns[number])
            other = support_at(found.problem, pose, spacing_px, pulls=False)
            self._ahead[number] = np.inf if other is None else own.evidence - other.evidence
        return all(self._ahead[number] >= least for number in some)

    def _elsewhere(self, found: Found, habits: Habits) -> Found | None:
        """Of the poses at other turns, the one that a frame supports best."""
        spacing_px = TURNED_COARSENING * found.softness.spacing_px
        turned = all_around(found.problem, found.pose, spacing_px, spin_rad(self._model), TURNS_REFINED)
        looked = [one for start in turned if (one := looked_again(found, start, habits, RIGHT)) is not None]
        others = [one for one in looked if not one.pose.error_to(found.pose).within(*RIGHT)]
        return max(others, key=lambda one: one.evidence, default=None)
