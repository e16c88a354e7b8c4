"""How the visible lines of a model run in the image, which run along each other, and what is beside them."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from geometry.visibility import Samples
from numerics.arrays import Floats, Ints
from numerics.kernels import kernel

# By hand: a wider angle lets lines that only cross take each other's edge points.
ALONG_COSINE = 0.9  # of the angle between lines that run along each other: about 25 degrees at most
STRAIGHT_BOW_PX = 0.3  # arcs that are bowed by less are taken for straight, which is quicker (by hand)


class Courses(NamedTuple):
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
    return bool(least > near_px + 2.0 * STRAIGHT_BOW_PX)


@kernel()
def line_courses(samples: Samples, near_px: Floats) -> Courses:
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
            if bow[m] < STRAIGHT_BOW_PX:
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
    return Courses(ends, along, bow, pairs[:count])


class Course(NamedTuple):
    """How one line runs in the image: numbers alone, as a kernel counts the references to arrays.

    Attributes
    ----------
    first, last : of its samples.
    x, y, ux, uy, length : where it begins, px, its unit direction, and how far it goes; of one that is bowed
        of the straight line between its ends.
    bow : see `Courses`.
    """

    first: int
    last: int
    x: float
    y: float
    ux: float
    uy: float
    length: float
    bow: float


@kernel()
def course_of(samples: Samples, courses: Courses, line: int) -> Course:
    """The course of one line, which is visible."""
    first, last = courses.ends[line]
    x, y = samples.image[first]
    ux, uy, length = courses.along[line]
    return Course(first, last, x, y, ux, uy, length, courses.bow[line])


@kernel(inline="always")
def beside(image: Floats, direction: Floats, other: Course, x: float, y: float) -> tuple[float, float, int]:
    """Where a place is beside a line: how far from its straight course, how far past its ends, and at which
    of its samples, px.

    Of one that is bowed it is the course at the sample that is nearest.
    """
    if other.bow == 0.0:
        dx, dy = x - other.x, y - other.y
        along = dx * other.ux + dy * other.uy
        apart, beyond, at = abs(dx * other.uy - dy * other.ux), max(-along, along - other.length), other.first
    else:
        apart, beyond, at = _beside_bowed(image, direction, other.first, other.last, x, y)
    return apart, beyond, at


@kernel()
def _beside_bowed(
    image: Floats, direction: Floats, first: int, last: int, x: float, y: float
) -> tuple[float, float, int]:
    """`beside`, of a line that is bowed."""
    best, nearest = np.inf, first
    for i in range(first, last + 1):
        square = (x - image[i, 0]) ** 2 + (y - image[i, 1]) ** 2
        if square < best:
            best, nearest = square, i
    dx, dy = x - image[nearest, 0], y - image[nearest, 1]
    ux, uy = direction[nearest, 0], direction[nearest, 1]
    beyond = abs(dx * ux + dy * uy) if nearest in (first, last) else 0.0
    return abs(dx * uy - dy * ux), beyond, nearest


@kernel(inline="always")
def course_at(direction: Floats, line: Course, at: int) -> tuple[float, float]:
    """Unit direction of a line: of its straight course, or of one that is bowed at its sample ``at``."""
    return (direction[at, 0], direction[at, 1]) if line.bow > 0.0 else (line.ux, line.uy)


@kernel(inline="always")
def crosses(direction: Floats, mine: Course, other: Course, i: int, at: int) -> bool:
    """Whether a line, at its sample ``i``, runs otherwise than another one where that is next to it, at its
    sample ``at``; two straight ones do not, or they were no pair.
    """
    x, y = course_at(direction, other, at)
    cosine = abs(direction[i, 0] * x + direction[i, 1] * y)
    return bool(mine.bow + other.bow > 0.0 and cosine < ALONG_COSINE)
