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

# Chosen by hand where nothing else is said.
ALONG_COSINE = 0.9  # lines that cross at more than about 25 degrees do not compete
BEYOND_PX = 2.0  # past its ends, where a line still has a claim
NEIGHBOUR_HEIGHT = 0.5  # of a neighbour's contrast over the edge's own; it is not known
FAR_BLURS = 5.0  # an edge this many blurs away moves another by under 1e-4 px
STRAIGHT_PX = 0.3  # arcs that are bowed by less are straight
SURELY_PX = 1e-6  # beyond what rounding could change
# Blur of an edge and of its filter together over the edge's softness: 1.12 with a filter half as wide as the
# softness, as they are now, 1.41 with one as wide.
BLUR_SHARE = 1.5


class _Courses(NamedTuple):
    """How the visible lines run in the image, and which of them run along each other.

    Attributes
    ----------
    ends : (L, 2), first and last sample of each line, -1 for none.
    along : (L, 3), the unit vector from the first to the last and their distance, zeros when they fall
        together.
    bow : (L,), px, how far an arc or outline is from that straight line; 0 of lines.
    pairs : (P, 2), a line and one that runs about the same way.
    """

    ends: Ints
    along: Floats
    bow: Floats
    pairs: Ints


@kernel()
def _boxes(line: Ints, image: Floats, ends: Ints) -> Floats:
    """Bounds (L, 4) in the image of the samples of each line; ``ends`` (L, 2), the first and last of them."""
    box = np.empty((len(ends), 4))
    for i in range(len(line)):
        m = line[i]
        if i == ends[m, 0]:
            for k in range(2):
                box[m, k], box[m, 2 + k] = image[i, k], image[i, k]
        for k in range(2):
            box[m, k], box[m, 2 + k] = min(box[m, k], image[i, k]), max(box[m, 2 + k], image[i, k])
    return box


@kernel()
def _near_pairs(visible: Ints, box: Floats, near_px: Floats) -> Ints:
    """Lines and others whose bounds (L, 4) come as near to theirs as ``near_px`` (L,) says, (P, 2) ascending.

    From left to right: each line is held against those that begin before it has ended.
    """
    room = 16 * len(visible)
    pairs, count, farthest = np.empty((room, 2), dtype=np.int64), 0, 0.0
    for mine in visible:
        farthest = max(farthest, near_px[mine])
    in_order = visible[np.argsort(box[visible, 0], kind="mergesort")]
    for k in range(len(in_order)):
        mine = in_order[k]
        for j in range(k + 1, len(in_order)):
            other = in_order[j]
            beside = box[other, 0] - box[mine, 2]
            if beside > farthest:
                break
            apart = max(beside, box[other, 1] - box[mine, 3], box[mine, 1] - box[other, 3])
            if apart > max(near_px[mine], near_px[other]):
                continue
            if count + 2 > room:
                room *= 2
                longer = np.empty((room, 2), dtype=np.int64)
                for row in range(count):
                    longer[row, 0], longer[row, 1] = pairs[row, 0], pairs[row, 1]
                pairs = longer
            if apart <= near_px[mine]:
                pairs[count, 0], pairs[count, 1] = mine, other
                count += 1
            if apart <= near_px[other]:
                pairs[count, 0], pairs[count, 1] = other, mine
                count += 1
    return _by_number(_by_number(pairs[:count], 1, len(box)), 0, len(box))


@kernel()
def _by_number(pairs: Ints, column: int, numbers: int) -> Ints:
    """Rows in the order of one column, of numbers from 0; equal ones stay as they are (a counting sort)."""
    place, out = np.zeros(numbers + 1, dtype=np.int64), np.empty_like(pairs)
    for k in range(len(pairs)):
        place[pairs[k, column] + 1] += 1
    for number in range(numbers):
        place[number + 1] += place[number]
    for k in range(len(pairs)):
        number = pairs[k, column]
        out[place[number], 0], out[place[number], 1] = pairs[k, 0], pairs[k, 1]
        place[number] += 1
    return out


@kernel()
def _apart(samples: Samples, ends: Ints, along: Floats, mine: int, other: int, near_px: float) -> bool:
    """Whether all of a straight line is farther than ``near_px`` to one side of another one's course."""
    image, a = samples.image, ends[other, 0]
    sides = np.empty(2)
    for k in range(2):
        i = ends[mine, k]
        dx, dy = image[i, 0] - image[a, 0], image[i, 1] - image[a, 1]
        sides[k] = dx * along[other, 1] - dy * along[other, 0]
    least = min(abs(sides[0]), abs(sides[1])) if sides[0] * sides[1] > 0.0 else 0.0
    return bool(least > near_px + 2.0 * STRAIGHT_PX)


@kernel()
def line_courses(samples: Samples, near_px: Floats) -> _Courses:
    """The courses of the lines, and which others come as near to each as its ``near_px`` (L,)."""
    lines = len(near_px)
    line, image, direction = samples.line, samples.image, samples.image_direction
    ends, along, bow = np.full((lines, 2), -1), np.zeros((lines, 3)), np.zeros(lines)
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
            for i in range(first + 1, last):
                x, y = image[i, 0] - image[first, 0], image[i, 1] - image[first, 1]
                bow[m] = max(bow[m], abs(x * along[m, 1] - y * along[m, 0]))
            if bow[m] < STRAIGHT_PX:
                bow[m] = 0.0
    box = _boxes(line, image, ends)
    pairs, count = _near_pairs(np.flatnonzero(ends[:, 0] >= 0), box, near_px), 0
    for number in range(len(pairs)):
        mine, other = pairs[number, 0], pairs[number, 1]
        middle = (ends[mine, 0] + ends[mine, 1]) // 2
        x, y = direction[middle, 0], direction[middle, 1]
        curved = along[other, 2] > 0.0 and (bow[mine] > 0.0 or bow[other] > 0.0)
        same_way = abs(along[other, 0] * x + along[other, 1] * y) >= ALONG_COSINE
        if curved or (same_way and not _apart(samples, ends, along, mine, other, near_px[mine])):
            pairs[count, 0], pairs[count, 1] = mine, other
            count += 1
    return _Courses(ends, along, bow, pairs[:count])


