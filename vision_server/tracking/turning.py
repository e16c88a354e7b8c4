"""How far a target can have turned since it was last seen surely: what is turned farther is a look-alike.

Many targets look nearly the same turned by half. One image tells the one from the other with some odds, and
of many images that are searched a few tell the wrong one; but nothing turns by half from one frame to the
next.
"""

from __future__ import annotations

from geometry.model import Model
from geometry.pose import Pose
from geometry.symmetries import symmetry_of

# Chosen by hand: beside what a pose may be off, 3 degrees a frame at 30 a second.
AT_ONCE_DEG, RATE_DEG_S = 15.0, 90.0


class Turning:
    """Of one target, from frame to frame; turns after which it is just the same do not count."""

    def __init__(self, model: Model) -> None:
        self._symmetry = symmetry_of(model)
        self._last: Pose | None = None
        self._limit_deg = AT_ONCE_DEG

    def passed(self, seconds: float) -> None:
        """So much time, until the next frame."""
        self._limit_deg += RATE_DEG_S * max(seconds, 0.0)

    def seen(self, pose: Pose) -> None:
        """That the target surely has this pose now."""
        self._last, self._limit_deg = pose, AT_ONCE_DEG

    def allows(self, pose: Pose) -> bool:
        """Whether the target can have this pose; of a round one nothing tells how far it is turned."""
        if self._last is None or self._symmetry.free_axis is not None:
            return True
        alike = (pose.compose(turn) for turn in self._symmetry.turns)
        return any(one.error_to(self._last).rotation_deg <= self._limit_deg for one in alike)
