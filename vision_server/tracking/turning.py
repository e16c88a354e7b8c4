"""How far a target can have turned since it was last seen surely: what is turned farther is a look-alike.

Many targets look nearly the same turned by half. One image tells the one from the other with some odds, and
of many images that are searched a few tell the wrong one; but nothing turns by half from one frame to the
next. A gap in the film, or fewer frames than 30 a second, let a target turn farther. What was turned so, and
looks like nothing that the target can have come to, is no look-alike.
"""

from __future__ import annotations

import math

import numpy as np

from geometry.model import Model
from geometry.near_symmetries import near_symmetries
from geometry.pose import Pose
from geometry.symmetries import symmetry_of
from geometry.turns import right_turns, round_axes
from vision_server.tracking.acceptance import SURE, is_whole
from vision_server.trust.judgement import Estimate
from vision_server.trust.probability import SHARED

# Chosen by hand: beside what a pose may be off, 3 degrees a frame at 30 a second.
AT_ONCE_DEG, RATE_DEG_S = 15.0, 90.0
HALF_RAD = math.pi - 1e-6  # radians, but for rounding


class Turning:
    """Of one target, from frame to frame; turns after which it is just the same do not count."""

    def __init__(self, model: Model) -> None:
        self._model, self._symmetry = model, symmetry_of(model)
        self._last: Pose | None = None
        self._limit_deg = AT_ONCE_DEG

    def passed(self, seconds: float) -> None:
        """So much time, until the next frame."""
        self._limit_deg += RATE_DEG_S * max(seconds, 0.0)

    def seen(self, pose: Pose) -> None:
        """That the target surely has this pose now, or that all speaks for it."""
        self._last, self._limit_deg = pose, AT_ONCE_DEG

    def allows(self, pose: Pose) -> bool:
        """Whether the target can have this pose; of a round one nothing tells how far it is turned."""
        if self._last is None or self._symmetry.free_axis is not None:
            return True
        alike = (pose.compose(turn) for turn in self._symmetry.turns)
        return any(one.error_to(self._last).rotation_deg <= self._limit_deg for one in alike)

    def stands_out(self, found: Estimate) -> bool:
        """Whether what is turned too far is so probable, and so unlike others, that it is no look-alike."""
        if found.pose is None or found.support is None or found.score < SURE or found.ambiguity >= SHARED:
            return False
        return is_whole(found.support) and not self.is_look_alike(found.pose)

    def is_look_alike(self, pose: Pose) -> bool:
        """Whether a pose may look like one that the target can have, turned by half or nearly symmetric."""
        if self._last is None:
            return False
        halves = (one for one in right_turns(self._model) if np.linalg.norm(one.rotation_vector) > HALF_RAD)
        turns = (*near_symmetries(self._model), *halves)
        if any(self.allows(pose.compose(turn)) for turn in turns):
            return True
        limit = math.cos(math.radians(min(self._limit_deg, 90.0)))
        axes = (axis for axis, _ in round_axes(self._model))  # about which a turn hardly shows
        return any(abs(float(np.dot(pose.matrix @ axis, self._last.matrix @ axis))) >= limit for axis in axes)
