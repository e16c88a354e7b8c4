"""Cutting lines that bend: chords of a rim, of a hole, of a round outline.

A line is followed as long as its edgels lie within a pixel or so of it, and a curve is seen as a few long
chords whose ends run 20 degrees and more beside the curve's direction. Cut into pieces that bend by little
each, every piece has the direction that the curve has there."""

from __future__ import annotations

import numpy as np

from numerics.arrays import Floats, Ints
from numerics.kernels import kernel
from vision_server.segments.line_fit import Edgels

MAX_BEND_RAD = 0.2  # of a piece, from end to end (by hand: directions then are right to 6 degrees)
LEAST_PIECE_PX = 8.0
CLEARLY = 4.0  # standard deviations by which a line must bend: straight ones stay whole


def cut_bent(edgels: Edgels) -> Edgels:
    """Groups of edgels with those that bend, as a parabola through them says, cut into equal pieces."""
    order = np.arange(len(edgels.points))
    starts = _cut(edgels.points, edgels.groups, order)
    if len(starts) == len(edgels.groups):
        return edgels
    return Edgels(edgels.points[order], edgels.normals[order], edgels.strengths[order], starts)


@kernel()
def _cut(points: Floats, groups: Ints, order: Ints) -> Ints:
    """The groups (M, 2) after the cuts; members of those that are cut are put in ``order`` along the line."""
    found = np.empty((len(points) + 1, 2), np.int64)
    pieces = 0
    for g in range(len(groups)):
        first, stop = groups[g, 0], groups[g, 1]
        along, bend, sd = _parabola(points[first:stop])
        count = 1
        if stop > first:
            length = along.max() - along.min()
            if abs(bend) > max(MAX_BEND_RAD, CLEARLY * sd):
                count = max(1, min(int(np.ceil(abs(bend) / MAX_BEND_RAD)), int(length / LEAST_PIECE_PX)))
        if count > 1:
            sorted_ = np.argsort(along)
            for k in range(len(sorted_)):
                order[first + k] = first + sorted_[k]
            along = along[sorted_]
            low = along[0]
        begin = first
        for piece in range(count):
            end = stop
            if piece < count - 1:
                end = first + np.searchsorted(along, low + length * (piece + 1) / count)
            found[pieces, 0], found[pieces, 1] = begin, end
            begin = end
            pieces += 1
    return found[:pieces].copy()


@kernel()
def _parabola(points: Floats) -> tuple[Floats, float, float]:
    """Place (n,) of points (n, 2) along their line, px; how they bend from end to end, and its sd, rad."""
    n = len(points)
    along, across = np.empty(n), np.empty(n)
    if n < 5:
        along[:] = 0.0
        return along, 0.0, np.inf
    mx, my = points[:, 0].mean(), points[:, 1].mean()
    sxx, sxy, syy = 0.0, 0.0, 0.0
    for k in range(n):
        dx, dy = points[k, 0] - mx, points[k, 1] - my
        sxx, sxy, syy = sxx + dx * dx, sxy + dx * dy, syy + dy * dy
    angle = 0.5 * np.arctan2(2.0 * sxy, sxx - syy)
    c, s = np.cos(angle), np.sin(angle)
    s2, s3, s4, curved = 0.0, 0.0, 0.0, 0.0
    for k in range(n):
        dx, dy = points[k, 0] - mx, points[k, 1] - my
        t, d = dx * c + dy * s, dy * c - dx * s
        along[k], across[k] = t, d
        s2, s3, s4 = s2 + t * t, s3 + t * t * t, s4 + t * t * t * t
        curved += t * t * d
    # of 1, t and t^2 - (s3 / s2) t - s2 / n, which are at right angles, the last is the bend; d has no slope
    square = s4 - s3 * s3 / s2 - s2 * s2 / n
    if square <= 0.0:
        return along, 0.0, np.inf
    quadratic, rest = curved / square, 0.0
    for k in range(n):
        t = along[k]
        rest += (across[k] - quadratic * (t * t - s3 / s2 * t - s2 / n)) ** 2
    turn = 2.0 * (along.max() - along.min())
    return along, turn * quadratic, turn * np.sqrt(rest / (n - 3) / square)
