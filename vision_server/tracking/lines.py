"""Where each visible line of the model lies beside its edge points, and what rounded edges do to that."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from geometry.visibility import Samples
from numerics.arrays import Flags, Floats, Ints
from numerics.kernels import kernel
from vision_server.pose.observation import Observation, PoseProblem
from vision_server.pose.solver import SAMPLES_TOGETHER
from vision_server.pose.weights import SCATTER_PX

Edges = tuple[Floats, Floats, Flags, Ints, Floats, Floats, Floats]

# Chosen by hand where nothing else is said.
FEWEST = 4  # edge points of a line that show where it lies and how it is turned
FITS = 5  # of a line's straight course, reweighted
OFF_PX = 0.5  # from that course, at which an edge point counts half
LEAST_TURN = 0.05  # spread of a line's edge points, of 1/3 for even ones, that shows its turn
LEAST_VARIANCE_PX2 = 1e-6  # of a line in one channel
FLAT = 0.05  # 1 + cosine between two faces' normals, under which no edge is between them


class LineFits(NamedTuple):
    """Two numbers for each of M lines that a channel sees: its offset and its turn, px at its ends.

    Attributes
    ----------
    value, variance : (M, 2), and the variance by what scatters along the line, px^2.
    rows : (M, 2, 9), what a step of the pose (6, see `Observation`), the two nuisances and a metre of edge
        radius change.
    slack : (M,), px per metre of radius, to either side, within which a rounded edge may be seen.
    line : (M,), of the model.
    """

    value: Floats
    variance: Floats
    rows: Floats
    slack: Floats
    line: Ints


class Course(NamedTuple):
    """A straight line through the edge points of a line: where it is in the middle, and px at the ends."""

    middle: float
    offset: float
    turn: float
    spread: float
    scatter: float
    total: float
    squares: float


@kernel()
def _course(along: Floats, place: Floats, base: Floats, weight: Floats) -> Course:
    """Robust, by reweighting; all (K,), ``weight`` is written to."""
    middle, offset, turn, spread, scatter, total, squares = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for fit in range(FITS):
        total, squares, sum_x, sum_d = 0.0, 0.0, 0.0, 0.0
        for i in range(len(along)):
            weight[i] = 0.0
            if base[i] > 0.0:
                off = place[i] - offset - turn * (along[i] - middle)
                weight[i] = base[i] / (1.0 + ((off / OFF_PX) ** 2 if fit > 0 else 0.0))
                total += weight[i]
                squares += weight[i] ** 2
                sum_x += weight[i] * along[i]
                sum_d += weight[i] * place[i]
        middle, offset = sum_x / total, sum_d / total
        spread, product, scatter = 0.0, 0.0, 0.0
        for i in range(len(along)):
            if weight[i] > 0.0:
                spread += weight[i] * (along[i] - middle) ** 2 / total
                product += weight[i] * (along[i] - middle) * place[i] / total
        turn = product / spread if spread > LEAST_TURN else 0.0
        for i in range(len(along)):
            if weight[i] > 0.0:
                scatter += weight[i] * (place[i] - offset - turn * (along[i] - middle)) ** 2 / total
    return Course(middle, offset, turn, spread, scatter, total, squares)


@kernel()
def line_fits(seen: Observation, base: Floats, rounding: Floats, slack: Floats) -> LineFits:
    """Robust straight courses of the edge points along each line, in each channel.

    Parameters
    ----------
    base : (C, N), weights of the edge points, 1/px^2.
    rounding, slack : (N,), see `rounding_shifts`.
    """
    line, count = seen.samples.line, base.shape[1]
    most = len(base) * seen.sigma.shape[1]
    value, variance, rows = np.zeros((most, 2)), np.zeros((most, 2)), np.zeros((most, 2, 9))
    weight, loose, found = np.zeros(count), np.zeros(most), 0
    number = np.zeros(most, dtype=np.int64)
    change = np.empty((count, 9))
    change[:, :6], change[:, 8] = seen.jacobian, rounding
    for c in range(len(base)):
        change[:, 6:8] = seen.nuisance[c]
        start = 0
        while start < count:
            end, points = start, 0
            while end < count and line[end] == line[start]:
                points += base[c, end] > 0.0
                end += 1
            if points >= FEWEST:
                along = seen.along[start:end]
                course = _course(along, seen.offset[c, start:end], base[c, start:end], weight[start:end])
                share, turned = points / (end - start), course.spread > LEAST_TURN
                doubt = (1.0 + course.scatter / SCATTER_PX**2) / (share * share)
                noise = doubt * course.scatter * SAMPLES_TOGETHER * course.squares / course.total**2
                value[found, 0], value[found, 1] = course.offset, course.turn
                variance[found, 0] = noise
                variance[found, 1] = noise / course.spread if turned else math.inf
                number[found] = line[start]
                for i in range(start, end):
                    own = weight[i] / course.total
                    across = own * (seen.along[i] - course.middle) / course.spread if turned else 0.0
                    loose[found] += own * slack[i]
                    for k in range(9):
                        rows[found, 0, k] += own * change[i, k]
                        rows[found, 1, k] += across * change[i, k]
                found += 1
            start = end
    return LineFits(value[:found], variance[:found], rows[:found], loose[:found], number[:found])


def united(lines: LineFits) -> LineFits:
    """One of each line, whatever channels see it: what it is off, it is off in all of them."""
    _, first, number = np.unique(lines.line, return_index=True, return_inverse=True)
    count, precision = len(first), 1.0 / np.maximum(lines.variance, LEAST_VARIANCE_PX2)
    total = np.stack([np.bincount(number, precision[:, k], count) for k in range(2)], axis=1)
    share = precision / np.where(total > 0.0, total, 1.0)[number]
    value, rows, slack = np.zeros((count, 2)), np.zeros((count, 2, 9)), np.zeros(count)
    np.add.at(value, number, share * lines.value)
    np.add.at(rows, number, share[:, :, None] * lines.rows)
    np.add.at(slack, number, share[:, 0] * lines.slack)
    variance = np.where(total > 0.0, 1.0 / np.where(total > 0.0, total, 1.0), np.inf)
    return LineFits(value, variance, rows, slack, lines.line[first])


def rounding_shifts(problem: PoseProblem, pose: Pose, seen: Observation) -> tuple[Floats, Floats]:
    """How far edges lie along their normals where the model's convex edges are rounded, px per m of radius.

    Of an edge with the faces' normals n and m, the axis of the rounding lies at -r a from it, with a =
    (n + m) / (1 + n.m). An outline is where the line of sight touches the rounding: off by r (1 - a.u) u,
    where u points outwards across the line of sight. Of a crease between two faces in sight, the middle of
    the rounding is taken; where on it brightness changes most is the light's affair.

    Returns
    -------
    The shift (N,), and how far a crease may be from there to either side; 0 for lines of open, smooth or
    hollow places.
    """
    model, line = problem.model, seen.samples.line
    if not model.faces:
        return np.zeros(len(line)), np.zeros(len(line))
    found = _roundings(*_edges(model, problem.camera, pose, seen.samples))
    return found[0], found[1]


def _edges(model: Model, camera: Camera, pose: Pose, samples: Samples) -> Edges:
    """What `_roundings` and `_outward` ask of the lines, (L,), and of the samples on them, (N,).

    Normals of the two faces at each line (L, 3), and whether it is sharp and convex; line (N,), points and
    unit vectors along the lines (N, 3), camera frame; normals in the image times the focal lengths (N, 2).
    """
    normals = model.face_normals @ pose.matrix.T
    return (
        normals[model.line_faces[:, 0]],
        normals[model.line_faces[:, 1]],
        _rounds(model),
        samples.line,
        pose.apply(samples.points),
        samples.direction @ pose.matrix.T,
        samples.normal * [camera.fx, camera.fy],
    )


@kernel()
def _roundings(
    one: Floats, two: Floats, rounds: Flags, line: Ints, points: Floats, along: Floats, focal: Floats
) -> Floats:
    """Both of `rounding_shifts`, (2, N)."""
    out = np.zeros((2, len(line)))
    for i in range(len(line)):
        n, m, point = one[line[i]], two[line[i]], points[i]
        cosine = n[0] * m[0] + n[1] * m[1] + n[2] * m[2]
        if not rounds[line[i]] or 1.0 + cosine <= FLAT:
            continue
        facing_n = n[0] * point[0] + n[1] * point[1] + n[2] * point[2]
        facing_m = m[0] * point[0] + m[1] * point[1] + m[2] * point[2]
        both, apex = n + m, (n + m) / (1.0 + cosine)
        if facing_n < 0.0 and facing_m < 0.0:
            shift = both / max(math.sqrt(2.0 + 2.0 * cosine), FLAT) - apex
            out[1, i] = abs(_across(0.5 * (n - m), point, focal[i]))
        else:
            outward = np.empty(3)
            for k in range(3):
                p, q = (k + 1) % 3, (k + 2) % 3
                outward[k] = point[p] * along[i, q] - point[q] * along[i, p]
            outward /= math.sqrt((outward**2).sum()) * (1.0 if (outward * both).sum() >= 0.0 else -1.0)
            shift = (1.0 - (outward * apex).sum()) * outward
        out[0, i] = _across(shift, point, focal[i])
    return out


@kernel()
def _across(shift: Floats, point: Floats, focal: Floats) -> float:
    """How far a shift (3,) of a point moves it in the image along the normal that ``focal`` is, px."""
    x, y = shift[0] - shift[2] * point[0] / point[2], shift[1] - shift[2] * point[1] / point[2]
    return float((x * focal[0] + y * focal[1]) / point[2])


def outward_of(model: Model, camera: Camera, pose: Pose, samples: Samples) -> Floats:
    """On which side of its line the target ends, (N,): 1 ahead along the normal, -1 behind, 0 of no outline.

    A line between two faces is an outline where one of them is turned away; those of smooth or hollow places
    are left out.
    """
    if not model.faces:
        return np.zeros(len(samples.line))
    found: Floats = _outward(*_edges(model, camera, pose, samples))
    return found


@kernel()
def _outward(
    one: Floats, two: Floats, rounds: Flags, line: Ints, points: Floats, along: Floats, focal: Floats
) -> Floats:
    """See `outward_of`."""
    out, across = np.zeros(len(line)), np.empty(3)
    for i in range(len(line)):
        n, m, point = one[line[i]], two[line[i]], points[i]
        if rounds[line[i]] and (n * point).sum() * (m * point).sum() < 0.0:
            for k in range(3):
                p, q = (k + 1) % 3, (k + 2) % 3
                across[k] = point[p] * along[i, q] - point[q] * along[i, p]
            out[i] = np.sign((across * (n + m)).sum()) * np.sign(_across(across, point, focal[i]))
    return out


@lru_cache(maxsize=8)
def _rounds(model: Model) -> Flags:
    """Which lines are sharp convex edges between two faces, (L,)."""
    middles = np.array([model.vertices[face].mean(axis=0) for face in model.faces])
    one, two = model.line_faces[:, 0], model.line_faces[:, 1]
    place = model.vertices[model.lines].mean(axis=1)
    behind = ((middles[two] - place) * model.face_normals[one]).sum(axis=1) < 0.0
    closed = ~(model.two_sided[one] | model.two_sided[two])
    return np.asarray(behind & closed & (one >= 0) & (two >= 0) & ~model.smooth)
