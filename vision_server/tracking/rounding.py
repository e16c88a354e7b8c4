"""Whether a target whose edges' radius nobody told has rounded ones, by what frames show of both.

Along the lines of a sharp model little is seen of rounded edges, or print inside of them. By how much they
are rounded, frames hardly tell: a smaller radius farther away shows nearly the same. So one radius is tried,
known to a half, and a pose on it is as exact as that allows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from geometry.pose import Pose
from geometry.roundings import sharp_and_convex
from vision_server.channels.depth import Pixels
from vision_server.tracking.fitting import Habits
from vision_server.tracking.following import Found, Sight
from vision_server.tracking.lines import shorter_length

# By hand, by three ray-traced films of boxes with roundings of 3.5 to 8 % of their shorter sides: anything
# from 3 % on is right in eight of ten looks or more, where sharp edges are in half.
TRIED_SHARE, TRIED_SD_SHARE = 0.045, 0.5  # radius over the shorter lines; its sd over itself
MOST_NATS = 8.0  # that one frame speaks for rounded edges, or against them
ROUNDED_FROM_NATS = 16.0  # from which sum on they are taken for rounded, for good


class Rounding:
    """Of one target, from frame to frame, until its edges are taken for rounded."""

    def __init__(self, sight: Sight, told: bool) -> None:
        self._sharp, self._nats = sight, 0.0
        radius_m = TRIED_SHARE * shorter_length(sight.model)
        self.sight = replace(sight, model=replace(sight.model, edge_radius_m=radius_m))
        self.habits = Habits.of(self.sight.model, radius_m)._replace(radius_sd_m=TRIED_SD_SHARE * radius_m)
        self.is_open = not told and len(sight.model.faces) > 0 and bool(sharp_and_convex(sight.model).any())

    def is_shown(self, pixels: Pixels, found: Found | None, around: Sequence[Pose], habits: Habits) -> bool:
        """Whether edges are rounded, by one more frame in which the sharp model is not believed.

        Parameters
        ----------
        found : what was followed, if anything.
        around : poses that the target may be near to, where nothing was.
        habits : of the sharp model.
        """
        if found is not None:
            rounded = [one for one in (self.sight.near(pixels, found.pose, self.habits),) if one is not None]
            sharp = [found]
        else:
            rounded = self.sight.far(pixels, around, self.habits)
            sharp = self._sharp.far(pixels, around, habits)
        more = _most(rounded) - _most(sharp)
        self._nats = max(self._nats + float(np.clip(more, -MOST_NATS, MOST_NATS)), -ROUNDED_FROM_NATS)
        self.is_open = self._nats < ROUNDED_FROM_NATS
        return not self.is_open


def _most(found: Sequence[Found]) -> float:
    """The most evidence of poses, nats, not less than none."""
    return max((one.evidence for one in found), default=0.0)
