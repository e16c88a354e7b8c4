"""Data association: whose an edge point is.

An edge point belongs to the nearest visible line that runs along it, and to no other. Where a face is seen
nearly edge-on, two lines of the model run a few pixels apart, and often only one of them has contrast.
Without this rule its edge holds both, and pulls the pose until the two fall together. How far edges that
are blurred together move each other `blending` tells.
"""

from __future__ import annotations

import math

import numpy as np

from geometry.visibility import Samples
from numerics.arrays import Floats
from numerics.kernels import kernel
from vision_server.pose.along_lines import beside, course_of, crosses, line_courses

PAST_PX = 2.0  # chosen by hand: past its ends a line has a claim about as far as a corner is blurred
ROUNDING_PX = 1e-6  # more than rounding changes a distance by


@kernel()
def associate(samples: Samples, offset: Floats) -> None:
    """Take from each line the edge points that are nearer to another one; they become NaN.

    Parameters
    ----------
    samples
        N, on the visible lines.
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
    courses = line_courses(samples, 2.0 * farthest + PAST_PX + 1.0)
    pairs = courses.pairs
    for number in range(len(pairs)):
        mine, other = pairs[number, 0], pairs[number, 1]
        own, their = course_of(image, courses, mine), course_of(image, courses, other)
        for i in range(own.first, own.last + 1):
            apart, _, at = beside(image, direction, their, image[i, 0], image[i, 1])
            if apart > 2.0 * farthest[i] + ROUNDING_PX or crosses(direction, own, their, i, at):
                continue
            for c in range(channels):
                for k in range(peaks):
                    ours = abs(offset[c, i, k])
                    if math.isnan(ours) or (their.bow == 0.0 and apart > 2.0 * ours + ROUNDING_PX):
                        continue
                    x = image[i, 0] - offset[c, i, k] * direction[i, 1]
                    y = image[i, 1] + offset[c, i, k] * direction[i, 0]
                    theirs, beyond, _ = beside(image, direction, their, x, y)
                    if not beyond <= PAST_PX:
                        continue
                    if theirs < ours or (theirs == ours and other < mine):
                        offset[c, i, k] = np.nan
