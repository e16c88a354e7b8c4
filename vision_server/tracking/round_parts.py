"""Nearly round parts in a frame: is their turn about their own axis seen?

Rims fit at any such turn, and only bolts, a hatch or a lug tell. Where these are out of sight, noise holds
the pose as exactly as if they were seen, and from frame to frame it slips around.
"""

from __future__ import annotations

from geometry.model import Model
from geometry.turns import turns_about_round_axes
from vision_server.pose.rivals import explaining
from vision_server.pose.support import support_at
from vision_server.pose.trust import RIVAL_NATS
from vision_server.tracking.following import Found

TURNED_COARSENING = 2.0  # samples are so much sparser, as turns are many (by hand)


def turn_is_seen(found: Found, model: Model) -> bool:
    """Whether a frame supports a pose more than those turned about an axis of a nearly round model."""
    turns = turns_about_round_axes(model)
    if not turns:
        return True
    spacing_px = TURNED_COARSENING * found.softness.spacing_px
    own = support_at(found.problem, found.pose, spacing_px)
    if own is None:
        return False
    turned = map(found.pose.compose, turns)
    return not any(explaining(found.problem, turned, [(spacing_px, own.evidence - RIVAL_NATS)]))
