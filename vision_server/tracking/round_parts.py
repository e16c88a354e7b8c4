"""Nearly round parts in a frame: is their turn about their own axis seen?

Rims fit at any such turn, and only bolts, a hatch or a lug tell. Where these are out of sight, noise holds
the pose as exactly as if they were seen, and from frame to frame it slips around.
"""

from __future__ import annotations

import math

from geometry.model import Model
from geometry.turns import turns_about_round_axes
from vision_server.pose.support import support_at
from vision_server.pose.trust import RIVAL_NATS
from vision_server.tracking.following import Found

COARSER = 2.0  # times the spacing of the samples (chosen by hand)


def turn_is_seen(found: Found, model: Model) -> bool:
    """Whether a frame supports a pose more than those turned about an axis of a nearly round model."""
    turns = turns_about_round_axes(model)
    if not turns:
        return True
    own, *others = (
        support_at(found.problem, pose, COARSER * found.softness.spacing_px)
        for pose in [found.pose, *(found.pose.compose(turn) for turn in turns)]
    )
    most = max((one.evidence for one in others if one is not None), default=-math.inf)
    return own is not None and most <= own.evidence - RIVAL_NATS
