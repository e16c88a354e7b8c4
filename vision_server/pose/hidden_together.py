"""Evidence of lines of which some are not seen: what hides one hides those beside it, too.

An arm in front of a part, a dark corner, pins as grey as their socket are one cause each, however many lines
they take. Where lines are seen between those that are not, nothing has hidden these together.
"""

from __future__ import annotations

import math

from numerics.arrays import Floats
from numerics.kernels import kernel

HIDDEN = 1.5  # -ln of the probability that a line cannot be seen: dark, no contrast, something in the way
# By hand, by the share that right poses have among those that look alike: of 66 photographs of drawn parts
# and 35 image sets of docking gear. Half and twice the reach, and three times OWN, do about as well.
REACH_PX = 60.0  # between the middles of lines that one cause may hide
OWN = 0.1  # of what a line that is not seen counts alone, that it counts beside many others
AGAINST = 2.0  # lines beside it that are not seen, which one that is seen speaks against


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
            if j == i or dx >= REACH_PX or dy >= REACH_PX:
                continue
            near = max(0.0, 1.0 - math.sqrt(dx * dx + dy * dy) / REACH_PX)
            amount = near * min(abs(nats[j]), HIDDEN) / HIDDEN
            together += amount if nats[j] < 0.0 else -AGAINST * amount
        total -= min(-nats[i], HIDDEN) * (OWN + (1.0 - OWN) / (1.0 + max(0.0, together)))
    return total
