"""Multi-start hypotheses: start poses beside a pose, for rivals that no small step leads to.

Printed lines, shadow edges and double outlines run beside true edges, and a fit that took one of them for a
model line can be nearly as good as the truth. A motion that the lines hardly hold can hide another one. All
edge points in a wide band around the lines are looked for once. Steps are then tried on these points alone,
with the lines moving as their Jacobian says. Those that explain nearly as much as the pose itself are worth
another look at the images.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from geometry.pose import Pose
from geometry.visibility import Samples
from numerics.arrays import Floats
from numerics.cholesky import solve_positive
from numerics.kernels import kernel
from vision_server.channels.gradients import Normals
from vision_server.pose.edge_points import search
from vision_server.pose.hough import vote
from vision_server.pose.observation import PoseProblem
from vision_server.pose.refinement import prior_precision
from vision_server.pose.sampling import SPARSE_SPACING_PX, places_on_lines, sparse_samples
from vision_server.pose.steps import moved, step_jacobian, turning_point
from vision_server.trust.support import CAP_PX

# Chosen by hand where nothing else is said. Halved or doubled (`python -m benchmarks.constants`, 24 sets of
# recorded and hard stacks), what must agree and be explained, how far is loosened and the weight of what is
# laid change at most two poses from right to wrong or back.
BAND_PX = 24.0  # to either side of a line, in which other edges are looked for
OWN_EDGE_PX = 1.5  # an edge closer than this to the line is the line's own
ONE_EDGE_PX = 0.5  # edge points of several channels this close are one edge
ON_EDGE_PX = 1.5  # an edge point this close to a straight edge beside a line votes for it
LEAST_AGREED = 0.35  # share of a line's samples that must lie on the other edge
EDGES_A_LINE = 3  # straight edges beside it that are tried
LAID_WEIGHT = 4.0  # of a sample of the line that is laid elsewhere, against the others
LOOSENED_MOTIONS = 3  # of six, those that the lines hold least, that are tried
LOOSENED_PX = 5.0  # how far the farthest sample goes along a motion that is hardly held
MOST_LAID = 16  # edges that a line is laid on, the clearest first
FOLLOWED_REACHES_PX = (6.0, 4.0, 2.5, 2.5)  # how far an edge may be from its line while a step is followed
RETURNED_PX = 1.0  # a step that moves no line farther has come back
LEAST_EXPLAINED = 0.75  # of what the pose explains, for a step to be worth a look


@dataclass(frozen=True, eq=False)
class EdgesAround:
    """All edge points near a pose's visible lines; N samples, K edge points of each.

    Attributes
    ----------
    samples
        Points on the visible lines.
    jacobian
        (N, 6), px along the normal per (rotation rad about ``centre``, translation m).
    centre
        (3,), camera frame, metres.
    offset
        (N, K) px along the normal, ascending, NaN for no more.
    """

    samples: Samples
    jacobian: Floats
    centre: Floats
    offset: Floats


def edges_around(
    problem: PoseProblem, pose: Pose, bounds_px: tuple[float, ...] = (OWN_EDGE_PX, BAND_PX)
) -> EdgesAround:
    """Look for edges beside the lines; of each band between two bounds, ascending, the clearest few."""
    samples = sparse_samples(problem.model, problem.camera, pose)
    normal, scale = samples.normal, np.take(problem.filters, samples.line, axis=1)
    found: list[Floats] = []
    bands = [(-bounds_px[0], bounds_px[0])]
    for low, high in pairwise(bounds_px):
        bands += [(-high, -low), (low, high)]
    for low, high in bands:
        middle, reach = 0.5 * (low + high), np.full(len(normal), 0.5 * (high - low))
        points = search(problem.channels, scale, Normals(samples.image + middle * normal, normal, reach))
        found.extend(points.offset + middle)
    every = np.concatenate(found, axis=1) if found else np.empty((len(normal), 0))
    merged = _merged(np.sort(every, axis=1))  # NaN go last
    most = int(np.isfinite(merged).sum(axis=1).max(initial=0))
    centre = turning_point(problem.model, pose)
    jacobian = step_jacobian(problem.camera, pose.apply(samples.points), normal, centre)
    return EdgesAround(samples, jacobian, centre, np.ascontiguousarray(merged[:, :most]))


@kernel()
def _merged(offset: Floats) -> Floats:
    """Ascending rows (N, K) with edge points closer than ONE_EDGE_PX taken as one, the others NaN."""
    out = np.full_like(offset, np.nan)
    for i in range(len(offset)):
        kept = 0
        for value in offset[i]:
            if np.isnan(value):
                break
            if kept == 0 or value - out[i, kept - 1] > ONE_EDGE_PX:
                out[i, kept] = value
                kept += 1
    return out


def hypotheses_beside(near: EdgesAround, pose: Pose, lines: int, most: int) -> list[Pose]:
    """Poses beside ``pose`` that explain nearly as much of the edges around it, the most promising first.

    Parameters
    ----------
    near
        Around ``pose``; ``lines`` of the model.
    most
        Poses to return.
    """
    if not len(near.offset):
        return []
    px, own = near.samples.px, (np.abs(near.offset) <= OWN_EDGE_PX).any(axis=1)
    held = np.where(own, px, 0.0)
    range_m = float(np.linalg.norm(pose.translation))
    prior = prior_precision(range_m, 1.0)[:6]
    steps = loosened_steps(near.jacobian, held, prior, range_m)
    steps += laid_steps(near, held, prior, lines)
    itself = explained(near.jacobian, near.offset, px, np.zeros(6))
    promising: list[tuple[float, Floats]] = []
    for step in steps:
        followed(near.jacobian, near.offset, px, prior, step)
        share = explained(near.jacobian, near.offset, px, step) / max(itself, 1e-9)
        if share < LEAST_EXPLAINED or np.abs(near.jacobian @ step).max() < RETURNED_PX:
            continue
        if all(np.abs(near.jacobian @ (step - other)).max() >= RETURNED_PX for _, other in promising):
            promising.append((share, step))
    promising.sort(key=lambda one: -one[0])
    return [moved(pose, step, near.centre) for _, step in promising[:most]]


def loosened_steps(jacobian: Floats, weight: Floats, prior: Floats, range_m: float) -> list[Floats]:
    """Steps (6,) along each of the motions that the lines hold least, to either side, the loosest first.

    Parameters
    ----------
    jacobian, weight
        (N, 6) and (N,), of samples that are held by an edge.
    prior
        (6,), diagonal.
    """
    units = np.r_[np.ones(3), np.full(3, range_m)]  # what makes turning comparable with moving
    normal = (jacobian * weight[:, None]).T @ jacobian + np.diag(prior)
    _, loosest_first = np.linalg.eigh(normal * np.outer(units, units))
    out: list[Floats] = []
    for motion in loosest_first.T[:LOOSENED_MOTIONS]:
        step = motion * units
        step *= LOOSENED_PX / np.abs(jacobian @ step).max()
        out += [step, -step]
    return out


def laid_steps(near: EdgesAround, held: Floats, prior: Floats, lines: int) -> list[Floats]:
    """Steps (6,) that lay one line on another straight edge beside it, the clearest edges first.

    The other lines stay as near to their edges as that allows; ``held`` (N,) weighs those that have one.
    """
    samples, rows = near.samples, near.jacobian
    along, _ = places_on_lines(samples, 2.0 * SPARSE_SPACING_PX)
    found = _edges_beside(near, along, lines)
    found.sort(key=lambda edge: -edge[0])
    normal = (rows * held[:, None]).T @ rows + np.diag(prior)
    out: list[Floats] = []
    for _, line, shift in found[:MOST_LAID]:
        of_line = slice(*np.searchsorted(samples.line, (line, line + 1)))  # lines are ascending
        own, laid = rows[of_line], LAID_WEIGHT * samples.px[of_line]
        instead = (own * (laid - held[of_line])[:, None]).T @ own
        pull = own.T @ (laid * (shift[0] + shift[1] * along[of_line]))
        out.append(np.asarray(np.linalg.solve(normal + instead, pull)))
    return out


def _edges_beside(near: EdgesAround, along: Floats, lines: int) -> list[tuple[float, int, Floats]]:
    """Straight edges that run along visible lines, as (clearness, line, shift (2,) px as in `vote`)."""
    line = near.samples.line
    offset = np.where(np.abs(near.offset) > OWN_EDGE_PX, near.offset, np.nan)
    counts = np.maximum(np.bincount(line, minlength=lines), 1)
    length = np.bincount(line, weights=near.samples.px, minlength=lines)
    width = np.full(len(line), ON_EDGE_PX)
    out = []
    for _ in range(EDGES_A_LINE):
        counted = np.isfinite(offset).astype(np.float64)
        shift = vote(line, along, offset[None], counted[None], lines, BAND_PX, width)
        expected = shift[line, 0] + shift[line, 1] * along
        taken = np.abs(offset - expected[:, None]) < 2.0 * ON_EDGE_PX
        share = np.bincount(line, weights=taken.any(axis=1), minlength=lines) / counts
        clear = np.flatnonzero(share >= LEAST_AGREED).tolist()
        if not clear:
            break
        out += [(float(share[index] * np.sqrt(length[index])), index, shift[index]) for index in clear]
        offset[taken] = np.nan
    return out


@kernel()
def _nearest(offset: Floats, sample: int, place: float) -> float:
    """Signed distance from a place to the nearest edge point of a sample, of (N, K); inf without any."""
    best = np.inf
    for k in range(offset.shape[1]):
        distance = offset[sample, k] - place
        if abs(distance) < abs(best):
            best = distance
    return float(best)


@kernel()
def followed(jacobian: Floats, offset: Floats, px: Floats, prior: Floats, step: Floats) -> None:
    """Let a step (6,) settle on the edge points nearest to where it puts the lines; changed in place."""
    for reach in FOLLOWED_REACHES_PX:
        normal, pull = np.zeros((6, 6)), np.zeros(6)
        for k in range(6):
            normal[k, k] = prior[k]
        for i in range(len(offset)):
            place = 0.0
            for k in range(6):
                place += jacobian[i, k] * step[k]
            distance = _nearest(offset, i, place)
            if not abs(distance) < reach:
                continue
            share = 1.0 - (distance / reach) ** 2
            weight = px[i] * share * share
            for k in range(6):
                scaled = weight * jacobian[i, k]
                pull[k] += scaled * (place + distance)
                for m in range(k + 1):
                    normal[k, m] += scaled * jacobian[i, m]
        solved = solve_positive(normal, pull, 0.0, 0.0)
        for k in range(6):
            step[k] = solved[k]


@kernel()
def explained(jacobian: Floats, offset: Floats, px: Floats, step: Floats) -> float:
    """Mean over the visible length of 1 - d / CAP_PX; d: from the nearest edge after a step (6,), px."""
    total = 0.0
    for i in range(len(offset)):
        place = 0.0
        for k in range(6):
            place += jacobian[i, k] * step[k]
        total += px[i] * max(0.0, 1.0 - abs(_nearest(offset, i, place)) / CAP_PX)
    return float(total / px.sum())
