"""Data association: whose an edge point is, and what runs beside an edge and may have moved it.

An edge point belongs to the nearest visible line that runs along it, and to no other. Where a face is seen
nearly edge-on, two lines of the model run a few pixels apart, and often only one of them has contrast.
Without this rule its edge holds both, and pulls the pose until the two fall together. Closer than their
blur, two edges are seen as one that lies somewhere between them.
"""

from __future__ import annotations

import math

import numpy as np

from geometry.visibility import Samples
from numerics.arrays import Floats
from numerics.kernels import kernel
from vision_server.pose.along_lines import ALONG_COSINE, Course, beside, course_at, course_of, line_courses

PAST_PX = 2.0  # chosen by hand: past its ends a line has a claim about as far as a corner is blurred
NEIGHBOUR_HEIGHT = 0.5  # assumed, of a neighbour's contrast over the edge's own, which no one knows
FAR_BLURS = 5.0  # an edge this many blurs away moves another by under 1e-4 px
ROUNDING_PX = 1e-6  # more than rounding changes a distance by
# Blur of an edge and of its filter together over the edge's softness: 1.12 with a filter half as wide as the
# softness, as they are now, 1.41 with one as wide.
BLUR_RATIO = 1.5


@kernel(inline="always")
def _crosses(direction: Floats, mine: Course, other: Course, i: int, at: int) -> bool:
    """Whether a line, at its sample ``i``, runs otherwise than another one where that is next to it, at its
    sample ``at``; two straight ones do not, or they were no pair.
    """
    x, y = course_at(direction, other, at)
    cosine = abs(direction[i, 0] * x + direction[i, 1] * y)
    return bool(mine.bow + other.bow > 0.0 and cosine < ALONG_COSINE)


@kernel()
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
    image, direction = samples.image, samples.image_direction
    farthest = np.zeros(count)
    for c in range(channels):
        for i in range(count):
            for k in range(peaks):
                if not math.isnan(offset[c, i, k]):
                    farthest[i] = max(farthest[i], abs(offset[c, i, k]))
    near = np.zeros(lines)
    for i in range(count):
        near[samples.line[i]] = max(near[samples.line[i]], 2.0 * farthest[i] + PAST_PX + 1.0)
    courses = line_courses(samples, near)
    for mine, other in courses.pairs:
        own, their = course_of(samples, courses, mine), course_of(samples, courses, other)
        for i in range(own.first, own.last + 1):
            apart, _, at = beside(image, direction, their, image[i, 0], image[i, 1])
            if apart > 2.0 * farthest[i] + ROUNDING_PX or _crosses(direction, own, their, i, at):
                continue
            for c in range(channels):
                for k in range(peaks):
                    x = image[i, 0] - offset[c, i, k] * direction[i, 1]
                    y = image[i, 1] + offset[c, i, k] * direction[i, 0]
                    theirs, beyond, _ = beside(image, direction, their, x, y)
                    if not beyond <= PAST_PX:
                        continue
                    ours = abs(offset[c, i, k])
                    if theirs < ours or (theirs == ours and other < mine):
                        offset[c, i, k] = np.nan


@kernel()
def neighbour_pulls(samples: Samples, lines: int, sigma: Floats) -> Floats:
    """How far an edge may be moved by one that runs beside it, (C, N) px along the normal, towards it.

    Two steps g apart, blurred by s each, answer with one maximum between them when g < 2 s, and otherwise
    with two. Each is g h / H exp(-g^2 / 2 s^2) nearer to the other one, whose height is h, than its own of
    height H is. The heights differ with the light: neighbours are assumed to be
    NEIGHBOUR_HEIGHT times as high as the edge.

    Parameters
    ----------
    sigma
        (C, L), px, softness of each line in each channel; the filter may be half as wide.
    """
    image, direction = samples.image, samples.image_direction
    near = np.zeros(lines)
    for c in range(len(sigma)):
        for m in range(lines):
            near[m] = max(near[m], FAR_BLURS * BLUR_RATIO * sigma[c, m] / ALONG_COSINE + PAST_PX)
    courses = line_courses(samples, near)
    out = np.zeros((len(sigma), len(image)))
    for mine, other in courses.pairs:
        own, their = course_of(samples, courses, mine), course_of(samples, courses, other)
        for i in range(own.first, own.last + 1):
            _, beyond, at = beside(image, direction, their, image[i, 0], image[i, 1])
            if not beyond <= PAST_PX or _crosses(direction, own, their, i, at):
                continue
            ux, uy = course_at(direction, their, at)
            x, y = image[i, 0] - image[at, 0], image[i, 1] - image[at, 1]
            along = x * ux + y * uy
            gap = -(x - along * ux) * direction[i, 1] + (y - along * uy) * direction[i, 0]
            for c in range(len(sigma)):
                blur = BLUR_RATIO * sigma[c, mine]
                if abs(gap) < FAR_BLURS * blur:
                    out[c, i] -= NEIGHBOUR_HEIGHT * gap * math.exp(-0.5 * (gap / blur) ** 2)
    return out
