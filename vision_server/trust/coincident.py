"""Lines of a model that fall together in the image are one there, and tell once whether it is seen.

Where a face is seen edge-on, two of its lines lie on each other. An edge point belongs to the nearer of the
two, by noise alone, in each channel anew: one channel would say that the one is seen, another that the other
is, and one edge would be evidence of two lines; in a single image each would have half of it.

Lines that run a few pixels apart in a row, as those of fins do, each lie near some edge wherever the row is:
how far apart they are says how much their support tells.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geometry.visibility import Samples
from numerics.arrays import Flags, Floats
from numerics.kernels import kernel
from vision_server.pose.along_lines import ALONG_COSINE, beside, course_at, course_of, line_courses

TOGETHER_PX = 1.0  # support's SUPPORT_PX: an edge point that supports one of two nearer lines supports both
HALF_A_SAMPLE = 0.5 + 1e-6  # of a sample's length, from the next one of a line that it lies on


class Told(NamedTuple):
    """What the samples of visible lines tell, N each.

    Attributes
    ----------
    own : which stand for a place of their own.
    seen : which of those have support.
    gap : px, to the next lines that run along a sample's own, of both sides the mean; infinite where there is
        none within the reach on one side.
    """

    own: Flags
    seen: Flags
    gap: Floats


@kernel()
def told_once(samples: Samples, supported: Flags, reach_px: float = TOGETHER_PX) -> Told:
    """Which samples stand for a place of their own, whether that is seen, and how crowded it is there.

    Of visible lines that fall together the first stands for all; it has what supports any of them.

    Parameters
    ----------
    samples
        N, on the visible lines.
    supported
        (N,), whether an edge point supports a sample's own line.
    reach_px
        How far to either side other lines are looked for.
    """
    count, image, direction = len(supported), samples.image, samples.image_direction
    own, seen, gap = np.ones(count, dtype=np.bool_), supported.copy(), np.full((count, 2), np.inf)
    courses = line_courses(samples, np.full(count, reach_px))
    pairs = courses.pairs
    for number in range(len(pairs)):
        mine, other = pairs[number, 0], pairs[number, 1]
        own_course, their = course_of(image, courses, mine), course_of(image, courses, other)
        for i in range(own_course.first, own_course.last + 1):
            x, y = image[i, 0], image[i, 1]
            apart, beyond, at = beside(image, direction, their, x, y)
            if apart > reach_px or beyond > HALF_A_SAMPLE * samples.px[i]:
                continue
            if apart > TOGETHER_PX:
                dx, dy = image[at, 0] - x, image[at, 1] - y
                ux, uy = course_at(direction, their, at)
                way = ux * direction[i, 0] + uy * direction[i, 1]
                if abs(way) >= ALONG_COSINE:
                    side = int((dy * ux - dx * uy) * way > 0.0)
                    gap[i, side] = min(gap[i, side], apart)
                continue
            there = _on(samples, their.first, their.last, i)
            if there < 0:
                continue
            if other > mine:
                seen[i] = seen[i] or supported[there]
            elif own[there]:
                own[i] = False
    return Told(own, seen, 0.5 * (gap[:, 0] + gap[:, 1]))


@kernel()
def _on(samples: Samples, first: int, last: int, i: int) -> int:
    """The sample from ``first`` to ``last``, of one line, that sample ``i`` lies on; -1 for none."""
    image, direction = samples.image, samples.image_direction
    best, nearest = np.inf, first
    for j in range(first, last + 1):
        square = (image[j, 0] - image[i, 0]) ** 2 + (image[j, 1] - image[i, 1]) ** 2
        if square < best:
            best, nearest = square, j
    ux, uy = direction[nearest, 0], direction[nearest, 1]
    x, y = image[i, 0] - image[nearest, 0], image[i, 1] - image[nearest, 1]
    along, across = abs(x * ux + y * uy), abs(x * uy - y * ux)
    same_way = abs(ux * direction[i, 0] + uy * direction[i, 1]) >= ALONG_COSINE
    step = HALF_A_SAMPLE * max(samples.px[i], samples.px[nearest])
    return nearest if same_way and across <= TOGETHER_PX and along <= step else -1
