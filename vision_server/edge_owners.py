"""Whose an edge point is, and what runs beside an edge and may have moved it.

An edge point belongs to the nearest visible line that runs along it, and to no other. Where a face is seen
nearly edge-on, two lines of the model run a few pixels apart, and often only one of them has contrast.
Without this rule its edge holds both, and pulls the pose until the two fall together. Closer than their
blur, two edges are seen as one that lies somewhere between them.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from geometry.kernels import kernel

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

ALONG_COSINE = 0.9  # lines that cross at more than about 25 degrees do not compete
BEYOND_PX = 2.0  # past its ends, where a line still has a claim
NEIGHBOUR_HEIGHT = 0.5  # of a neighbour's contrast over the edge's own; it is not known
BLUR_SHARE = 1.5  # blur of an edge and of its filter together, over the filter's scale


@kernel()
def _ends(line: Ints, line_count: int) -> tuple[Ints, Ints]:
    """First and last sample of each line, -1 for none; ``line`` (N,) is ascending."""
    first, last = np.full(line_count, -1), np.full(line_count, -1)
    for i in range(len(line)):
        if first[line[i]] < 0:
            first[line[i]] = i
        last[line[i]] = i
    return first, last


@kernel(error_model="numpy")
def _axis(start: Floats, end: Floats) -> tuple[float, float, float]:
    """Unit vector from start to end (2,) and the distance; zeros when they fall together."""
    x, y = end[0] - start[0], end[1] - start[1]
    length = math.sqrt(x * x + y * y)
    return (x / length, y / length, length) if length > 0.0 else (0.0, 0.0, 0.0)


@kernel(error_model="numpy")
def _beside(
    mine: int, other: int, first: Ints, last: Ints, image: Floats, direction: Floats
) -> tuple[bool, float, float, float]:
    """Whether two lines are seen that run about the same way; axis and length of the other one."""
    if other == mine or first[mine] < 0 or first[other] < 0:
        return False, 0.0, 0.0, 0.0
    ux, uy, length = _axis(image[first[other]], image[last[other]])
    middle = (first[mine] + last[mine]) // 2
    along = abs(ux * direction[middle, 0] + uy * direction[middle, 1])
    return along >= ALONG_COSINE, ux, uy, length


@kernel(error_model="numpy")
def leave_to_owners(
    line: Ints,
    image: Floats,
    direction: Floats,
    normal: Floats,
    line_count: int,
    offset: Floats,
) -> None:
    """Take from each line the edge points that are nearer to another one; they become NaN.

    Parameters
    ----------
    line
        (N,), ascending.
    image, direction, normal
        (N, 2), of samples on the visible lines, px; see `Measurement`.
    offset
        (C, N, K), edge points along the samples' normals, px, NaN for none; changed in place.
    """
    channels, _, peaks = offset.shape
    first, last = _ends(line, line_count)
    for mine in range(line_count):
        for other in range(line_count):
            competes, ux, uy, length = _beside(mine, other, first, last, image, direction)
            if not competes:
                continue
            a = first[other]
            for c in range(channels):
                for i in range(first[mine], last[mine] + 1):
                    for k in range(peaks):
                        x = image[i, 0] + offset[c, i, k] * normal[i, 0] - image[a, 0]
                        y = image[i, 1] + offset[c, i, k] * normal[i, 1] - image[a, 1]
                        along = x * ux + y * uy
                        if not -BEYOND_PX <= along <= length + BEYOND_PX:
                            continue
                        theirs, ours = abs(x * uy - y * ux), abs(offset[c, i, k])
                        if theirs < ours or (theirs == ours and other < mine):
                            offset[c, i, k] = np.nan


@kernel(error_model="numpy")
def pulls_of_neighbours(
    line: Ints, image: Floats, direction: Floats, normal: Floats, line_count: int, sigma: Floats
) -> Floats:
    """How far an edge may be moved by one that runs beside it, px along the normal, signed: towards it.

    Two steps g apart, blurred by s each, answer with one maximum between them when g < 2 s, and otherwise
    with two. Each is g h / H exp(-g^2 / 2 s^2) nearer to the other one, whose height is h, than its own of
    height H is. The heights differ with the light.

    Parameters
    ----------
    line, image, direction, normal
        As in `leave_to_owners`.
    sigma
        (C, L), px, scale of the filter for each channel and line.

    Returns
    -------
    (C, N), for neighbours of NEIGHBOUR_HEIGHT times the edge's own height.
    """
    channels = len(sigma)
    out = np.zeros((channels, len(line)))
    first, last = _ends(line, line_count)
    for mine in range(line_count):
        for other in range(line_count):
            competes, ux, uy, length = _beside(mine, other, first, last, image, direction)
            if not competes:
                continue
            a = first[other]
            for i in range(first[mine], last[mine] + 1):
                x, y = image[i, 0] - image[a, 0], image[i, 1] - image[a, 1]
                along = x * ux + y * uy
                if not -BEYOND_PX <= along <= length + BEYOND_PX:
                    continue
                gap = (x - along * ux) * normal[i, 0] + (y - along * uy) * normal[i, 1]
                for c in range(channels):
                    blur = BLUR_SHARE * sigma[c, mine]
                    out[c, i] -= NEIGHBOUR_HEIGHT * gap * math.exp(-0.5 * (gap / blur) ** 2)
    return out
