"""Of several poses that a frame was refined to, the likeliest."""

from __future__ import annotations

from collections.abc import Sequence

from numerics.arrays import Floats
from vision_server.pose.trust import RIVAL_NATS
from vision_server.tracking.following import Found
from vision_server.tracking.motion import Motion


def likeliest(found: Sequence[Found], expected: Motion, middle: Floats) -> Found:
    """The pose for which lines and motion speak most together; ``middle`` (3,) of the target, m.

    Print may look better than the edge beside it, and the motion knows which it was; but of a small target
    seen from the front, turned one way or the other, the motion may foresee the wrong one, and lines tell.
    """

    def nats(one: Found) -> float:
        surprise = expected.innovation(one.pose, one.covariance, middle).squared
        return one.support.evidence / RIVAL_NATS - 0.5 * surprise

    return max(found, key=nats)
