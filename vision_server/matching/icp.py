"""Score poses against the nearest image edges, and align them with these: iterative closest point.

In go poses with what is visible from them, and the table of `nearest_edges`; out come scores, or the poses
moved. Each step is one of robust least squares from point to line (Besl and McKay 1992; Chen and Medioni
1992), with Tukey's weights; `score_poses` and `align` are the definitions.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from geometry.rotation import matrix_of
from numerics.arrays import Floats, Ints
from numerics.cholesky import solve_positive
from numerics.kernels import kernel
from vision_server.matching.nearest_edges import (
    CELL_PX,
    NO_SEGMENT,
    PIECE_PX,
    NearestEdges,
    bin_of,
    offset,
    piece_of,
)
from vision_server.matching.views import ViewTable

# Sines of angles between model line and segment, by hand: at the first support ends; beyond the second a
# segment is no partner, as clutter then has little to hold on to, which shrinks to the third with the reach,
# from this one on.
SUPPORT_SINE, PARTNER_SINE, LEAST_PARTNER_SINE, FULL_SINE_REACH_PX = 0.25, 0.15, 0.08, 12.0
# Support of a pixel of model line that chance gives; less than this counts against a pose. With 0.4, for
# which the lines of a blurred or dark target show too little, 15 of 448 poses on ray-traced hard scenes are
# not right that are with this, and two are.
CHANCE_SUPPORT = 0.1
DAMPING, LEAST_DIAGONAL = 1e-3, 1e-12  # of the normal equations' diagonal, and added to it (Marquardt)
MAX_TURN_RAD = 0.2  # largest rotation of one step: the equations are linear in it (by hand)
LEAST_DEPTH_M = 1e-6  # of an end of a line: what is nearer has no direction in the image


_matrix_of = kernel()(matrix_of)


class Merit(NamedTuple):
    """What a pose is scored by: support over chance, summed and divided by this power of the length.

    ``once``: a piece of an image edge supports no more than its length, however many lines lie on it.
    """

    power: float
    once: bool


SUM = Merit(0.0, False)  # between poses that all show about the same lines
# Between near and far poses, of more and of fewer lines: how far the sum is beyond what chance gives, in
# units of its scatter. A large target of which half is seen is worth more than a speck that lies on an edge,
# or than a part seen edge-on, of which all lines lie on the longest edge that there is.
SIGNIFICANCE = Merit(0.5, True)


class Lookup(NamedTuple):
    """What a pose is held against: the nearest image edges, the model's samples by view, fx fy cx cy (4,)."""

    edges: NearestEdges
    views: ViewTable
    intrinsics: Floats


@kernel()
def image_direction(
    ends: Floats, run: int, r: Floats, t: Floats, fx: float, fy: float
) -> tuple[float, float]:
    """Unit direction in the image of a line (Q, 2, 3); (0, 0) when an end is not in front of the camera."""
    ax, ay, az = ends[run, 0, 0], ends[run, 0, 1], ends[run, 0, 2]
    bx, by, bz = ends[run, 1, 0], ends[run, 1, 1], ends[run, 1, 2]
    za = r[2, 0] * ax + r[2, 1] * ay + r[2, 2] * az + t[2]
    zb = r[2, 0] * bx + r[2, 1] * by + r[2, 2] * bz + t[2]
    if za <= LEAST_DEPTH_M or zb <= LEAST_DEPTH_M:
        return 0.0, 0.0
    dx = (r[0, 0] * bx + r[0, 1] * by + r[0, 2] * bz + t[0]) / zb
    dx -= (r[0, 0] * ax + r[0, 1] * ay + r[0, 2] * az + t[0]) / za
    dy = (r[1, 0] * bx + r[1, 1] * by + r[1, 2] * bz + t[1]) / zb
    dy -= (r[1, 0] * ax + r[1, 1] * ay + r[1, 2] * az + t[1]) / za
    dx, dy = fx * dx, fy * dy
    length = math.sqrt(dx * dx + dy * dy)
    return (dx / length, dy / length) if length > 0.0 else (0.0, 0.0)


