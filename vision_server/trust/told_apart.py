"""What tells two poses apart: lines that the images would show of only one of them.

Of a wheel and the wheel turned by a side most lines lie on each other. How much of such a line has support
depends on where its samples fall, and over all lines that makes up to 9 nats, as much as a small mark that
tells the two apart. What lies at the same place in the image speaks for both alike, and is left out.
"""

from __future__ import annotations

import numpy as np

from geometry.visibility import Samples
from numerics.arrays import Flags, Floats, Ints
from numerics.kernels import kernel
from vision_server.trust.support import PoseSupport

SAME_PX = 1.0  # support's SUPPORT_PX: an edge point that supports one of two such lines supports both
SAME_SINE = 0.1  # of the angle between two lines that are one (by hand)
SAME_SHARE = 0.9  # of a line's visible length that has to lie on lines of the other pose (by hand)
NO_LINE = -1


def evidence_apart(one: PoseSupport, other: PoseSupport, together: bool = False) -> float:
    """Evidence of one pose over another one's, nats, by the lines that are not at one place in both.

    ``together`` as of `PoseSupport.evidence_together`. Their samples may lie otherwise on their lines.
    """
    alone, others_alone = _alone(one.samples, other.samples, one.trust.shape[1])
    return one.evidence_of(alone, together) - other.evidence_of(others_alone, together)


def _alone(one: Samples, other: Samples, lines: int) -> tuple[Flags, Flags]:
    """Which lines (L,) of a pose are not also lines of the other, and which of the other's are not its.

    A line on which lies one that has more to it is not one of both: what is more would count for one alone.
    """
    on, others_on = _lines_beneath(one, other), _lines_beneath(other, one)
    both, others_both = np.ones(lines, dtype=np.bool_), np.ones(lines, dtype=np.bool_)
    while True:
        before = both.sum() + others_both.sum()
        both &= _share(one, (on != NO_LINE) & others_both[on], lines) >= SAME_SHARE
        others_both &= _share(other, (others_on != NO_LINE) & both[others_on], lines) >= SAME_SHARE
        if both.sum() + others_both.sum() == before:
            return ~both, ~others_both


def _share(samples: Samples, chosen: Flags, lines: int) -> Floats:
    """Share of the visible length of each line (L,) on chosen samples (N,)."""
    visible = np.bincount(samples.line, samples.px, lines)
    return np.asarray(np.bincount(samples.line, samples.px * chosen, lines) / np.maximum(visible, 1e-9))


@kernel()
def _lines_beneath(one: Samples, other: Samples) -> Ints:
    """The line of another pose that each sample of one lies on, (N,), NO_LINE for none."""
    out = np.full(len(one.line), NO_LINE)
    line, image, direction, px = other.line, other.image, other.image_direction, other.px
    for i in range(len(out)):
        x, y, u, v = one.image[i, 0], one.image[i, 1], one.image_direction[i, 0], one.image_direction[i, 1]
        nearest, own_px = SAME_PX, one.px[i]
        for j in range(len(line)):
            dx, dy = image[j, 0] - x, image[j, 1] - y
            if abs(u * dx + v * dy) > 0.5 * (own_px + px[j]) + SAME_PX:
                continue
            across = abs(u * dy - v * dx)
            sine = abs(u * direction[j, 1] - v * direction[j, 0])
            if across <= nearest and sine <= SAME_SINE:
                nearest, out[i] = across, line[j]
    return out
