"""Where a target is if the outermost edges beside its outlines are its own, and those inside of them print.

A frame printed beside the edges of a face is as straight and as whole as they are, often of more contrast,
and parallel: the target seems smaller, and farther away. But print lies inside of an outline; that an edge of
the background runs along all of an outline, and of another one, as the target seen from nearer would, is
hardly chance.
"""

from __future__ import annotations

import numpy as np

from geometry.pose import Pose
from numerics.arrays import Floats
from vision_server.pose.observation import PoseProblem
from vision_server.pose.refinement import PRIOR_ROTATION_SD_RAD, PRIOR_TRANSLATION_SD
from vision_server.pose.roundings import outward_of
from vision_server.pose.steps import moved, step_jacobian, turning_point
from vision_server.tracking.beside import PRINT_REACH_PX, Beside
from vision_server.tracking.fitting import FIT_ITERATIONS, TAIL

OUTSIDE_PX = 1.5  # outside of a line, from where on an edge is another one than the line's (by hand)
# By hand. It runs along a parallel to the line, where at least this share of the line's samples have an edge
# point within this distance; of the outermost such parallel and so many further in, the one with most has it.
OUTER_PARALLELS_PX = np.arange(OUTSIDE_PX, PRINT_REACH_PX, 0.5)
LEAST_ON_OUTER, ON_OUTER_PX, FURTHER_IN_PARALLELS = 0.7, 1.0, 3
OUTER_SD_PX, ELSE_SD_PX = 0.5, 2.0  # of lines with an outer edge, and of those without (by hand)


def outer_edges(found: Beside, outward: Floats) -> Floats:
    """Offset outwards of the outermost edge that runs along each line, (L,) px; NaN without one.

    For ``outward`` (N,), of the samples, see `outward_of`.
    """
    share = found.share_at(OUTER_PARALLELS_PX, outward, ON_OUTER_PX)
    whole = share >= LEAST_ON_OUTER
    outlines = np.bincount(found.samples.line, outward != 0.0, found.lines)
    whole &= (2.0 * outlines > np.bincount(found.samples.line, minlength=found.lines))[:, None]
    out = np.full(found.lines, np.nan)
    for line in np.flatnonzero(whole.any(axis=1)):
        last = int(np.flatnonzero(whole[line])[-1])
        first = max(0, last - FURTHER_IN_PARALLELS)
        near = share[line, first : last + 1]
        out[line] = OUTER_PARALLELS_PX[first + int(np.flatnonzero(near == near.max())[-1])]
    return out


def outermost(problem: PoseProblem, pose: Pose, found: Beside) -> Pose | None:
    """The pose whose outlines are the outermost edges; None where no line has an edge outside of it."""
    outward = outward_of(problem.model, problem.camera, pose, found.samples)
    outer = outer_edges(found, outward)
    if np.isnan(outer).all():
        return None
    samples = found.samples
    centre = turning_point(problem.model, pose)
    rows = step_jacobian(problem.camera, pose.apply(samples.points), samples.normal, centre)
    value = outer[samples.line] * outward
    known = np.isfinite(value)
    value = np.where(known, value, 0.0)
    per_line = np.bincount(samples.line, minlength=found.lines)[samples.line]
    precision = 1.0 / (np.where(known, OUTER_SD_PX, ELSE_SD_PX) ** 2 * per_line)
    range_m = float(np.linalg.norm(pose.translation))
    prior = np.repeat([PRIOR_ROTATION_SD_RAD, PRIOR_TRANSLATION_SD * range_m], 3) ** -2.0
    step: Floats = np.zeros(6)
    factor: Floats = np.ones(len(value))
    for _ in range(FIT_ITERATIONS):
        weighted = rows * (precision * factor)[:, None]
        step = np.asarray(np.linalg.solve(weighted.T @ rows + np.diag(prior), weighted.T @ value), np.float64)
        squares = (value - rows @ step) ** 2 * precision * per_line
        factor = (TAIL + 1.0) / (TAIL + squares)
    return moved(pose, step, centre)
