"""What else than a line its edge may be: print, the far side of a rounded edge, a shadow running beside it.

Where the true edge has little contrast the other one is taken for it, and its points are as straight and as
many as those of a true one; nothing in them says what they are. That there are two says that the line may be
off by what is between them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geometry.pose import Pose
from geometry.visibility import Samples, visible_samples
from numerics.arrays import Floats, Ints
from numerics.kernels import kernel
from vision_server.channels.gradients import Normals
from vision_server.pose.association import associate
from vision_server.pose.edge_search import search
from vision_server.pose.observation import PoseProblem
from vision_server.pose.sampling import thinned

# The following were chosen by hand.
REACH_PX = 6.0  # to either side; print farther away is seldom mistaken for an edge that is followed
APART_PX = 1.0  # from the line, nearer than which an edge is the line's own
# How far from the line parallels to it run; an edge point is on one of them within this distance.
PARALLELS_PX = np.arange(-REACH_PX, REACH_PX + 0.25, 0.5)
PARALLELS_PX = PARALLELS_PX[np.abs(PARALLELS_PX) >= APART_PX]
WIDTH_PX = 0.75
LEAST_SHARE = 0.5  # of a line's samples, that need an edge point on a parallel for an edge to be there
TAKEN = 0.03  # probability that another edge along the whole line is taken for the line's own; on films
SPACING_PX, MOST_SAMPLES = 4.0, 12  # of the samples of a line


class Beside(NamedTuple):
    """Edge points around the visible ones of L lines; N samples.

    Attributes
    ----------
    offset : (C, N, K), px along the normal, NaN for none, those that are nearer to another line left out.
    """

    samples: Samples
    offset: Floats
    lines: int

    def share_at(self, parallels_px: Floats, sign: Floats, width_px: float) -> Floats:
        """Share (L, M) of each line's samples with an edge on parallels (M,) px along ``sign`` * normal."""
        return _shares(self.samples.line, self.lines, self.offset, parallels_px, sign, width_px)

    @property
    def variance_px2(self) -> Floats:
        """Of each line for the edge that runs beside its own, (L,); 0 without any."""
        share = self.share_at(PARALLELS_PX, np.ones(len(self.samples.line)), WIDTH_PX)
        share[share < LEAST_SHARE] = 0.0
        return np.asarray((TAKEN * share * PARALLELS_PX**2).max(axis=1))


@kernel()
def _shares(line: Ints, lines: int, offset: Floats, parallels: Floats, sign: Floats, width: float) -> Floats:
    """See `Beside.share_at`."""
    out, count = np.zeros((lines, len(parallels))), np.zeros(lines)
    for i in range(len(line)):
        count[line[i]] += 1.0
        for m in range(len(parallels)):
            out[line[i], m] += _is_near(offset[:, i], sign[i], parallels[m], width)
    for index in range(lines):
        out[index] /= max(count[index], 1.0)
    return out


@kernel()
def _is_near(offset: Floats, sign: float, parallel: float, width: float) -> bool:
    """Whether one of a sample's edge points (C, K) is on a parallel."""
    for c in range(len(offset)):
        for k in range(offset.shape[1]):
            if abs(sign * offset[c, k] - parallel) <= width:
                return True
    return False


def beside(problem: PoseProblem, pose: Pose) -> Beside:
    """Look around the visible lines of a pose that is within a pixel or two of the right one."""
    lines = len(problem.model.lines)
    samples = thinned(visible_samples(problem.model, problem.camera, pose, SPACING_PX), MOST_SAMPLES)
    reach = np.full(len(samples.line), REACH_PX)
    scale = np.take(problem.scale, samples.line, axis=1)
    points = search(problem.channels, scale, Normals(samples.image, samples.normal, reach))
    associate(samples, lines, points.offset)
    return Beside(samples, points.offset, lines)
