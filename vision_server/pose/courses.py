"""What each channel says of each line as a whole: where its edge points lie, and how far off that may be.

A line's edge points in one channel tell where it is and how it is turned, two numbers, more exactly than what
lies beside it lets it be: a shadow, texture, a side that is not as it was drawn move all of them together.
How far, the profile across the edge tells (`profiles`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from numerics.arrays import Floats, Ints
from numerics.kernels import kernel
from vision_server.channels.noise import MAD_TO_SD
from vision_server.pose.covariance import LEAST_SCATTER_PX2
from vision_server.pose.observation import Observation, PoseProblem
from vision_server.pose.profiles import Place, moved_by_profiles
from vision_server.pose.solver import SAMPLES_TOGETHER, TUKEY
from vision_server.pose.weights import base_weights

CLIPPED_SPREAD_PX = 0.4  # of a line's place beside saturated pixels, one sd per px of softness
FEWEST_COURSE_POINTS = 2  # edge points of a line in a channel that hold its place and turn
# Chosen by hand: an edge point farther from its line's own course is none of it, at first and at least. At
# first as far as `hough.choose` takes them, at least as far as `profiles` does, both on sharp edges.
FIRST_COURSE_CUT_PX, LEAST_COURSE_CUT_PX = 1.5, 0.55
COURSE_ITERATIONS = 4  # of reweighting; chosen by hand, as `solver.SOLVER_ITERATIONS` is
COURSE_PRIOR_SHARE = 1e-3  # of its weight, that a line is where it was: one seen as a point tells no turn
TURN_SPREAD_RATIO = 0.7  # what the end of a line is off by turning, over what its middle is (by hand)
BLUR, ROUNDNESS = 8, 11  # after rotation, translation and two nuisances; and after two stretches


class Courses(NamedTuple):
    """What each channel says of each line that it shows: M pairs of both, K unknowns.

    Attributes
    ----------
    place : (M, 2), px along the normal: of the line's middle, and from there to its end by turning; without
        what `profiles` says to have moved it.
    motion : (M, 2, K), change of both per unit of each unknown.
    noise : (M, 2, 2), covariance of both by what the edge points scatter, px^2.
    spread : (M,), one sd of what it may be off as a whole, px.
    share : (M,), of all that is said of the line; of each line 1 in all.
    line, channel : (M,), index into the model's lines and into the channels.
    bow : (M, 2), of the roundness (`roundness`), as it is told by how edge points run within the line: its
        precision times itself, and its precision.
    """

    place: Floats
    motion: Floats
    noise: Floats
    spread: Floats
    share: Floats
    line: Ints
    channel: Ints
    bow: Floats

    @property
    def variance(self) -> Floats:
        """Covariance (M, 2, 2) of what both may be off, px^2, the line as a whole and its edge points."""
        return self.noise + self.spread[:, None, None] ** 2 * np.diag([1.0, TURN_SPREAD_RATIO**2])


class _Beside(NamedTuple):
    """Of each of M courses: what neighbours and saturation may move it, px; edge points over samples; how far
    off the part's line may be, px.
    """

    moved: Floats
    covered: Floats
    tolerance: Floats


def courses_of(problem: PoseProblem, seen: Observation, more: Floats) -> Courses:
    """Courses of the lines in each channel, by the pose's unknowns, two nuisances, the blur of outlines in
    its sd (see `profiles.Moved`), and ``more`` (N, J), px.
    """
    base = base_weights(seen, True)
    unknowns, lines = BLUR + 1 + more.shape[1], 1 + int((np.diff(seen.samples.line) != 0).sum())
    room = len(base) * lines
    place, motion, noise = (np.zeros((room, *of)) for of in ((2,), (2, unknowns), (2, 2)))
    spread, weight, beside = np.zeros(room), np.zeros(room), _Beside(*np.zeros((3, room)))
    line, channel = np.zeros(room, dtype=np.int64), np.zeros(room, dtype=np.int64)
    bow = np.zeros((room, 2))
    count = _read(seen, base, more, Courses(place, motion, noise, spread, weight, line, channel, bow), beside)
    place, weight, line, channel = place[:count], weight[:count], line[:count], channel[:count]
    moved, covered, tolerance = (part[:count] for part in beside)
    by = moved_by_profiles(problem, seen, Place(place, line, channel))
    place[:, 0] -= by.place
    motion[:count, 0, BLUR] = by.shared
    spread = np.hypot(np.hypot(by.sd, moved) / covered, tolerance)
    share = weight / np.bincount(line, weight)[line] if count else weight
    return Courses(place, motion[:count], noise[:count], spread, share, line, channel, bow[:count])


@kernel()
def _read(seen: Observation, base: Floats, more: Floats, out: Courses, beside: _Beside) -> int:
    """How many courses there are; outputs have room for all, with weights for shares and without spreads."""
    line, channels, count = seen.samples.line, len(base), len(more)
    weight, residual, room = np.empty(count), np.empty(count), np.empty(count)
    start, found = 0, 0
    while start < count:
        end = start
        while end < count and line[end] == line[start]:
            end += 1
        for c in range(channels):
            along, offset = seen.along[start:end], seen.offset[c, start:end]
            inverse, course = _straight(along, offset, base[c, start:end], weight, residual, room)
            fit = (weight, residual, inverse)
            if _is_course(seen, (c, start, end), fit, more, out, beside, found):
                out.place[found], out.line[found], out.channel[found] = course, line[start], c
                found += 1
        start = end
    return found


@kernel()
def _is_course(
    seen: Observation,
    where: tuple[int, int, int],
    fit: tuple[Floats, Floats, Floats],
    more: Floats,
    out: Courses,
    others: _Beside,
    m: int,
) -> bool:
    """Whether enough edge points of a channel and its samples from one up to another are on a line's course.

    ``fit``: weights, residuals and inverse of `_straight`. Outputs are filled in at m.
    """
    (c, start, end), (weight, residual, inverse) = where, fit
    total, scatter, clipped, beside, tolerance, found = 0.0, 0.0, 0.0, 0.0, 0.0, 0
    unknowns = out.motion.shape[2]
    pull, square, row = np.zeros((2, unknowns)), np.zeros((2, 2)), np.empty(unknowns)
    for i in range(start, end):
        w, t = weight[i - start], seen.along[i]
        if not w > 0.0:
            continue
        found += 1
        total += w
        scatter += w * residual[i - start] ** 2
        clipped += w * (seen.nuisance[c, i, 1] != 0.0)
        beside += w * abs(seen.neighbours[c, i])
        tolerance += w * seen.tolerance[i]
        row[:6], row[6:BLUR], row[BLUR], row[BLUR + 1 :] = seen.jacobian[i], seen.nuisance[c, i], 0.0, more[i]
        pull[0] += w * row
        pull[1] += w * t * row
        square[0, 0] += w * w
        square[0, 1] += w * w * t
        square[1, 1] += w * w * t * t
    if found < FEWEST_COURSE_POINTS:
        return False
    sigma = seen.sigma[c, seen.samples.line[start]]
    variance = SAMPLES_TOGETHER * max(scatter / total, LEAST_SCATTER_PX2)
    square[1, 0] = square[0, 1]
    for k in range(2):
        out.motion[m, k] = inverse[k, 0] * pull[0] + inverse[k, 1] * pull[1]
        for j in range(2):
            for a in range(2):  # sums, as products of matrices load SciPy
                for b in range(2):
                    out.noise[m, k, j] += variance * inverse[k, a] * square[a, b] * inverse[b, j]
    if unknowns > ROUNDNESS:
        _add_bow(seen, where, (weight, residual), more, variance * square[0, 0] / total, out, m)
    others.moved[m] = math.hypot(CLIPPED_SPREAD_PX * sigma * clipped, beside) / total
    others.covered[m], others.tolerance[m] = found / (end - start), tolerance / total
    out.share[m] = total
    return True


@kernel()
def _add_bow(
    seen: Observation,
    where: tuple[int, int, int],
    fit: tuple[Floats, Floats],
    more: Floats,
    variance: float,
    out: Courses,
    m: int,
) -> None:
    """What the m-th course tells of roundness by how its edge points lie about their straight course.

    ``variance``, px^2 times the weight of an edge point, of one that is independent of the others.
    """
    (_, start, end), (weight, residual) = where, fit
    for i in range(start, end):
        w = weight[i - start]
        if w > 0.0 and seen.inside[i] == 0.0:  # outlines are drawn inwards by shading, here more, there less
            straight = out.motion[m, 0, ROUNDNESS] + seen.along[i] * out.motion[m, 1, ROUNDNESS]
            bent = more[i, ROUNDNESS - BLUR - 1] - straight
            out.bow[m, 0] += w * bent * residual[i - start] / variance
            out.bow[m, 1] += w * bent * bent / variance


@kernel()
def _straight(
    along: Floats, offset: Floats, base: Floats, weight: Floats, residual: Floats, room: Floats
) -> tuple[Floats, Floats]:
    """The straight course (2,) of a line's edge points, and the inverse (2, 2) of its normal matrix, 1/px^2.

    Weights, 0 for those that are none of it, and residuals, px, are output, N or more; ``room`` to work in.
    """
    inverse, course = np.zeros((2, 2)), np.zeros(2)
    cut = FIRST_COURSE_CUT_PX
    for iteration in range(COURSE_ITERATIONS):
        total, first, second, level, slope = 0.0, 0.0, 0.0, 0.0, 0.0
        for i in range(len(along)):
            weight[i] = base[i]
            if iteration > 0 and base[i] > 0.0:
                weight[i] *= max(0.0, 1.0 - (residual[i] / cut) ** 2) ** 2
            if weight[i] > 0.0:
                total += weight[i]
                first += weight[i] * along[i]
                second += weight[i] * along[i] ** 2
                level += weight[i] * offset[i]
                slope += weight[i] * along[i] * offset[i]
        if not total > 0.0:
            return inverse, course
        level_weight, turn_weight = total * (1.0 + COURSE_PRIOR_SHARE), second + total * COURSE_PRIOR_SHARE
        determinant = level_weight * turn_weight - first * first
        inverse[0, 0], inverse[1, 1] = turn_weight / determinant, level_weight / determinant
        inverse[0, 1] = inverse[1, 0] = -first / determinant
        course[0] = inverse[0, 0] * level + inverse[0, 1] * slope
        course[1] = inverse[1, 0] * level + inverse[1, 1] * slope
        found = 0
        for i in range(len(along)):
            if base[i] > 0.0:
                residual[i] = offset[i] - course[0] - course[1] * along[i]
                room[found] = abs(residual[i])
                found += weight[i] > 0.0
        cut = max(LEAST_COURSE_CUT_PX, TUKEY * MAD_TO_SD * np.median(room[:found]))
    return inverse, course
