"""Joining collinear lines, end to end, that texture, a shadow or a crossing edge has cut."""

from __future__ import annotations

import numpy as np

from numerics.arrays import Floats, Ints
from numerics.kernels import kernel
from vision_server.segments.line_fit import Edgels, FittedLines

# Chosen by hand where nothing else is said.
MAX_GAP_PX = 20.0  # between the ends that face each other
MAX_GAP_SHARE = 0.5  # of the shorter line: a gap longer than that proves nothing
MAX_OFFSET_PX = 1.0  # of the shorter line's ends from the longer line
MAX_OVERLAP_PX = 3.0  # more, and they are two edges side by side
MAX_STRENGTH_RATIO = 3.0  # of two that are one line; chosen by hand


@kernel()
def _assign(endpoints: Floats, strength: Floats, order: Ints, base_of: Ints) -> None:
    """Give each line, from the longest on, those that continue it; ``base_of`` tells whose it became."""
    count = len(order)
    for place in range(count):
        i = order[place]
        if base_of[i] != i:
            continue
        ax, ay, bx, by = endpoints[i]
        length = np.hypot(bx - ax, by - ay)
        tx, ty = (bx - ax) / length, (by - ay) / length
        low, high = 0.0, length
        grown = True
        while grown:
            grown = False
            for other in range(place + 1, count):
                j = order[other]
                if base_of[j] != j:
                    continue
                ux, uy = endpoints[j, 0] - ax, endpoints[j, 1] - ay
                vx, vy = endpoints[j, 2] - ax, endpoints[j, 3] - ay
                if max(abs(ux * ty - uy * tx), abs(vx * ty - vy * tx)) > MAX_OFFSET_PX:
                    continue
                s, e = ux * tx + uy * ty, vx * tx + vy * ty
                first, last = min(s, e), max(s, e)
                gap = max(first - high, low - last)
                if gap < -MAX_OVERLAP_PX or gap > min(MAX_GAP_PX, MAX_GAP_SHARE * (last - first)):
                    continue
                if max(strength[i], strength[j]) > MAX_STRENGTH_RATIO * min(strength[i], strength[j]):
                    continue
                base_of[j] = i
                low, high = min(low, first), max(high, last)
                grown = True


def join_collinear(edgels: Edgels, lines: FittedLines) -> Edgels:
    """Groups of edgels with those joined that lie on one line, end to end.

    Parameters
    ----------
    edgels
        Groups.
    lines
        The line of each group, none of length 0.

    Returns
    -------
    Fewer or as many groups, each of the edgels of one or more of the given ones.
    """
    alone = np.arange(len(lines.count))
    base_of = alone.copy()
    _assign(lines.endpoints, lines.strength, np.argsort(-lines.length, kind="stable"), base_of)
    if np.array_equal(base_of, alone):
        return edgels
    members: list[Ints] = []
    groups = []
    filled = 0
    for base in np.unique(base_of):
        pieces = [np.arange(*edgels.groups[k]) for k in np.flatnonzero(base_of == base)]
        members += pieces
        groups.append((filled, filled + sum(map(len, pieces))))
        filled = groups[-1][1]
    chosen = np.concatenate(members)
    return Edgels(
        edgels.points[chosen], edgels.normals[chosen], edgels.strengths[chosen], np.array(groups, np.int64)
    )
