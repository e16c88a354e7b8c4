"""Data association: whose an edge point is, and what runs beside an edge and may have moved it.

An edge point belongs to the nearest visible line that runs along it, and to no other. Where a face is seen
nearly edge-on, two lines of the model run a few pixels apart, and often only one of them has contrast.
Without this rule its edge holds both, and pulls the pose until the two fall together. Closer than their
blur, two edges are seen as one that lies somewhere between them.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geometry.visibility import Samples
from numerics.kernels import kernel

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

ALONG_COSINE = 0.9  # lines that cross at more than about 25 degrees do not compete
BEYOND_PX = 2.0  # past its ends, where a line still has a claim
NEIGHBOUR_HEIGHT = 0.5  # of a neighbour's contrast over the edge's own; it is not known
FAR_BLURS = 9.0  # an edge this many blurs away moves another by under 1e-16 px
SURELY_PX = 1e-6  # beyond what rounding could change
BLUR_SHARE = 1.5  # blur of an edge and of its filter together, over the filter's scale


class _Courses(NamedTuple):
    """How the visible lines run in the image, and which of them run along each other.

    Attributes
    ----------
    ends : (L, 2), first and last sample of each line, -1 for none.
    along : (L, 3), the unit vector from the first to the last and their distance, zeros when they fall
        together.
    pairs : (P, 2), a line and one that runs about the same way.
    """

    ends: Ints
    along: Floats
    pairs: Ints


@kernel(error_model="numpy")
def _courses(samples: Samples, lines: int) -> _Courses:
    line, image, direction = samples.line, samples.image, samples.image_direction
    ends, along = np.full((lines, 2), -1), np.zeros((lines, 3))
    for i in range(len(line)):
        if ends[line[i], 0] < 0:
            ends[line[i], 0] = i
        ends[line[i], 1] = i
    for m in range(lines):
        first, last = ends[m, 0], ends[m, 1]
        if first >= 0:
            x, y = image[last, 0] - image[first, 0], image[last, 1] - image[first, 1]
            length = math.sqrt(x * x + y * y)
            if length > 0.0:
                along[m, 0], along[m, 1], along[m, 2] = x / length, y / length, length
    pairs = np.empty((lines * lines, 2), dtype=np.int64)
    count = 0
    for mine in range(lines):
        middle = (ends[mine, 0] + ends[mine, 1]) // 2
        for other in range(lines):
            if other == mine or ends[other, 0] < 0 or ends[mine, 0] < 0:
                continue
            x, y = direction[middle, 0], direction[middle, 1]
            if abs(along[other, 0] * x + along[other, 1] * y) >= ALONG_COSINE:
                pairs[count, 0], pairs[count, 1] = mine, other
                count += 1
    return _Courses(ends, along, pairs[:count])


@kernel(error_model="numpy")
def associate(samples: Samples, lines: int, offset: Floats) -> None:
    """Take from each line the edge points that are nearer to another one; they become NaN.

    Parameters
    ----------
    samples
        N, on the visible ones of so many ``lines``.
    offset
        (C, N, K), edge points along the samples' normals, px, NaN for none; changed in place.
    """
    channels, count, peaks = offset.shape
    image, direction, courses = samples.image, samples.image_direction, _courses(samples, lines)
    farthest = np.zeros(count)
    for c in range(channels):
        for i in range(count):
            for k in range(peaks):
                if not math.isnan(offset[c, i, k]):
                    farthest[i] = max(farthest[i], abs(offset[c, i, k]))
    for mine, other in courses.pairs:
        a = courses.ends[other, 0]
        ux, uy, length = courses.along[other, 0], courses.along[other, 1], courses.along[other, 2]
        for i in range(courses.ends[mine, 0], courses.ends[mine, 1] + 1):
            apart = abs((image[i, 0] - image[a, 0]) * uy - (image[i, 1] - image[a, 1]) * ux)
            if apart > 2.0 * farthest[i] + SURELY_PX:
                continue
            for c in range(channels):
                for k in range(peaks):
                    x = image[i, 0] - offset[c, i, k] * direction[i, 1] - image[a, 0]
                    y = image[i, 1] + offset[c, i, k] * direction[i, 0] - image[a, 1]
                    along = x * ux + y * uy
                    if not -BEYOND_PX <= along <= length + BEYOND_PX:
                        continue
                    theirs, ours = abs(x * uy - y * ux), abs(offset[c, i, k])
                    if theirs < ours or (theirs == ours and other < mine):
                        offset[c, i, k] = np.nan


@kernel(error_model="numpy")
def neighbour_pulls(samples: Samples, lines: int, sigma: Floats) -> Floats:
    """How far an edge may be moved by one that runs beside it, (C, N) px along the normal, towards it.

    Two steps g apart, blurred by s each, answer with one maximum between them when g < 2 s, and otherwise
    with two. Each is g h / H exp(-g^2 / 2 s^2) nearer to the other one, whose height is h, than its own of
    height H is. The heights differ with the light: neighbours of NEIGHBOUR_HEIGHT times the edge's own are
    assumed.

    Parameters
    ----------
    sigma
        (C, L), px, scale of the filter for each channel and line.
    """
    image, direction, courses = samples.image, samples.image_direction, _courses(samples, lines)
    out = np.zeros((len(sigma), len(image)))
    for mine, other in courses.pairs:
        a = courses.ends[other, 0]
        ux, uy, length = courses.along[other, 0], courses.along[other, 1], courses.along[other, 2]
        for i in range(courses.ends[mine, 0], courses.ends[mine, 1] + 1):
            x, y = image[i, 0] - image[a, 0], image[i, 1] - image[a, 1]
            along = x * ux + y * uy
            if not -BEYOND_PX <= along <= length + BEYOND_PX:
                continue
            gap = -(x - along * ux) * direction[i, 1] + (y - along * uy) * direction[i, 0]
            for c in range(len(sigma)):
                blur = BLUR_SHARE * sigma[c, mine]
                if abs(gap) < FAR_BLURS * blur:
                    out[c, i] -= NEIGHBOUR_HEIGHT * gap * math.exp(-0.5 * (gap / blur) ** 2)
    return out
