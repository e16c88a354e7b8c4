"""Is a part as round as its model's facets suggest, or has it these facets itself?

The facets of a round part are chords: with 32 a turn its rims and outlines lie up to half a percent of the
radius outside of the mesh. That moves all of them outwards, much as a nearer pose does. So the last step has
one unknown more, how much of it the part has: 0 where it is made as its mesh is, 1 where it is smooth. The
places of lines tell it, and within a chord of a rim the edge itself: it is bent, or straight.
"""

from __future__ import annotations

import numpy as np

from numerics.arrays import Floats
from vision_server.pose.courses import ROUNDNESS, Courses

ROUNDNESS_SD = 1.0  # about none: where nothing tells it, the mesh is taken, and what it may be off is stated
# By hand: that many nats more for none than for 1 tell a part that has its model's facets. Of pictures of 64
# facets a turn there are 5 and more, of recorded scenes of smooth parts 2.4 at most.
FACETS_NATS = 4.0


def told_roundness(courses: Courses) -> tuple[Floats, Floats]:
    """Prior precision of the roundness, and that times its mean, (1,); (0,) of courses that have none.

    What is told by `Courses.bow` is in it.
    """
    if courses.motion.shape[2] <= ROUNDNESS:
        return np.empty(0), np.empty(0)
    pull, precision = courses.share @ courses.bow
    return np.array([ROUNDNESS_SD**-2.0 + precision]), np.array([pull])


def has_facets(step: Floats, covariance: Floats) -> bool:
    """Whether the roundness among unknowns (K,) with covariance (K, K) is much likelier none than 1."""
    if len(step) <= ROUNDNESS:
        return False
    precision = 1.0 / float(covariance[ROUNDNESS, ROUNDNESS])
    nats = 0.5 * (precision - ROUNDNESS_SD**-2.0) - precision * float(step[ROUNDNESS])
    return bool(nats > FACETS_NATS)


def how_round(step: Floats) -> float:
    """What unknowns (K,) say of how round the part is: from 0, as its mesh, to 1, smooth."""
    return min(max(float(step[ROUNDNESS]), 0.0), 1.0) if len(step) > ROUNDNESS else 0.0


def without_roundness(courses: Courses) -> Courses:
    """The courses of a part that has its model's facets."""
    return courses._replace(motion=courses.motion[:, :, :ROUNDNESS])
