"""How far a target can have turned since it was last seen surely: what is turned farther is a look-alike.

Many targets look nearly the same turned by half. One image tells the one from the other with some odds, and
of many images that are searched a few tell the wrong one; but nothing turns by half from one frame to the
next.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from geometry.model import Model
from geometry.pose import Pose
from geometry.symmetries import symmetry_of

Floats = NDArray[np.float64]

# Chosen by hand: beside what a pose may be off, 3 degrees a frame at 30 a second.
AT_ONCE_DEG, RATE_DEG_S = 15.0, 90.0


class Turning:
    """Of one target, from frame to frame; turns after which it is just the same do not count."""

    def __init__(self, model: Model) -> None:
        symmetry = symmetry_of(model)
        self._turns = np.array([turn.matrix for turn in symmetry.turns])
        self._round = symmetry.free_axis is not None  # about which nothing tells how far it is turned
        self._last: Floats | None = None
        self._limit_deg = AT_ONCE_DEG

    def passed(self, seconds: float) -> None:
        """So much time, until the next frame."""
        self._limit_deg += RATE_DEG_S * max(seconds, 0.0)

    def seen(self, pose: Pose) -> None:
        """That the target surely has this pose now."""
        self._last, self._limit_deg = pose.matrix, AT_ONCE_DEG

    def allows(self, pose: Pose) -> bool:
        """Whether the target can have this pose."""
        if self._last is None or self._round or self._limit_deg >= 180.0:
            return True
        cosines = 0.5 * (np.sum((pose.matrix @ self._turns) * self._last, axis=(1, 2)) - 1.0)
        return bool(cosines.max() >= math.cos(math.radians(self._limit_deg)))
