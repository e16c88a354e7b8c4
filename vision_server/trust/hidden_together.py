"""Evidence of lines of which some are not seen: what hides one hides those beside it, too.

An arm in front of a part, a dark corner, pins as grey as their socket are one cause each, however many lines
they take. Where lines are seen between those that are not, nothing has hidden these together.
"""

from __future__ import annotations

import math

from numerics.arrays import Floats
from numerics.kernels import kernel

# -ln of the probability that a line cannot be seen: dark, without contrast, behind something; chosen by hand.
NOT_SEEN_NATS = 1.5
# By hand, by the share that right poses have among those that look alike: of 66 photographs of drawn parts
# and 35 image sets of docking gear. Half and twice the reach, and three times the share, do about as well.
ONE_CAUSE_PX = 60.0  # between the middles of lines that one cause may hide
OWN_SHARE = 0.1  # of what a line that is not seen counts alone, that it counts beside many others
SEEN_AGAINST_LINES = 2.0  # lines beside it that are not seen, which one that is seen speaks against


@kernel()
def evidence_of(nats: Floats, middle: Floats) -> float:
    """Evidence of all of L lines, nats.

    Parameters
    ----------
    nats
        (L,), of each line, as if it stood alone; less than 0 where it is not seen.
    middle
        (L, 2), of each line in the image, px.
    """
    total = 0.0
    for i in range(len(nats)):
        if nats[i] >= 0.0:
            total += nats[i]
            continue
        together = 0.0
        for j in range(len(nats)):
            dx, dy = abs(middle[j, 0] - middle[i, 0]), abs(middle[j, 1] - middle[i, 1])
            if j == i or dx >= ONE_CAUSE_PX or dy >= ONE_CAUSE_PX:
                continue
            near = max(0.0, 1.0 - math.sqrt(dx * dx + dy * dy) / ONE_CAUSE_PX)
            amount = near * min(abs(nats[j]), NOT_SEEN_NATS) / NOT_SEEN_NATS
            together += amount if nats[j] < 0.0 else -SEEN_AGAINST_LINES * amount
        total -= min(-nats[i], NOT_SEEN_NATS) * (OWN_SHARE + (1.0 - OWN_SHARE) / (1.0 + max(0.0, together)))
    return total
