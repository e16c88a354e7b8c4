"""Refinement of a pose: robust least squares on edge points along the model's visible lines, again and again.

In go a start pose, a few pixels off, and the channels; out come the pose and the equations that it solves.
It is the loop of edge-based trackers (Drummond and Cipolla 2002): look for edges on the normals of visible
lines (`observation`), weigh them (`weights`), solve for the step (`solver`), and look again, less far around.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geometry.pose import Pose
from numerics.arrays import Floats
from vision_server.pose.observation import Observation, PoseProblem, observe
from vision_server.pose.sampling import spacing_for
from vision_server.pose.solver import Equations, solve_reweighted
from vision_server.pose.steps import moved
from vision_server.pose.weights import base_weights

# Chosen by hand where nothing else is said. Halved or doubled (`python -m benchmarks.constants`, 24 sets of
# recorded and hard stacks), clipping, biases, growth and prior of the rotation change at most three poses
# from right to wrong or back; a growth of 4 costs four tight ones of 15 and makes errors 1.4 times as large.
REACHES_PX = (6.0, 4.0, 3.0, 3.0)  # to either side of a line, one after the other
EXACT_REACH_PX = 3.0  # the pose is near its place when so little is looked around
CLIPPING_SD_PX = 0.8  # shift of an edge per unit of the second nuisance: clipping by the sensor
PRIOR_ROTATION_SD_RAD, PRIOR_TRANSLATION_SD = 0.3, 0.1  # of a step; the latter of the range: hardly any
FEWEST_EDGE_POINTS = 12  # of all lines, twice the unknowns of a pose
LINE_BIAS_PX = 0.03  # of a whole sharp line: shading across it, calibration, model
CLIPPED_BIAS_PX = 0.2  # of a sharp line beside saturated pixels, beyond what all of them share
BIAS_POWER = 2.0  # power of the filter's scale with which both grow: softer edges reach farther


@dataclass(frozen=True, eq=False)
class Solution:
    """A refined pose and the least-squares problem it solves.

    Attributes
    ----------
    pose
        camera_T_target.
    observation
        Taken where the last step started.
    weight
        (C, N), final weights, 1/px^2.
    tone_sd_px
        What was assumed of the first nuisance.
    moved_px
        How far the last step moved the lines, at most.
    """

    pose: Pose
    observation: Observation
    weight: Floats
    tone_sd_px: float
    moved_px: float = 0.0


def line_biases(seen: Observation) -> Floats:
    """How far each edge point may be off together with all others of its line, (C, N) px, one sd.

    By shading across the line, calibration and model; by saturation beside it; by what runs beside it. All
    grow with the filter's scale. Besides, by what the part's lines are off the model's.
    """
    growth = seen.sigma[:, seen.samples.line] ** BIAS_POWER
    clipped = seen.nuisance[:, :, 1] != 0.0
    own = np.where(clipped, CLIPPED_BIAS_PX * growth, LINE_BIAS_PX * (growth - 1.0))
    seeming = np.where(np.abs(seen.neighbours) > own, seen.neighbours, own)
    return np.asarray(np.copysign(np.hypot(seeming, seen.tolerance), seeming))


def prior_precision(range_m: float, tone_sd_px: float) -> Floats:
    """Diagonal (8,) of the prior on rotation (rad), translation (m), tone and clipping shifts (px)."""
    turn, shift = PRIOR_ROTATION_SD_RAD, PRIOR_TRANSLATION_SD * range_m
    return np.array([turn, turn, turn, shift, shift, shift, tone_sd_px, CLIPPING_SD_PX]) ** -2.0


def solve(seen: Observation, base: Floats, range_m: float, tone_sd_px: float) -> tuple[Floats, Floats]:
    """The step that brings the lines onto their edge points, see `solver`.

    A tone curve that was not undone moves each edge towards its dark side, by an amount proportional to its
    relative height, and so does clipping by the sensor (`Observation.nuisance`); both factors are estimated
    along with the pose. So is what each line as a whole is off (`line_biases`): a line that is blurred
    together with its neighbour tells little about where it is, however many edge points it has.

    Returns
    -------
    step (8,), rotation rad about the observation's centre, translation m, nuisance px; weights (C, N),
    1/px^2.
    """
    equations = Equations(
        jacobian=seen.jacobian,
        nuisance=seen.nuisance,
        offset=seen.offset,
        bias=line_biases(seen),
        line=seen.samples.line,
        base=base,
        prior=prior_precision(range_m, tone_sd_px),
    )
    step, weight = solve_reweighted(equations)
    return step, weight


def refine(
    problem: PoseProblem,
    start: Pose,
    reaches_px: Sequence[float] = REACHES_PX,
    spacing_px: float | None = None,
) -> Solution | None:
    """Refine one pose on all channels together.

    At each reach the edge points are looked for anew, visibility included, and the pose is solved for; each
    channel counts where it sees edges, by the noise of each of them, their strength and straightness.

    Parameters
    ----------
    reaches_px
        How far along the normals to look, one after the other.
    spacing_px
        Between the samples of a line; `spacing_for` unless given.

    Returns
    -------
    The refined pose, or None when there is nothing to hold on to: the model is out of sight, or fewer than
    FEWEST_EDGE_POINTS edge points are near it.
    """
    pose, solution = start, None
    spacing = spacing_for(problem.model, problem.camera, pose) if spacing_px is None else spacing_px
    for reach in reaches_px:
        seen = observe(problem, pose, reach, spacing)
        base = base_weights(seen, reach <= EXACT_REACH_PX)
        if int((base > 0).sum()) < FEWEST_EDGE_POINTS:
            return None
        step, weight = solve(seen, base, float(np.linalg.norm(pose.translation)), problem.tone_sd_px)
        if not np.isfinite(step).all():
            return None
        pose = moved(pose, step, seen.centre)
        if not pose.apply(problem.model.vertices)[:, 2].max() > 0:
            return None
        moved_px = float(np.abs(seen.jacobian @ step[:6]).max())
        solution = Solution(pose, seen, weight, problem.tone_sd_px, moved_px)
    return solution