@kernel(inline="always")  # a call would count references per sample
def _seen(
    points: Floats, s: int, r: Floats, t: Floats, intrinsics: Floats
) -> tuple[float, float, float, float, float, float]:
    """Point s (S, 3) turned into the camera's axes, 1 / its depth, and its place in the image, px."""
    x, y, z = points[s, 0], points[s, 1], points[s, 2]
    a = r[0, 0] * x + r[0, 1] * y + r[0, 2] * z
    b = r[1, 0] * x + r[1, 1] * y + r[1, 2] * z
    c = r[2, 0] * x + r[2, 1] * y + r[2, 2] * z
    inverse = 1.0 / (c + t[2])
    x = intrinsics[0] * (a + t[0]) * inverse + intrinsics[2]
    y = intrinsics[1] * (b + t[1]) * inverse + intrinsics[3]
    return a, b, c, inverse, x, y


@kernel(inline="always")
def _inside(x: float, y: float, width: float, height: float) -> bool:
    """Whether a place is in the image."""
    return -0.5 <= x < width - 0.5 and -0.5 <= y < height - 0.5


@kernel()
def score_pose(
    lookup: Lookup,
    view: int,
    r: Floats,
    t: Floats,
    reach_px: float,
    every: int,
    merit: Merit,
    unclaimed: Floats,
) -> tuple[float, float]:
    """Score of one pose, see `score_poses`, and the share of its image length with an edge within reach.

    ``unclaimed`` is room for how much of each piece of the image's edges supports nothing yet, px.
    """
    edges, views, intrinsics = lookup.edges, lookup.views, lookup.intrinsics
    points, px, gains, labels, segments = views.points, views.px, edges.gain, edges.label, edges.segments
    width, height = edges.size[0], edges.size[1]
    score, near, total = 0.0, 0.0, 0.0
    if merit.once:
        unclaimed[:] = PIECE_PX
    for q in range(views.first[view], views.first[view + 1]):
        ux, uy = image_direction(views.ends, q, r, t, intrinsics[0], intrinsics[1])
        if ux == 0.0 and uy == 0.0:
            continue
        bin_ = bin_of(ux, uy)
        length = views.run[q + 1] - views.run[q]
        start = views.run[q] + min(every, length) // 2
        stands_for = length / (1.0 + (views.run[q + 1] - 1 - start) // every)
        for s in range(start, views.run[q + 1], every):
            _, _, _, _, x, y = _seen(points, s, r, t, intrinsics)
            if not _inside(x, y, width, height):
                continue
            row, column = int((y + 0.5) / CELL_PX), int((x + 0.5) / CELL_PX)
            weight = px[s] * stands_for
            gain, segment = 0.0, NO_SEGMENT
            if merit.once or reach_px > 0.0:
                segment = labels[bin_, row, column]
            if reach_px == 0.0:
                gain = gains[bin_, row, column] / 255.0
            elif segment != NO_SEGMENT:
                _, distance = offset(segments, segment, x, y)
                turn = abs(ux * segments[segment, 3] - uy * segments[segment, 2])
                gain = max(0.0, 1.0 - distance / reach_px) * max(0.0, 1.0 - turn / SUPPORT_SINE)
                near += weight if distance < reach_px else 0.0
            support = weight * gain
            if merit.once and segment != NO_SEGMENT:
                piece = piece_of(edges, segment, x, y)
                support = min(support, unclaimed[piece])
                unclaimed[piece] -= support
            score += support - weight * CHANCE_SUPPORT
            total += weight
    if total <= 0.0:
        return 0.0, 0.0
    return score / total**merit.power, near / total


@kernel()
def score_poses(
    lookup: Lookup,
    view: Ints,
    rotations: Floats,
    translations: Floats,
    reach_px: float,
    every: int = 1,
    merit: Merit = SUM,
) -> Floats:
    """Score of each pose: sum over visible samples of px · (max(0, 1 − d/reach) − chance), (N,).

    d is the distance to the nearest image segment of like direction; samples outside the image are
    skipped. A reach of 0 takes the gains of the grid, whose reach is GAIN_REACH_PX: coarse and fast. Only
    every so manyth sample of a line is looked at, and stands for those between.
    """
    out = np.zeros(len(view))
    unclaimed = np.empty(lookup.edges.first_piece[-1])
    for i in range(len(view)):
        r, t = rotations[i], translations[i]
        out[i] = score_pose(lookup, view[i], r, t, reach_px, every, merit, unclaimed)[0]
    return out


@kernel()
def align(
    lookup: Lookup, view: int, rotation: Floats, translation: Floats, reach_px: float, iterations: int
) -> None:
    """Move one pose (3, 3), (3,), in place, so that the samples of its view come to lie on image segments.

    Residual: distance to the nearest segment's line; weight: px · (1 − (d/reach)²)², d the distance
    to the segment itself; segments of another direction are left out. The step turns about the target's
    origin by at most MAX_TURN_RAD. One after which less fits is taken back, and is the last: along a slender
    part hardly anything holds the pose, and it would run away.
    """
    normal, gradient, best = np.empty((6, 6)), np.empty(6), -1.0
    before_rotation, before_translation = rotation.copy(), translation.copy()
    for number in range(iterations + 1):
        fit = normal_equations(lookup, view, rotation, translation, reach_px, normal, gradient)
        if fit < best:
            rotation[:], translation[:] = before_rotation, before_translation
            return
        if number == iterations:
            return
        best = fit
        before_rotation[:], before_translation[:] = rotation, translation
        step = solve_positive(normal, gradient, DAMPING, LEAST_DIAGONAL)
        turn = math.sqrt(step[0] * step[0] + step[1] * step[1] + step[2] * step[2])
        if turn > MAX_TURN_RAD:
            step *= MAX_TURN_RAD / turn
        turned = _matrix_of(step[:3])
        for k in range(3):
            x, y, z = rotation[0, k], rotation[1, k], rotation[2, k]
            for i in range(3):
                rotation[i, k] = turned[i, 0] * x + turned[i, 1] * y + turned[i, 2] * z
            translation[k] += step[3 + k]


@kernel()
def normal_equations(
    lookup: Lookup, view: int, r: Floats, t: Floats, reach_px: float, normal: Floats, gradient: Floats
) -> float:
    """Normal equations of one step of `align`: lower triangle (6, 6) and right-hand side (6,), outputs.

    Returns
    -------
    What fits: sum of px · (1 − (d/reach)²)³, which the step would raise.
    """
    edges, views, intrinsics = lookup.edges, lookup.views, lookup.intrinsics
    fx, fy, cx, cy = intrinsics[0], intrinsics[1], intrinsics[2], intrinsics[3]
    points, px, labels, segments = views.points, views.px, edges.label, edges.segments
    width, height = edges.size[0], edges.size[1]
    row = np.empty(6)
    turn_limit = max(LEAST_PARTNER_SINE, min(PARTNER_SINE, PARTNER_SINE * reach_px / FULL_SINE_REACH_PX))
    normal[:], gradient[:], fit = 0.0, 0.0, 0.0
    for q in range(views.first[view], views.first[view + 1]):
        ux, uy = image_direction(views.ends, q, r, t, fx, fy)
        if ux == 0.0 and uy == 0.0:
            continue
        bin_ = bin_of(ux, uy)
        for s in range(views.run[q], views.run[q + 1]):
            a, b, c, z, x, y = _seen(points, s, r, t, intrinsics)
            if not _inside(x, y, width, height):
                continue
            segment = labels[bin_, int((y + 0.5) / CELL_PX), int((x + 0.5) / CELL_PX)]
            if segment == NO_SEGMENT:
                continue
            across, distance = offset(segments, segment, x, y)
            turn = abs(ux * segments[segment, 3] - uy * segments[segment, 2])
            if distance >= reach_px or turn >= turn_limit:
                continue
            share = 1.0 - (distance / reach_px) ** 2
            weight = px[s] * share * share
            fit += weight * share
            gx = -segments[segment, 3] * fx * z
            gy = segments[segment, 2] * fy * z
            gz = -(gx * (x - cx) / fx + gy * (y - cy) / fy)
            row[0], row[1], row[2] = b * gz - c * gy, c * gx - a * gz, a * gy - b * gx
            row[3], row[4], row[5] = gx, gy, gz
            for i in range(6):
                scaled = weight * row[i]
                gradient[i] -= scaled * across
                for j in range(i + 1):
                    normal[i, j] += scaled * row[j]
    return fit


@kernel()
def align_poses(
    lookup: Lookup, view: Ints, rotations: Floats, translations: Floats, reach_px: float, iterations: int
) -> None:
    """`align` for many poses (N, 3, 3), (N, 3), in place, each with the samples of its view."""
    for i in range(len(view)):
        align(lookup, view[i], rotations[i], translations[i], reach_px, iterations)