@kernel()
def beside(samples: Samples, courses: _Courses, other: int, x: float, y: float) -> tuple[float, float, int]:
    """Where a place is beside a line: how far from its straight course, how far past its ends, and at which
    of its samples, px.

    Of one that is bowed it is the course at the sample that is nearest.
    """
    image, direction = samples.image, samples.image_direction
    a, b = courses.ends[other, 0], courses.ends[other, 1]
    if courses.bow[other] == 0.0:
        ux, uy, length = courses.along[other, 0], courses.along[other, 1], courses.along[other, 2]
        dx, dy = x - image[a, 0], y - image[a, 1]
        along = dx * ux + dy * uy
        return abs(dx * uy - dy * ux), max(-along, along - length), a
    best, nearest = np.inf, a
    for i in range(a, b + 1):
        square = (x - image[i, 0]) ** 2 + (y - image[i, 1]) ** 2
        if square < best:
            best, nearest = square, i
    dx, dy = x - image[nearest, 0], y - image[nearest, 1]
    ux, uy = direction[nearest, 0], direction[nearest, 1]
    beyond = abs(dx * ux + dy * uy) if nearest in (a, b) else 0.0
    return abs(dx * uy - dy * ux), beyond, nearest


@kernel()
def _course_at(samples: Samples, courses: _Courses, other: int, at: int) -> tuple[float, float]:
    """Unit direction of a line: of its straight course, or of one that is bowed at its sample ``at``."""
    if courses.bow[other] > 0.0:
        return samples.image_direction[at, 0], samples.image_direction[at, 1]
    return courses.along[other, 0], courses.along[other, 1]


@kernel()
def _crosses(samples: Samples, courses: _Courses, mine: int, other: int, i: int, at: int) -> bool:
    """Whether a line, at its sample ``i``, runs otherwise than another one where that is next to it, at its
    sample ``at``; two straight ones do not, or they were no pair.
    """
    if courses.bow[mine] + courses.bow[other] == 0.0:
        return False
    x, y = _course_at(samples, courses, other, at)
    direction = samples.image_direction
    return bool(abs(direction[i, 0] * x + direction[i, 1] * y) < ALONG_COSINE)


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
        near[samples.line[i]] = max(near[samples.line[i]], 2.0 * farthest[i] + BEYOND_PX + 1.0)
    courses = line_courses(samples, near)
    for mine, other in courses.pairs:
        for i in range(courses.ends[mine, 0], courses.ends[mine, 1] + 1):
            apart, _, at = beside(samples, courses, other, image[i, 0], image[i, 1])
            if apart > 2.0 * farthest[i] + SURELY_PX or _crosses(samples, courses, mine, other, i, at):
                continue
            for c in range(channels):
                for k in range(peaks):
                    x = image[i, 0] - offset[c, i, k] * direction[i, 1]
                    y = image[i, 1] + offset[c, i, k] * direction[i, 0]
                    theirs, beyond, _ = beside(samples, courses, other, x, y)
                    if not beyond <= BEYOND_PX:
                        continue
                    ours = abs(offset[c, i, k])
                    if theirs < ours or (theirs == ours and other < mine):
                        offset[c, i, k] = np.nan


@kernel()
def neighbour_pulls(samples: Samples, lines: int, sigma: Floats) -> Floats:
    """How far an edge may be moved by one that runs beside it, (C, N) px along the normal, towards it.

    Two steps g apart, blurred by s each, answer with one maximum between them when g < 2 s, and otherwise
    with two. Each is g h / H exp(-g^2 / 2 s^2) nearer to the other one, whose height is h, than its own of
    height H is. The heights differ with the light: neighbours of NEIGHBOUR_HEIGHT times the edge's own are
    assumed.

    Parameters
    ----------
    sigma
        (C, L), px, softness of each line in each channel; the filter may be half as wide.
    """
    image, direction = samples.image, samples.image_direction
    near = np.zeros(lines)
    for c in range(len(sigma)):
        for m in range(lines):
            near[m] = max(near[m], FAR_BLURS * BLUR_SHARE * sigma[c, m] / ALONG_COSINE + BEYOND_PX)
    courses = line_courses(samples, near)
    out = np.zeros((len(sigma), len(image)))
    for mine, other in courses.pairs:
        for i in range(courses.ends[mine, 0], courses.ends[mine, 1] + 1):
            _, beyond, at = beside(samples, courses, other, image[i, 0], image[i, 1])
            if not beyond <= BEYOND_PX or _crosses(samples, courses, mine, other, i, at):
                continue
            ux, uy = _course_at(samples, courses, other, at)
            x, y = image[i, 0] - image[at, 0], image[i, 1] - image[at, 1]
            along = x * ux + y * uy
            gap = -(x - along * ux) * direction[i, 1] + (y - along * uy) * direction[i, 0]
            for c in range(len(sigma)):
                blur = BLUR_SHARE * sigma[c, mine]
                if abs(gap) < FAR_BLURS * blur:
                    out[c, i] -= NEIGHBOUR_HEIGHT * gap * math.exp(-0.5 * (gap / blur) ** 2)
    return out
