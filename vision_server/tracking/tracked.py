"""What tracking says of a frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from geometry.pose import Pose
from numerics.arrays import Floats

State = Literal["sure", "unsure", "lost"]


@dataclass(frozen=True, eq=False)
class Tracked:
    """What one frame says.

    Attributes
    ----------
    pose, covariance : None when it is lost.
    seconds : of processor time.
    note : for people, what is strange about the frame; empty mostly.
    support : share of each visible line that the frame supports.
    """

    frame: int
    state: State
    pose: Pose | None
    covariance: Floats | None
    seconds: float
    note: str = ""
    support: dict[int, float] | None = None
