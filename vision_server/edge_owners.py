"""Whose an edge point is: the nearest visible line's that runs along it, and no other's.

Where a face is seen nearly edge-on, two lines of the model run a few pixels apart, and often only one of
them has contrast. Without this rule its edge holds both, and pulls the pose until the two fall together.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

ALONG_COSINE = 0.9  # lines that cross at more than about 25 degrees do not compete
BEYOND_PX = 2.0  # past its ends, where a line still has a claim


@njit(cache=True, error_model="numpy")
def leave_to_owners(
    line: Ints,
    image: Floats,
    direction: Floats,
    normal: Floats,
    line_count: int,
    sharp: NDArray[np.bool_],
    offset: Floats,
) -> None:
    """Take from each line the edge points that are nearer to another one; they become NaN.

    Parameters
    ----------
    line
        (N,), ascending.
    image, direction, normal
        (N, 2), of samples on the visible lines, px; see `Measurement`.
    sharp
        (C, N), samples that give way; between blurred edges there is no line to draw: it would cut both.
    offset
        (C, N, K), edge points along the samples' normals, px, NaN for none; changed in place.
    """
    channels, _, peaks = offset.shape
    count = len(line)
    first, last = np.full(line_count, -1), np.full(line_count, -1)
    for i in range(count):
        if first[line[i]] < 0:
            first[line[i]] = i
        last[line[i]] = i
    for mine in range(line_count):
        if first[mine] < 0:
            continue
        for other in range(line_count):
            if other == mine or first[other] < 0:
                continue
            a, b = first[other], last[other]
            ux, uy = image[b, 0] - image[a, 0], image[b, 1] - image[a, 1]
            length = math.sqrt(ux * ux + uy * uy)
            if not length > 0.0:
                continue
            ux, uy = ux / length, uy / length
            middle = (first[mine] + last[mine]) // 2
            if abs(ux * direction[middle, 0] + uy * direction[middle, 1]) < ALONG_COSINE:
                continue
            for c in range(channels):
                for i in range(first[mine], last[mine] + 1):
                    if not sharp[c, i]:
                        continue
                    for k in range(peaks):
                        x = image[i, 0] + offset[c, i, k] * normal[i, 0] - image[a, 0]
                        y = image[i, 1] + offset[c, i, k] * normal[i, 1] - image[a, 1]
                        along = x * ux + y * uy
                        if not -BEYOND_PX <= along <= length + BEYOND_PX:
                            continue
                        theirs, ours = abs(x * uy - y * ux), abs(offset[c, i, k])
                        if theirs < ours or (theirs == ours and other < mine):
                            offset[c, i, k] = np.nan
