"""Nearly round parts in a frame: is their turn about their own axis seen?

Rims fit at any such turn, and only bolts, a hatch or a lug tell. Where these are out of sight, noise holds
the pose as exactly as if they were seen, and from frame to frame it slips around.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from geometry.model import Model
from geometry.near_symmetries import near_symmetries
from geometry.pose import Pose
from geometry.round_axes import ALONG, round_axes, turns_about_axes
from vision_server.pose.support import support_at
from vision_server.pose.trust import RIVAL_NATS
from vision_server.tracking.following import Found

COARSER = 2.0  # times the spacing of the samples (chosen by hand)


@lru_cache(maxsize=8)
def turns_about_own_axes(model: Model) -> tuple[Pose, ...]:
    """Turns of a model about each axis that it is nearly round about, onto petals or teeth too."""
    turns: list[Pose] = []
    for (axis, _), about_it in zip(round_axes(model), turns_about_axes(model), strict=True):
        turns += about_it
        for turn in near_symmetries(model):
            vector = turn.rotation_vector
            if abs(vector @ axis) >= ALONG * np.linalg.norm(vector):
                turns.append(turn)
    return tuple(turns)


def turn_is_seen(found: Found, model: Model) -> bool:
    """Whether a frame supports a pose more than those turned about an axis of a nearly round model."""
    turns = turns_about_own_axes(model)
    if not turns:
        return True
    own, *others = (
        support_at(found.problem, pose, COARSER * found.softness.spacing_px)
        for pose in [found.pose, *(found.pose.compose(turn) for turn in turns)]
    )
    most = max((one.evidence for one in others if one is not None), default=-math.inf)
    return own is not None and most <= own.evidence - RIVAL_NATS
