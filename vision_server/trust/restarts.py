"""Whether the last step comes back to a pose that was left: a multi-start in what the lines hold least.

A pose that is right is mostly the only one near by at which lines and edges agree. One that lies on the wrong
edges is held by less than it seems: a degree beside it lines lie on others, and agree there as well. How well
the lines fit where they are tells nothing of that; where the last step ends from beside the pose does.
"""

from __future__ import annotations

import numpy as np

from geometry.pose import RIGHT, Pose
from geometry.symmetries import Symmetry, turned_towards
from numerics.two_cores import each
from vision_server.pose.covariance import about_camera
from vision_server.pose.steps import moved, step_jacobian, turning_point
from vision_server.trust.alternatives import without_free_turn
from vision_server.trust.settling import Settled, last_round, limits_of, of_true_axes

RESTARTED_MOTIONS = 2  # of six, those that the lines hold least, to either side
# By so many times what makes a pose wrong; by less where that moves a line farther, so that the last step may
# still find its edges. On frames of 640 px it is 3 to 9 px.
LEFT_BY, MOST_LEFT_BY_PX = 2.0, 9.0
MOST_ASTRAY = 3.0  # of one start, in the same unit; one that ends nowhere counts as much


def astray(last: Settled, symmetry: Symmetry) -> float:
    """How far from a pose its last step ends, from beside it, in the mean; 1 is 1 degree or 1 % of the range.

    Parameters
    ----------
    last
        The pose, after the last step.
    symmetry
        Of the target: a turn about its free axis is none.
    """
    return float(np.mean(each(lambda start: _end(last, start, symmetry), _starts(last, symmetry))))


def _starts(last: Settled, symmetry: Symmetry) -> list[Pose]:
    """Poses beside one, to either side of it in what its lines hold least."""
    pose, problem, samples = last.best.pose, last.best.problem, last.best.support.samples
    centre = turning_point(problem.model, pose)
    limits = limits_of(pose)
    covariance = about_camera(without_free_turn(last.covariance, pose, symmetry), -centre)  # undone
    _, motions = np.linalg.eigh(covariance / np.outer(limits, limits))
    jacobian = step_jacobian(problem.camera, pose.apply(samples.points), samples.normal, centre)
    out = []
    for motion in motions.T[::-1][:RESTARTED_MOTIONS]:
        step = LEFT_BY * limits * motion
        step *= min(1.0, MOST_LEFT_BY_PX / max(float(np.abs(jacobian @ step).max()), 1e-9))
        out += [moved(pose, -step, centre), moved(pose, step, centre)]
    return out


def _end(last: Settled, start: Pose, symmetry: Symmetry) -> float:
    """How far from the pose, as `astray`, the last step ends from a start."""
    look = last_round(last.best, start)
    if look is None:
        return MOST_ASTRAY
    pose, end = last.best.pose, of_true_axes(look.pose, last.best.problem.model, look.step)
    if symmetry.free_axis is not None:
        end = turned_towards(end, pose, symmetry)
    off = end.error_to(pose)
    return min(MOST_ASTRAY, max(off.rotation_deg / RIGHT[0], off.translation_fraction_of_range / RIGHT[1]))
