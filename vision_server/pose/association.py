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

from numerics.kernels import kernel

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

ALONG_COSINE = 0.9  # lines that cross at more than about 25 degrees do not compete
BEYOND_PX = 2.0  # past its ends, where a line still has a claim
NEIGHBOUR_HEIGHT = 0.5  # of a neighbour's contrast over the edge's own; it is not known
FAR_BLURS = 9.0  # an edge this many blurs away moves another by under 1e-16 px
SURELY_PX = 1e-6  # beyond what rounding could change
BLUR_SHARE = 1.5  # blur of an edge and of its filter together, over the filter's scale


@kernel()
def ends_of_lines(line: Ints, line_count: int) -> Ints:
    """First and last sample of each line, (L, 2), -1 for none; ``line`` (N,) is ascending."""
    ends = np.full((line_count, 2), -1)
    for i in range(len(line)):
        if ends[line[i], 0] < 0:
            ends[line[i], 0] = i
        ends[line[i], 1] = i
    return ends


@kernel(error_model="numpy")
def _pairs(line: Ints, image: Floats, direction: Floats, line_count: int) -> tuple[Ints, Floats, Ints]:
    """Which visible lines run about the same way; ``line`` (N,) is ascending.

    Returns
    -------
    first and last sample of each line (L, 2), -1 for none; the unit vector from the first to the last and
    their distance (L, 3), zeros when they fall together; pairs (P, 2) of a line and one beside it.
    """
    ends, course = ends_of_lines(line, line_count), np.zeros((line_count, 3))
    for m in range(line_count):
        if ends[m, 0] < 0:
            continue
        a, b = ends[m, 0], ends[m, 1]
        x, y = image[b, 0] - image[a, 0], image[b, 1] - image[a, 1]
        length = math.sqrt(x * x + y * y)
        if length > 0.0:
            course[m, 0], course[m, 1], course[m, 2] = x / length, y / length, length
    pairs = np.empty((line_count * line_count, 2), dtype=np.int64)
    count = 0
    for mine in range(line_count):
        if ends[mine, 0] < 0:
            continue
        middle = (ends[mine, 0] + ends[mine, 1]) // 2
        x, y = direction[middle, 0], direction[middle, 1]
        for other in range(line_count):
            if other == mine or ends[other, 0] < 0:
                continue
            if abs(course[other, 0] * x + course[other, 1] * y) >= ALONG_COSINE:
                pairs[count, 0], pairs[count, 1] = mine, other
                count += 1
    return ends, course, pairs[:count]


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
    channels, count, peaks = offset.shape
    ends, course, pairs = _pairs(line, image, direction, line_count)
    farthest = np.zeros(count)
    for c in range(channels):
        for i in range(count):
            for k in range(peaks):
                if not math.isnan(offset[c, i, k]):
                    farthest[i] = max(farthest[i], abs(offset[c, i, k]))
    for p in range(len(pairs)):
        mine, other = pairs[p, 0], pairs[p, 1]
        a, ux, uy, length = ends[other, 0], course[other, 0], course[other, 1], course[other, 2]
        for i in range(ends[mine, 0], ends[mine, 1] + 1):
            apart = abs((image[i, 0] - image[a, 0]) * uy - (image[i, 1] - image[a, 1]) * ux)
            if apart > 2.0 * farthest[i] + SURELY_PX:
                continue
            for c in range(channels):
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
    ends, course, pairs = _pairs(line, image, direction, line_count)
    for p in range(len(pairs)):
        mine, other = pairs[p, 0], pairs[p, 1]
        a, ux, uy, length = ends[other, 0], course[other, 0], course[other, 1], course[other, 2]
        for i in range(ends[mine, 0], ends[mine, 1] + 1):
            x, y = image[i, 0] - image[a, 0], image[i, 1] - image[a, 1]
            along = x * ux + y * uy
            if not -BEYOND_PX <= along <= length + BEYOND_PX:
                continue
            gap = (x - along * ux) * normal[i, 0] + (y - along * uy) * normal[i, 1]
            for c in range(channels):
                blur = BLUR_SHARE * sigma[c, mine]
                if abs(gap) < FAR_BLURS * blur:
                    out[c, i] -= NEIGHBOUR_HEIGHT * gap * math.exp(-0.5 * (gap / blur) ** 2)
    return out
