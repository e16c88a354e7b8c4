"""Edges beside each other that are blurred together: how far each is moved by the other.

Two steps of heights H and h, g apart, blurred by s with the filter's own width, have the derivative

    H G(x) + h G(x - g),    G(x) = exp(-x^2 / 2 s^2)

whose maximum is not at 0. Opposite steps, as the two sides of a bar, are pushed apart; equal ones come
together, and are one where g < 2 s. Which it is, and how far, depends on the light. Where both edges are
seen, their heights tell what is foreseen, and what they are apart beyond the model's g tells how far off
that is: mostly because the blur is not well known. Where the other one is not seen, nobody knows.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from geometry.visibility import Samples
from numerics.arrays import Floats
from numerics.kernels import kernel
from vision_server.pose.along_lines import (
    ALONG_COSINE,
    Course,
    beside,
    course_at,
    course_of,
    crosses,
    line_courses,
)
from vision_server.pose.association import PAST_PX

UNSEEN_HEIGHT = 0.5  # assumed, of an unseen neighbour's contrast over the edge's own, which no one knows
FAR_BLURS = 5.0  # an edge this many blurs away moves another by under 1e-4 px
# Blur of an edge and of its filter together over the edge's softness: 1.12 with a filter half as wide as the
# softness, as they are now, 1.41 with one as wide.
BLUR_RATIO = 1.5
SHARP_PX = 1.0  # softness of edges that their profiles (`profiles`) tell more of
# Of how far two edges are foreseen to be apart beyond their gap, one sd: the blur is known to about that.
# On 48 ray-traced sets of hard scenes lines that are moved by 1 px and more, by 1.5 to 2.1 in the median, are
# 0.3 to 0.4 px off once they are moved back. By hand, as the next three are; with 0.35 and 0.15 px for the
# first two as many poses are right and tight.
FORESEEN_SHARE = 0.5
PLACE_SD_PX = 0.1  # of each of two edges, of whatever else moves it
CONSISTENT_SDS = 3.0  # farther from what is foreseen, one of them is another edge
LEFT_SHARE = 0.25  # of how far an edge is moved back, that it may be off then, one sd; 0.4 makes fewer right
MOST_RATIO = 4.0  # of two heights: one is hardly seen beside a higher one
NEWTON_STEPS, MOST_NEWTON_STEP, LEAST_SLOPE = 12, 0.7, 0.2  # of the search for a maximum: within 0.01 blurs


class Edges(NamedTuple):
    """Edge points of N samples in C channels, (C, N) each as in `Observation`; NaN, inf, 0 for none."""

    offset: Floats
    sd: Floats
    strength: Floats


@kernel()
def blended(samples: Samples, softness: Floats, blur: Floats, edges: Edges) -> tuple[Floats, Floats]:
    """How far edges were moved by those beside them, and may be moved besides, (C, N) px along the normal.

    Parameters
    ----------
    softness
        (C, N), px, of each sample's line in each channel.
    blur
        (C, N), px, of its edge and the filter together.
    """
    image, direction = samples.image, samples.image_direction
    near = np.zeros(softness.shape[1])
    for c in range(len(softness)):
        for i in range(len(near)):
            widest = max(BLUR_RATIO * softness[c, i], blur[c, i])
            near[i] = max(near[i], FAR_BLURS * widest / ALONG_COSINE + PAST_PX)
    courses = line_courses(samples, near)
    moved, unsure = np.zeros(edges.offset.shape), np.zeros(edges.offset.shape)
    pairs = courses.pairs
    for number in range(len(pairs)):
        mine, other = pairs[number, 0], pairs[number, 1]
        own, their = course_of(image, courses, mine), course_of(image, courses, other)
        for i in range(own.first, own.last + 1):
            _, beyond, at = beside(image, direction, their, image[i, 0], image[i, 1])
            if not beyond <= PAST_PX or crosses(direction, own, their, i, at):
                continue
            gap = _gap(samples, their, i, at)
            at = at if their.bow > 0.0 else _next_to(samples, their, i)
            for c in range(len(softness)):
                width = BLUR_RATIO * softness[c, i]
                if abs(gap) >= FAR_BLURS * max(width, blur[c, i]):
                    continue
                by = math.nan
                if softness[c, i] > SHARP_PX:
                    by = _moved_by(samples, edges, (c, i, at), gap, blur[c, i])
                if math.isnan(by):
                    unsure[c, i] += UNSEEN_HEIGHT * gap * math.exp(-0.5 * (gap / width) ** 2)
                else:
                    moved[c, i] += by
                    unsure[c, i] += LEFT_SHARE * by
    return moved, unsure


@kernel(inline="always")
def _gap(samples: Samples, their: Course, i: int, at: int) -> float:
    """How far it is from sample ``i`` along its normal to another line, whose sample ``at`` is next to it."""
    image, direction = samples.image, samples.image_direction
    ux, uy = course_at(direction, their, at)
    x, y = image[i, 0] - image[at, 0], image[i, 1] - image[at, 1]
    along = x * ux + y * uy
    return float((x - along * ux) * direction[i, 1] - (y - along * uy) * direction[i, 0])


@kernel(inline="always")
def _next_to(samples: Samples, their: Course, i: int) -> int:
    """The sample of a straight line that is next to sample ``i`` of another one."""
    x, y = samples.image[i, 0] - their.x, samples.image[i, 1] - their.y
    share = (x * their.ux + y * their.uy) / their.length if their.length > 0.0 else 0.0
    return their.first + round(min(max(share, 0.0), 1.0) * (their.last - their.first))


@kernel(inline="always")
def _moved_by(samples: Samples, edges: Edges, where: tuple[int, int, int], gap: float, blur: float) -> float:
    """How far an edge was moved by one ``gap`` px away, along its normal; NaN where one of them is not seen,
    or is another edge. ``where`` : the channel, the sample, and that of the other line.
    """
    (c, i, at), direction = where, samples.image_direction
    mine, theirs = edges.strength[c, i], edges.strength[c, at]
    if mine == 0.0 or theirs == 0.0 or gap == 0.0:
        return math.nan
    same_way = direction[i, 0] * direction[at, 0] + direction[i, 1] * direction[at, 1] > 0.0
    sign = 1.0 if same_way else -1.0
    ratio = sign * theirs / mine
    ratio = math.copysign(min(max(abs(ratio), 1.0 / MOST_RATIO), MOST_RATIO), ratio)
    apart, towards = abs(gap) / blur, math.copysign(blur, gap)
    own, other = towards * _towards(ratio, apart), -towards * _towards(1.0 / ratio, apart)
    foreseen, seen = other - own, sign * edges.offset[c, at] - edges.offset[c, i]
    if foreseen == 0.0:
        return 0.0
    spread = (FORESEEN_SHARE * foreseen) ** 2
    noise = edges.sd[c, i] ** 2 + edges.sd[c, at] ** 2 + 2.0 * PLACE_SD_PX**2
    if (seen - foreseen) ** 2 > CONSISTENT_SDS**2 * (spread + noise):
        return math.nan
    return float(own * (1.0 + (seen / foreseen - 1.0) * spread / (spread + noise)))


@kernel()
def _towards(ratio: float, gap: float) -> float:
    """How far a step's maximum lies towards another step, at most half way, in units of their blur.

    ``ratio`` of the other's height over its own, ``gap`` > 0 between them. By Newton's method.
    """
    x = 0.0
    for _ in range(NEWTON_STEPS):
        pull = ratio * math.exp(gap * x - 0.5 * gap * gap)
        slope = max(1.0 + pull - gap * pull * (gap - x), LEAST_SLOPE)
        before = x
        x -= min(max((x - pull * (gap - x)) / slope, -MOST_NEWTON_STEP), MOST_NEWTON_STEP)
        if x == before:
            break
    return min(x, 0.5 * gap)
