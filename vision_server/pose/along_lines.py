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
    """How the visible lines run in the image, V of them, and which of them run along each other.

    Attributes
    ----------
    line : (V,), which line each is, ascending.
    ends : (V, 2), its first and last sample.
    along : (V, 3), the unit vector from the first to the last and their distance, zeros when they fall
        together.
    bow : (V,), px, how far an arc or outline is from that straight line; 0 of lines.
    pairs : (P, 2), which of the V, and another that runs about the same way, ascending.
    """

    line: Ints
    ends: Ints
    along: Floats
    bow: Floats
    pairs: Ints


@kernel()
def _ends(line: Ints) -> Ints:
    """First and last sample (V, 2) of each visible line, of the lines (N,) of all samples, ascending."""
    ends, count = np.empty((len(line), 2), dtype=np.int64), 0
    for i in range(len(line)):
        if i == 0 or line[i] != line[i - 1]:
            ends[count, 0] = i
            count += 1
        ends[count - 1, 1] = i
    return ends[:count].copy()


@kernel()
def _boxes(image: Floats, ends: Ints) -> Floats:
    """Bounds (V, 4) in the image of the samples (N, 2) of each line, from the first to the last (V, 2)."""
    box = np.empty((len(ends), 4))
    for m in range(len(ends)):
        for k in range(2):
            low, high = np.inf, -np.inf
            for i in range(ends[m, 0], ends[m, 1] + 1):
                low, high = min(low, image[i, k]), max(high, image[i, k])
            box[m, k], box[m, 2 + k] = low, high
    return box


@kernel()
def _near_pairs(box: Floats, near_px: Floats) -> Ints:
    """Lines and others whose bounds (V, 4) come as near to theirs as ``near_px`` (V,) says, (P, 2).

    From left to right: each line is held against those that begin before it has ended.
    """
    room = 16 * len(box)
    pairs, count, farthest = np.empty((room, 2), dtype=np.int64), 0, 0.0
    for near in near_px:
        farthest = max(farthest, near)
    in_order = np.argsort(box[:, 0], kind="mergesort")
    box, near_px = box[in_order], near_px[in_order]
    for k in range(len(in_order)):
        near, top, right, bottom = near_px[k], box[k, 1], box[k, 2], box[k, 3]
        for j in range(k + 1, len(in_order)):
            beside = box[j, 0] - right
            if beside > farthest:
                break
            apart = max(beside, box[j, 1] - bottom, top - box[j, 3])
            if apart > max(near, near_px[j]):
                continue
            if count + 2 > room:
                room *= 2
                longer = np.empty((room, 2), dtype=np.int64)
                for row in range(count):
                    longer[row, 0], longer[row, 1] = pairs[row, 0], pairs[row, 1]
                pairs = longer
            if apart <= near:
                pairs[count, 0], pairs[count, 1] = in_order[k], in_order[j]
                count += 1
            if apart <= near_px[j]:
                pairs[count, 0], pairs[count, 1] = in_order[j], in_order[k]
                count += 1
    return pairs[:count]


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
def _apart(image: Floats, ends: Ints, along: Floats, mine: int, other: int, near_px: float) -> bool:
    """Whether all of a straight line is farther than ``near_px`` to one side of another one's course."""
    a, first, last, ux, uy = ends[other, 0], ends[mine, 0], ends[mine, 1], along[other, 0], along[other, 1]
    begins = (image[first, 0] - image[a, 0]) * uy - (image[first, 1] - image[a, 1]) * ux
    finishes = (image[last, 0] - image[a, 0]) * uy - (image[last, 1] - image[a, 1]) * ux
    least = min(abs(begins), abs(finishes)) if begins * finishes > 0.0 else 0.0
    return bool(least > near_px + 2.0 * STRAIGHT_BOW_PX)


@kernel()
def line_courses(samples: Samples, near_px: Floats) -> Courses:
    """The courses of the lines, and others as near to each as one of its samples asks, ``near_px`` (N,)."""
    image, direction, ends = samples.image, samples.image_direction, _ends(samples.line)
    along, bow, near = np.zeros((len(ends), 3)), np.zeros(len(ends)), np.zeros(len(ends))
    for m in range(len(ends)):
        first, last = ends[m, 0], ends[m, 1]
        for i in range(first, last + 1):
            near[m] = max(near[m], near_px[i])
        x, y = image[last, 0] - image[first, 0], image[last, 1] - image[first, 1]
        length = math.sqrt(x * x + y * y)
        if length > 0.0:
            along[m, 0], along[m, 1], along[m, 2] = x / length, y / length, length
        for i in range(first + 1, last):
            x, y = image[i, 0] - image[first, 0], image[i, 1] - image[first, 1]
            bow[m] = max(bow[m], abs(x * along[m, 1] - y * along[m, 0]))
        if bow[m] < STRAIGHT_BOW_PX:
            bow[m] = 0.0
    pairs, count = _near_pairs(_boxes(image, ends), near), 0
    for number in range(len(pairs)):
        mine, other = pairs[number, 0], pairs[number, 1]
        middle = (ends[mine, 0] + ends[mine, 1]) // 2
        x, y = direction[middle, 0], direction[middle, 1]
        curved = along[other, 2] > 0.0 and (bow[mine] > 0.0 or bow[other] > 0.0)
        same_way = abs(along[other, 0] * x + along[other, 1] * y) >= ALONG_COSINE
        if curved or (same_way and not _apart(image, ends, along, mine, other, near[mine])):
            pairs[count, 0], pairs[count, 1] = mine, other
            count += 1
    in_order = _by_number(_by_number(pairs[:count], 1, len(ends)), 0, len(ends))
    return Courses(samples.line[ends[:, 0]], ends, along, bow, in_order)


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
def course_of(image: Floats, courses: Courses, m: int) -> Course:
    """The course of the m-th of the visible lines; ``image`` (N, 2) of the samples."""
    ends, along, first = courses.ends, courses.along, courses.ends[m, 0]
    x, y = image[first, 0], image[first, 1]
    ux, uy, length = along[m, 0], along[m, 1], along[m, 2]
    return Course(first, ends[m, 1], x, y, ux, uy, length, courses.bow[m])


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
