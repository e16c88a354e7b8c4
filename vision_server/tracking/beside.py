"""What else than a line its edge may be: print, the far side of a rounded edge, a shadow running beside it.

Where the true edge has little contrast the other one is taken for it, and its points are as straight and as
many as those of a true one; nothing in them says what they are. That there are two says that the line may be
off by what is between them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geometry.pose import Pose
from geometry.visibility import visible_samples
from vision_server.channels.gradients import Normals
from vision_server.pose.association import associate
from vision_server.pose.edge_search import search
from vision_server.pose.observation import PoseProblem
from vision_server.pose.sampling import thinned

Floats = NDArray[np.float64]

# Chosen by hand where nothing else is said.
REACH_PX = 6.0  # to either side; print farther away is seldom mistaken for an edge that is followed
APART_PX = 1.0  # edges closer than this are one
WIDTH_PX = 0.75  # of a course, to either side
LEAST_SHARE = 0.5  # of a line's samples that have an edge there
TAKEN = 0.03  # probability that the other one was taken, of an edge along the whole line; by hand, on films
SPACING_PX, MOST_SAMPLES = 4.0, 12  # of a line

COURSES = np.arange(-REACH_PX, REACH_PX + 0.25, 0.5)
COURSES = COURSES[np.abs(COURSES) >= APART_PX]


def beside_px2(problem: PoseProblem, pose: Pose) -> Floats:
    """Variance (L,) px^2 of each of L lines for the edge that runs beside its own; 0 without any.

    Parameters
    ----------
    pose
        Within a pixel or two of the right one.
    """
    lines = len(problem.model.lines)
    samples = thinned(visible_samples(problem.model, problem.camera, pose, SPACING_PX), MOST_SAMPLES)
    if len(samples.line) == 0:
        return np.zeros(lines)
    reach = np.full(len(samples.line), REACH_PX)
    scale = np.take(problem.scale, samples.line, axis=1)
    points = search(problem.channels, scale, Normals(samples.image, samples.normal, reach))
    associate(samples, lines, points.offset)
    seen = np.any(np.abs(points.offset[..., None] - COURSES) <= WIDTH_PX, axis=(0, 2))
    count = np.maximum(np.bincount(samples.line, minlength=lines), 1)
    share = np.stack(
        [np.bincount(samples.line, seen[:, k], lines) / count for k in range(len(COURSES))], axis=1
    )
    share[share < LEAST_SHARE] = 0.0
    return np.asarray((TAKEN * share * COURSES**2).max(axis=1))
